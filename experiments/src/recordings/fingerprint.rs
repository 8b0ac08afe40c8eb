//! Fingerprint of an engine: a hash of its samples for a small scene.

use std::path::Path;

use anyhow::{Result, anyhow};
use fdtd::scene::Scene;

use super::simulate::{RunOptions, signal};
use super::spec::{Engine, RecordingSpec};
use crate::data::cache::hash_of_samples;
use crate::run::progress::Board;

/// A small scene that touches every part of an engine: wall, layer, motion, decimation.
const PROBE: &str = r#"{
  "name": "probe",
  "grid": {"nx": 160, "ny": 150, "dx_m": 0.005, "dt_s": 8.333333333333333e-6},
  "walls": [{"points_m": [[0.20, 0.55], [0.60, 0.60]], "thickness_m": 0.02}],
  "paths": {"probe": {"start": {"x_m": 0.35, "y_m": 0.3, "heading_rad": 0.4, "v_mps": 2.0, "omega_radps": 1.0},
    "legs": [{"duration_s": 0.02, "v_mps": 2.0, "omega_radps": 1.0}]},
    "free": {"start": {"x_m": 0.3, "y_m": 0.25, "heading_rad": 0.3, "v_mps": 1.0},
    "legs": [{"duration_s": 0.2, "v_mps": 1.0, "omega_radps": 0.0}]}}
}"#;

/// Walls of a second probe for scenes with walls that are not rigid: an impedance before both kinds of slopes, and
/// branches.
const SOFT_WALLS: &str = r#"[
  {"points_m": [[0.20, 0.55], [0.40, 0.57]], "thickness_m": 0.02, "impedance_pasm": 300},
  {"points_m": [[0.20, 0.45], [0.25, 0.52]], "thickness_m": 0.02, "impedance_pasm": 300},
  {"points_m": [[0.45, 0.55], [0.60, 0.40]], "thickness_m": 0.02, "impedance_pasm": 300},
  {"points_m": [[0.20, 0.15], [0.60, 0.15]], "thickness_m": 0.02,
    "branches": [{"resistance_pasm": 90, "compliance_mppa": 4e-8}]}
]"#;

/// Drive of the probe scene for a recording. A free field takes one that is long enough for two segments, which
/// determine the samples too.
fn probe_path(spec: &RecordingSpec) -> &'static str {
    match (spec.engine, spec.free_field) {
        (Engine::Fdtd, true) => "free",
        _ => "probe",
    }
}

/// A hash of the samples that the engine computes for a small scene. It takes the place of a version number in the keys
/// of cached recordings: code with other samples has another fingerprint, code that is only faster has the same.
///
/// # Errors
/// When the probe scene does not run.
pub fn engine_fingerprint(spec: &RecordingSpec, scene: &Scene) -> Result<String> {
    let mut samples = probed(PROBE, spec, scene)?;
    let is_soft = scene.walls.iter().any(|wall| wall.impedance.is_some());
    if is_soft && spec.engine == Engine::Fdtd && !spec.free_field {
        let mut probe: serde_json::Value = serde_json::from_str(PROBE)?;
        probe["walls"] = serde_json::from_str(SOFT_WALLS)?;
        samples.extend(probed(&probe.to_string(), spec, scene)?);
    }
    Ok(hash_of_samples(&samples))
}

/// Samples of a probe scene with the choices of `spec` and `scene`.
fn probed(probe: &str, spec: &RecordingSpec, scene: &Scene) -> Result<Vec<f32>> {
    let probe = Scene::from_json(probe, Path::new("probe")).map_err(|error| anyhow!("{error}"))?;
    let spec = RecordingSpec {
        path: probe_path(spec).to_string(),
        scheme: Some(spec.scheme.unwrap_or(scene.scheme)),
        spread: Some(spec.spread.unwrap_or(scene.spread)),
        wall_model: Some(spec.wall_model.unwrap_or(scene.wall_model)),
        ..spec.clone()
    };
    let options = RunOptions {
        threads: 1,
        ..RunOptions::default()
    };
    let task = Board::new().task("probe", 1);
    signal(&probe, &spec, &options, &task)
}

#[cfg(test)]
mod tests {
    use fdtd::scheme::Scheme;
    use fdtd::walls::Impedance;

    use super::super::simulate::prepare;
    use super::*;

    #[test]
    fn the_fingerprint_of_a_scene_with_soft_walls_is_another() {
        let mut scene = Scene::from_json(PROBE, Path::new("probe")).unwrap();
        let spec = RecordingSpec::of("probe", Engine::Fdtd);
        let rigid = engine_fingerprint(&spec, &scene).unwrap();
        scene.walls[0].impedance = Some(Impedance::Real(400.0));
        assert_ne!(engine_fingerprint(&spec, &scene).unwrap(), rigid);
        // A free field has no walls.
        let free = spec.in_free_field();
        let soft = engine_fingerprint(&free, &scene).unwrap();
        scene.walls[0].impedance = None;
        assert_eq!(engine_fingerprint(&free, &scene).unwrap(), soft);
    }

    #[test]
    fn the_probe_of_a_free_field_has_segments() {
        let scene = Scene::from_json(PROBE, Path::new("probe")).unwrap();
        let spec = RecordingSpec::of("", Engine::Fdtd).in_free_field();
        let spec = RecordingSpec {
            path: probe_path(&spec).to_string(),
            ..spec
        };
        for scheme in Scheme::ALL {
            let spec = RecordingSpec {
                scheme: Some(scheme),
                ..spec.clone()
            };
            let steps = prepare(&scene, &spec, 1).unwrap().steps_total() as f64;
            let drive = scene.path(&spec.path).unwrap().duration_s() / scene.grid.dt_s;
            assert!(steps > drive + 500.0, "{scheme}: {steps} steps");
        }
    }
}
