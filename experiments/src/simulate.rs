//! From a scene and one of its drives to a recording: the glue between the waveform, the sound field and the robot.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow};
use clap::ValueEnum;
use fdtd::image_source::{self, DrivingPair, ImageSourceOptions};
use fdtd::medium::Air;
use fdtd::medium::absorbed::{LONGEST_M, Stamped};
use fdtd::medium::absorption::nepers_per_metre;
use fdtd::scene::Scene;
use fdtd::scheme::Scheme;
use fdtd::simulation::{Flow, Outcome, SOURCE_STRENGTH_M2PS, Simulation, SimulationOptions};
use fdtd::spread::Spread;
use fdtd::walls::WallModel;
use fdtd::waveform::PeriodicWaveform;
use localizer::recording::{OdometrySample, Recording, RecordingMeta};
use localizer::{Parameters, Pose, Trajectory};
use serde::{Deserialize, Serialize};

use crate::interrupt::{self, Interrupted};
use crate::progress::Task;

/// Steady error of the odometry's turn rate in the paper's simulation, rad/s.
pub const ODOMETRY_BIAS_RADPS: f64 = 0.01;

/// Rate at which odometry and truth are recorded, Hz.
const ODOMETRY_RATE_HZ: f64 = 50.0;

/// Pause between two checkpoints.
const CHECKPOINT_PERIOD: Duration = Duration::from_secs(60);

/// What computes the sound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Engine {
    /// The sound field by finite differences.
    Fdtd,
    /// Image sources up to second order: seconds instead of minutes, without diffraction.
    ImageSource,
}

impl Engine {
    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fdtd => "fdtd",
            Self::ImageSource => "image-source",
        }
    }
}

/// What is recorded, and how.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Take {
    /// Drive path of the scene.
    pub path: String,
    /// What computes the sound.
    pub engine: Engine,
    /// Scheme of the field; the scene's when absent.
    #[serde(skip)]
    pub scheme: Option<Scheme>,
    /// Spreading of source and receiver; the scene's when absent.
    #[serde(skip)]
    pub spread: Option<Spread>,
    /// With the source strength times the time since the middle of the drive; see [`fdtd::medium::absorbed`].
    #[serde(skip)]
    pub stamped: bool,
    /// How walls become cells of the field; the scene's way when absent.
    #[serde(skip)]
    pub wall_model: Option<WallModel>,
    /// Without walls: the direct wave alone.
    pub free_field: bool,
    /// Steady error of the odometry's turn rate, rad/s.
    pub odometry_bias_radps: f64,
}

impl Take {
    /// The sound field on a path with the scene's own choices.
    pub fn of(path: &str, engine: Engine) -> Self {
        Self {
            path: path.to_string(),
            engine,
            scheme: None,
            spread: None,
            stamped: false,
            wall_model: None,
            free_field: false,
            odometry_bias_radps: ODOMETRY_BIAS_RADPS,
        }
    }

    /// The same with the sound stamped by the time of sending.
    pub fn stamped(&self) -> Self {
        Self {
            stamped: true,
            ..self.clone()
        }
    }

    /// The same without walls.
    pub fn in_free_field(&self) -> Self {
        Self {
            free_field: true,
            ..self.clone()
        }
    }
}

/// Where a simulation leaves its state when it is interrupted.
#[derive(Debug, Clone)]
pub struct Checkpoint {
    /// The file.
    pub path: PathBuf,
    /// Whether to go on from a file that is there.
    pub resume: bool,
}

/// Pictures of the field during a simulation.
#[derive(Debug, Clone)]
pub struct Snapshots {
    /// Folder of the pictures.
    pub folder: PathBuf,
    /// Time between two pictures, seconds of the drive.
    pub every_s: f64,
}

/// Parameters of the localizer with the waveform, rate and medium of a scene.
pub fn parameters_of(scene: &Scene, base: &Parameters) -> Parameters {
    Parameters {
        sample_rate_hz: scene.sample_rate_hz,
        code_length: scene.waveform.code_length as usize,
        chip_rate_hz: scene.waveform.chip_rate_hz,
        carrier_hz: scene.waveform.carrier_hz,
        speed_of_sound_mps: scene.medium.c_mps,
        sensor_offset_m: [0, 1].map(|axis| {
            0.5 * (scene.robot.loudspeaker_offset_m[axis] + scene.robot.microphone_offset_m[axis])
        }),
        ..base.clone()
    }
}

/// The source strength over time, relative to [`SOURCE_STRENGTH_M2PS`]: the transmitted M-sequence signal within the scene's band.
///
/// # Errors
/// When the scene's waveform is none that the localizer can make.
pub fn source_waveform(scene: &Scene) -> Result<PeriodicWaveform> {
    let parameters = parameters_of(scene, &Parameters::default());
    parameters.check().context("waveform of the scene")?;
    let samples = localizer::waveform::transmit_period(&parameters);
    Ok(PeriodicWaveform::with_band(
        &samples,
        parameters.period_s(),
        scene.waveform.band_hz,
        1.0 / scene.grid.dt_s,
    ))
}

/// Options of the field for a take.
fn field_options(take: &Take, threads: usize) -> SimulationOptions {
    SimulationOptions {
        scheme: take.scheme,
        spread: take.spread,
        wall_model: take.wall_model,
        threads,
        free_field: take.free_field,
        stamped: take.stamped,
        ..SimulationOptions::default()
    }
}

/// A field simulation that has not started.
///
/// # Errors
/// When the scene has no such path or the field refuses it.
pub fn prepare(scene: &Scene, take: &Take, threads: usize) -> Result<Simulation> {
    let waveform = source_waveform(scene)?;
    Ok(Simulation::new(
        scene,
        &take.path,
        &waveform,
        &field_options(take, threads),
    )?)
}

/// Microphone signal of a take at the scene's sample rate.
///
/// # Errors
/// [`Interrupted`] after the checkpoint was written; otherwise what the field refuses.
pub fn signal(
    scene: &Scene,
    take: &Take,
    threads: usize,
    checkpoint: Option<&Checkpoint>,
    snapshots: Option<&Snapshots>,
    task: &Task,
) -> Result<Vec<f32>> {
    match take.engine {
        Engine::Fdtd => field_signal(scene, take, threads, checkpoint, snapshots, task),
        Engine::ImageSource => image_signal(scene, take),
    }
}

/// The signal by image sources. Without walls it is the direct wave, which a coincident pair does not have here.
fn image_signal(scene: &Scene, take: &Take) -> Result<Vec<f32>> {
    let walls: &[fdtd::walls::Wall] = if take.free_field { &[] } else { &scene.walls };
    if let Some(index) = walls.iter().position(|wall| wall.impedance_pasm.is_some()) {
        anyhow::bail!(
            "walls[{index}] has an impedance, but image sources know rigid walls only; use --engine fdtd or make it rigid"
        );
    }
    let drive = DrivingPair {
        path: scene.path(&take.path)?,
        loudspeaker_offset_m: scene.robot.loudspeaker_offset_m,
        microphone_offset_m: scene.robot.microphone_offset_m,
    };
    let mut signal = image_source::synthesize(
        walls,
        &drive,
        &source_waveform(scene)?,
        &scene.medium,
        scene.sample_rate_hz,
        &ImageSourceOptions {
            stamped: take.stamped,
            ..ImageSourceOptions::default()
        },
    );
    for sample in &mut signal {
        *sample *= SOURCE_STRENGTH_M2PS as f32;
    }
    Ok(signal)
}

/// The signal by the sound field.
fn field_signal(
    scene: &Scene,
    take: &Take,
    threads: usize,
    checkpoint: Option<&Checkpoint>,
    snapshots: Option<&Snapshots>,
    task: &Task,
) -> Result<Vec<f32>> {
    let mut simulation = prepare(scene, take, threads)?;
    task.set_length(simulation.steps_total());
    if let Some(checkpoint) = checkpoint
        && checkpoint.resume
        && checkpoint.path.exists()
    {
        simulation.load_checkpoint(&checkpoint.path)?;
    }
    let mut saved = Instant::now();
    let mut next_picture_s = 0.0;
    let mut trouble: Option<anyhow::Error> = None;
    let outcome = simulation.run(&mut |progress, simulation| {
        task.set(progress.step);
        let t_s = simulation.time_s();
        let mut duties = || -> Result<()> {
            if let Some(checkpoint) = checkpoint
                && saved.elapsed() > CHECKPOINT_PERIOD
            {
                saved = Instant::now();
                save(simulation, &checkpoint.path)?;
            }
            if let Some(snapshots) = snapshots
                && t_s >= next_picture_s
                && simulation.is_listening()
            {
                next_picture_s =
                    (t_s / snapshots.every_s).floor() * snapshots.every_s + snapshots.every_s;
                let frame = simulation.pressure_frame();
                crate::figures::snapshot::draw(scene, &take.path, t_s, &frame, &snapshots.folder)?;
            }
            Ok(())
        };
        match duties() {
            Ok(()) if interrupt::requested() => Flow::Stop,
            Ok(()) => Flow::Continue,
            Err(error) => {
                trouble = Some(error);
                Flow::Stop
            }
        }
    })?;
    if let Some(error) = trouble {
        return Err(error);
    }
    match outcome {
        Outcome::Finished => {
            if let Some(snapshots) = snapshots {
                crate::figures::animation::animate(&snapshots.folder)?;
            }
            Ok(simulation.signal())
        }
        Outcome::Stopped => {
            if let Some(checkpoint) = checkpoint {
                save(&simulation, &checkpoint.path)?;
            }
            Err(Interrupted.into())
        }
    }
}

/// The signal of a take with what the air absorbs, from it and its stamped twin ([`Take::stamped`]).
///
/// # Errors
/// When the scene has no such path.
pub fn absorbed(
    scene: &Scene,
    take: &Take,
    plain: &[f32],
    stamped: &[f32],
    air: &Air,
) -> Result<Vec<f32>> {
    let signals = Stamped {
        plain,
        stamped,
        middle_s: 0.5 * scene.path(&take.path)?.duration_s(),
        sample_rate_hz: scene.sample_rate_hz,
    };
    let alpha = |frequency_hz: f64| nepers_per_metre(air, frequency_hz);
    Ok(signals.absorbed(scene.medium.c_mps, &alpha))
}

/// Writes the air that absorbed into a recording's provenance.
pub fn tell_air(recording: &mut Recording, air: &Air) {
    recording.meta.provenance["absorption"] = serde_json::json!({
        "formula": "ISO 9613-1",
        "temperature_degc": air.temperature_degc,
        "relative_humidity_percent": air.relative_humidity_percent,
        "pressure_pa": air.pressure_pa,
        "longest_path_m": LONGEST_M,
    });
}

/// Saves a checkpoint, making its folder.
fn save(simulation: &Simulation, path: &Path) -> Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    Ok(simulation.save_checkpoint(path)?)
}

/// The recording of a drive with this signal: biased odometry, truth, waveform and provenance.
///
/// # Errors
/// When the scene has no such path.
pub fn recording(scene: &Scene, take: &Take, signal: Vec<f32>, seconds: f64) -> Result<Recording> {
    let path = scene.path(&take.path)?;
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
                omega_radps: state.omega_radps + take.odometry_bias_radps,
            }
        })
        .collect();
    let parameters = parameters_of(scene, &Parameters::default());
    Ok(Recording {
        signal,
        direct: None,
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
                "path": take.path,
                "engine": take.engine,
                "scheme": take.scheme.unwrap_or(scene.scheme),
                "spread": take.spread.unwrap_or(scene.spread),
                "wall_model": take.wall_model.unwrap_or(scene.wall_model),
                "free_field": take.free_field,
                "odometry_bias_radps": take.odometry_bias_radps,
                "seconds": (seconds * 10.0).round() / 10.0,
            }),
            ..RecordingMeta::from_parameters(&parameters)
        },
    })
}

/// Seconds that the simulation of a recording took, as its provenance tells; 0 when it does not.
pub fn simulation_seconds(recording: &Recording) -> f64 {
    recording.meta.provenance["seconds"].as_f64().unwrap_or(0.0)
}

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
    let probe = Scene::from_json(PROBE, Path::new("probe")).map_err(|error| anyhow!("{error}"))?;
    let take = Take {
        path: probe_path(take).to_string(),
        scheme: Some(take.scheme.unwrap_or(scene.scheme)),
        spread: Some(take.spread.unwrap_or(scene.spread)),
        wall_model: Some(take.wall_model.unwrap_or(scene.wall_model)),
        ..take.clone()
    };
    let task = crate::progress::Board::new().task("probe", 1);
    let samples = signal(&probe, &take, 1, None, None, &task)?;
    Ok(crate::cache::hash_of_samples(&samples))
}

#[cfg(test)]
mod tests {
    use super::*;

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
