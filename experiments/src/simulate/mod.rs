//! From a scene and one of its drives to a recording: the glue between the waveform, the sound field and the robot.

mod print;
mod recording;
mod take;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use fdtd::scene::Scene;
use fdtd::simulation::{Flow, Outcome, SOURCE_STRENGTH_M2PS, Simulation, SimulationOptions};
use fdtd::waveform::PeriodicWaveform;
use localizer::Parameters;
use localizer::parameters::SignalParameters;
use oracles::image_source::{self, DrivingPair, ImageSourceOptions};

use crate::figures::{self, snapshot::Frame};
use crate::interrupt::{self, Interrupted};
use crate::progress::Task;

pub use self::print::engine_print;
pub use self::recording::{absorbed, recording, simulation_seconds, tell_air};
pub use self::take::{Engine, IMAGE_ORDER, ODOMETRY_BIAS_RADPS, Take};

/// Pause between two checkpoints.
const CHECKPOINT_PERIOD: Duration = Duration::from_secs(60);

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

/// How a simulation is run; nothing of it changes what is heard.
#[derive(Clone, Copy, Default)]
pub struct Running<'a> {
    /// Threads to begin with; 0 takes all.
    pub threads: usize,
    /// How many threads others have left to this simulation since the last call.
    pub freed: Option<&'a (dyn Fn() -> usize + Sync)>,
    /// Where its state is kept.
    pub checkpoint: Option<&'a Checkpoint>,
    /// Pictures on the way.
    pub snapshots: Option<&'a Snapshots>,
}

/// Parameters of the localizer with the waveform, rate and medium of a scene.
pub fn parameters_of(scene: &Scene, base: &Parameters) -> Parameters {
    Parameters {
        signal: SignalParameters {
            sample_rate_hz: scene.sample_rate_hz,
            code_length: scene.waveform.code_length as usize,
            chip_rate_hz: scene.waveform.chip_rate_hz,
            carrier_hz: scene.waveform.carrier_hz,
            speed_of_sound_mps: scene.medium.c_mps,
            sensor_offset_m: [0, 1].map(|axis| {
                0.5 * (scene.robot.loudspeaker_offset_m[axis]
                    + scene.robot.microphone_offset_m[axis])
            }),
        },
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
    let samples = localizer::signal::waveform::transmit_period(&parameters.signal);
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
        whole_domain: take.whole_domain,
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
pub fn signal(scene: &Scene, take: &Take, running: &Running<'_>, task: &Task) -> Result<Vec<f32>> {
    match take.engine {
        Engine::Fdtd => field_signal(scene, take, running, task),
        Engine::ImageSource => image_signal(scene, take),
    }
}

/// The signal by image sources. Without walls it is the direct wave, which a coincident pair does not have here.
fn image_signal(scene: &Scene, take: &Take) -> Result<Vec<f32>> {
    let walls: &[fdtd::walls::Wall] = if take.free_field { &[] } else { &scene.walls };
    if let Some(index) = walls.iter().position(|wall| wall.impedance.is_some()) {
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
            max_order: take.image_order,
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
    running: &Running<'_>,
    task: &Task,
) -> Result<Vec<f32>> {
    let Running {
        checkpoint,
        snapshots,
        ..
    } = *running;
    let mut simulation = prepare(scene, take, running.threads)?;
    task.set_length(simulation.steps_total());
    if let Some(checkpoint) = checkpoint
        && checkpoint.resume
        && checkpoint.path.exists()
    {
        simulation.load_checkpoint(&checkpoint.path)?;
    }
    let mut saved = Instant::now();
    // The field goes on a little beyond the end of the drive, for the filter; pictures do not.
    let end_s = scene.path(&take.path)?.duration_s();
    if let Some(snapshots) = snapshots {
        simulation.look_every(snapshots.every_s);
    }
    let mut trouble: Option<anyhow::Error> = None;
    let outcome = simulation.run(&mut |progress, simulation| {
        task.set(progress.step);
        let mut duties = || -> Result<()> {
            if let Some(checkpoint) = checkpoint
                && saved.elapsed() > CHECKPOINT_PERIOD
            {
                saved = Instant::now();
                save(simulation, &checkpoint.path)?;
            }
            if let Some(snapshots) = snapshots
                && simulation.is_look()
                && simulation.time_s() <= end_s
            {
                let frame = Frame::of(simulation);
                figures::snapshot::draw(scene, &take.path, &frame, &snapshots.folder)?;
            }
            Ok(())
        };
        match duties() {
            Ok(()) if interrupt::requested() => Flow::Stop,
            Ok(()) => match running.freed.map_or(0, |freed| freed()) {
                0 => Flow::Continue,
                more => Flow::OnThreads(simulation.threads() + more),
            },
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
                figures::animation::animate(&snapshots.folder)?;
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

/// Saves a checkpoint, making its folder.
fn save(simulation: &Simulation, path: &Path) -> Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    Ok(simulation.save_checkpoint(path)?)
}
