//! From a microphone signal to a recording: odometry, truth, provenance, and absorption by the air.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use fdtd::medium::Air;
use fdtd::medium::absorbed::{LONGEST_M, Stamped};
use fdtd::medium::absorption::nepers_per_metre;
use fdtd::scene::Scene;
use localizer::odometry::OdometrySample;
use localizer::recording::{Recording, RecordingMeta};
use localizer::{Parameters, Pose, Trajectory};

use super::robot::Robot;
use super::spec::RecordingSpec;
use super::waveform::parameters_of;
use crate::data::atomic;
use crate::data::manifest::Manifest;

/// Rate at which odometry and truth are recorded, Hz.
const ODOMETRY_RATE_HZ: f64 = 50.0;

/// The signal with absorption by the air, from the plain signal and its stamped twin ([`RecordingSpec::stamped`]).
///
/// # Errors
/// When the scene has no such path.
pub fn absorbed(
    scene: &Scene,
    spec: &RecordingSpec,
    plain: &[f32],
    stamped: &[f32],
    air: &Air,
) -> Result<Vec<f32>> {
    let signals = Stamped {
        plain,
        stamped,
        middle_s: 0.5 * scene.path(&spec.path)?.duration_s(),
        sample_rate_hz: scene.sample_rate_hz,
    };
    let alpha = |frequency_hz: f64| nepers_per_metre(air, frequency_hz);
    Ok(signals.absorbed(scene.medium.c_mps, &alpha))
}

/// Notes the air that absorbed in a recording's provenance.
pub fn note_air(recording: &mut Recording, air: &Air) {
    recording.meta.provenance["absorption"] = serde_json::json!({
        "formula": "ISO 9613-1",
        "temperature_degc": air.temperature_degc,
        "relative_humidity_percent": air.relative_humidity_percent,
        "pressure_pa": air.pressure_pa,
        "longest_path_m": LONGEST_M,
    });
}

/// What a recording has beside the sound among the walls.
#[derive(Debug, Clone, Copy, Default)]
pub struct Extras<'a> {
    /// The air that absorbs.
    pub air: Option<&'a Air>,
    /// The same drive without walls.
    pub with_direct: bool,
    /// The robot whose instruments replace ideal ones.
    pub robot: Option<&'a Robot>,
}

/// The recording of a drive; `simulate` gives the signal of each of the drives that it takes: without walls for the
/// direct wave, and stamped twins for absorption.
///
/// # Errors
/// Those of `simulate`, and when the scene has no such path.
pub fn record(
    scene: &Scene,
    spec: &RecordingSpec,
    extras: &Extras<'_>,
    simulate: &mut dyn FnMut(&RecordingSpec) -> Result<Vec<f32>>,
) -> Result<Recording> {
    let started = Instant::now();
    let mut heard = |spec: &RecordingSpec| -> Result<Vec<f32>> {
        let plain = simulate(spec)?;
        match extras.air {
            Some(air) => absorbed(scene, spec, &plain, &simulate(&spec.stamped())?, air),
            None => Ok(plain),
        }
    };
    let signal = heard(spec)?;
    let direct = match extras.with_direct {
        true => Some(heard(&spec.in_free_field())?),
        false => None,
    };
    let mut recording = recording(scene, spec, signal, started.elapsed().as_secs_f64())?;
    recording.direct = direct;
    if let Some(air) = extras.air {
        note_air(&mut recording, air);
    }
    if let Some(robot) = extras.robot {
        robot.apply(&mut recording, scene.path(&spec.path)?, &spec.path);
    }
    Ok(recording)
}

/// Writes a recording into its folder, with the manifest that tells it from other people's files; by a robot's sound
/// card where it has one.
///
/// # Errors
/// When a file cannot be written.
pub fn write(recording: &Recording, robot: Option<(&Robot, &str)>, folder: &Path) -> Result<()> {
    atomic::write_folder(folder, |folder| {
        match robot {
            Some((robot, path)) => robot.write(recording, path, folder)?,
            None => recording.write(folder)?,
        }
        Manifest::of(folder)?.write(folder)
    })
}

/// The recording of a drive with this signal: biased odometry, truth, waveform and provenance. `seconds` is the time
/// that the simulation took.
///
/// # Errors
/// When the scene has no such path.
pub fn recording(
    scene: &Scene,
    spec: &RecordingSpec,
    signal: Vec<f32>,
    seconds: f64,
) -> Result<Recording> {
    let path = scene.path(&spec.path)?;
    let count = (path.duration_s() * ODOMETRY_RATE_HZ).ceil() as usize;
    let times: Vec<f64> = (0..=count)
        .map(|index| index as f64 / ODOMETRY_RATE_HZ)
        .collect();
    let pose = |t_s: f64| {
        let state = path.state_at(t_s);
        Pose {
            x_m: state.x_m,
            y_m: state.y_m,
            heading_rad: state.heading_rad,
        }
    };
    let odometry = times
        .iter()
        .map(|&t_s| {
            let state = path.state_at(t_s);
            OdometrySample {
                t_s,
                v_mps: state.v_mps,
                omega_radps: state.omega_radps + spec.odometry_bias_radps,
            }
        })
        .collect();
    let parameters = parameters_of(scene, &Parameters::default());
    Ok(Recording {
        signal,
        direct: None,
        unheard: Vec::new(),
        odometry,
        truth: Some(Trajectory {
            poses: times.iter().map(|&t_s| pose(t_s)).collect(),
            t_s: times,
        }),
        meta: RecordingMeta {
            start: Some(pose(0.0)),
            loudspeaker_offset_m: scene.robot.loudspeaker_offset_m,
            microphone_offset_m: scene.robot.microphone_offset_m,
            provenance: serde_json::json!({
                "program": format!("echolot {}", env!("CARGO_PKG_VERSION")),
                "scene": scene.name,
                "path": spec.path,
                "engine": spec.engine,
                "scheme": spec.scheme.unwrap_or(scene.scheme),
                "spread": spec.spread.unwrap_or(scene.spread),
                "wall_model": spec.wall_model.unwrap_or(scene.wall_model),
                "free_field": spec.free_field,
                "odometry_bias_radps": spec.odometry_bias_radps,
                "seconds": (seconds * 10.0).round() / 10.0,
            }),
            ..RecordingMeta::from_parameters(&parameters)
        },
    })
}

/// Seconds that the simulation of a recording took, from its provenance; 0 when they are not there.
pub fn simulation_seconds(recording: &Recording) -> f64 {
    recording.meta.provenance["seconds"].as_f64().unwrap_or(0.0)
}
