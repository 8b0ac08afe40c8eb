//! What an engine computes, as a hash.

use std::path::Path;

use anyhow::{Result, anyhow};
use fdtd::scene::Scene;

use super::{Engine, Running, Take, signal};

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

/// The walls of a second probe for scenes with walls that are not rigid: an impedance before both kinds of slopes, and branches.
const SOFT_WALLS: &str = r#"[
  {"points_m": [[0.20, 0.55], [0.40, 0.57]], "thickness_m": 0.02, "impedance_pasm": 300},
  {"points_m": [[0.20, 0.45], [0.25, 0.52]], "thickness_m": 0.02, "impedance_pasm": 300},
  {"points_m": [[0.45, 0.55], [0.60, 0.40]], "thickness_m": 0.02, "impedance_pasm": 300},
  {"points_m": [[0.20, 0.15], [0.60, 0.15]], "thickness_m": 0.02,
    "branches": [{"resistance_pasm": 90, "compliance_mppa": 4e-8}]}
]"#;

/// Drive of the probe scene for a take. A free field has one that is long enough for two pieces, for they determine what is heard too.
fn probe_path(take: &Take) -> &'static str {
    match (take.engine, take.free_field) {
        (Engine::Fdtd, true) => "free",
        _ => "probe",
    }
}

/// A hash of what the engine computes for a small scene. It takes the place of a version number in the keys of cached
/// recordings: code that gives other samples gives another print, code that is only faster or cleaner does not.
///
/// # Errors
/// When the probe scene does not run.
pub fn engine_print(take: &Take, scene: &Scene) -> Result<String> {
    let mut samples = probed(PROBE, take, scene)?;
    let is_soft = scene.walls.iter().any(|wall| wall.impedance.is_some());
    if is_soft && take.engine == Engine::Fdtd && !take.free_field {
        let mut probe: serde_json::Value = serde_json::from_str(PROBE)?;
        probe["walls"] = serde_json::from_str(SOFT_WALLS)?;
        samples.extend(probed(&probe.to_string(), take, scene)?);
    }
    Ok(crate::cache::hash_of_samples(&samples))
}

/// What is heard in a probe scene by a take of `scene`.
fn probed(probe: &str, take: &Take, scene: &Scene) -> Result<Vec<f32>> {
    let probe = Scene::from_json(probe, Path::new("probe")).map_err(|error| anyhow!("{error}"))?;
    let take = Take {
        path: probe_path(take).to_string(),
        scheme: Some(take.scheme.unwrap_or(scene.scheme)),
        spread: Some(take.spread.unwrap_or(scene.spread)),
        wall_model: Some(take.wall_model.unwrap_or(scene.wall_model)),
        ..take.clone()
    };
    let running = Running {
        threads: 1,
        ..Running::default()
    };
    let task = crate::progress::Board::new().task("probe", 1);
    signal(&probe, &take, &running, &task)
}

#[cfg(test)]
mod tests {
    use fdtd::scheme::Scheme;
    use fdtd::walls::Impedance;

    use super::super::prepare;
    use super::*;

    #[test]
    fn the_print_of_a_scene_with_soft_walls_is_another() {
        let mut scene = Scene::from_json(PROBE, Path::new("probe")).unwrap();
        let take = Take::of("probe", Engine::Fdtd);
        let rigid = engine_print(&take, &scene).unwrap();
        scene.walls[0].impedance = Some(Impedance::Real(400.0));
        assert_ne!(engine_print(&take, &scene).unwrap(), rigid);
        // A free field hears no walls.
        let free = take.in_free_field();
        let soft = engine_print(&free, &scene).unwrap();
        scene.walls[0].impedance = None;
        assert_eq!(engine_print(&free, &scene).unwrap(), soft);
    }

    #[test]
    fn the_probe_of_a_free_field_has_pieces() {
        let scene = Scene::from_json(PROBE, Path::new("probe")).unwrap();
        let take = Take::of("", Engine::Fdtd).in_free_field();
        let take = Take {
            path: probe_path(&take).to_string(),
            ..take
        };
        for scheme in Scheme::ALL {
            let take = Take {
                scheme: Some(scheme),
                ..take.clone()
            };
            let steps = prepare(&scene, &take, 1).unwrap().steps_total() as f64;
            let drive = scene.path(&take.path).unwrap().duration_s() / scene.grid.dt_s;
            assert!(steps > drive + 500.0, "{scheme}: {steps} steps");
        }
    }
}
