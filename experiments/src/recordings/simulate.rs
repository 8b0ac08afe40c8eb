//! From a scene and one of its drives to the microphone's signal, by the sound field or by image sources.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Result;
use fdtd::scene::Scene;
use fdtd::simulation::{Flow, Outcome, Simulation, SimulationOptions};
use oracles::image_source::{self, DrivingPair, ImageSourceOptions};

use super::spec::{Engine, RecordingSpec};
use super::waveform::source_waveform;
use crate::data::atomic;
use crate::data::field_frame::FieldFrame;
use crate::run::interrupt::{self, Interrupted};
use crate::run::progress::Task;

/// Pause between two checkpoints.
const CHECKPOINT_PERIOD: Duration = Duration::from_secs(60);

/// State of a simulation on disk, to resume it after an interruption.
#[derive(Debug, Clone)]
pub struct Checkpoint {
    /// The file.
    pub path: PathBuf,
    /// Whether to resume from a file that exists.
    pub resume: bool,
}

/// Frames of the field during a simulation.
#[derive(Clone, Copy)]
pub struct Snapshots<'a> {
    /// Time between two frames, seconds of the drive.
    pub every_s: f64,
    /// Receives each frame; its error ends the simulation.
    pub receive: &'a dyn Fn(&FieldFrame) -> Result<()>,
}

/// How a simulation is run; no option changes the signal.
#[derive(Clone, Copy, Default)]
pub struct RunOptions<'a> {
    /// Threads at the start; 0 takes all.
    pub threads: usize,
    /// Number of threads that became free for this simulation since the last call.
    pub freed: Option<&'a (dyn Fn() -> usize + Sync)>,
    /// Checkpoint to write and to resume from.
    pub checkpoint: Option<&'a Checkpoint>,
    /// Frames of the field.
    pub snapshots: Option<Snapshots<'a>>,
}

/// Options of the field for a recording.
fn field_options(spec: &RecordingSpec, threads: usize) -> SimulationOptions {
    SimulationOptions {
        scheme: spec.scheme,
        spread: spec.spread,
        wall_model: spec.wall_model,
        threads,
        free_field: spec.free_field,
        whole_domain: spec.whole_domain,
        stamped: spec.stamped,
        ..SimulationOptions::default()
    }
}

/// A field simulation at its start, on `threads` threads (0 takes all).
///
/// # Errors
/// When the scene has no such path or the field refuses it.
pub fn prepare(scene: &Scene, spec: &RecordingSpec, threads: usize) -> Result<Simulation> {
    let waveform = source_waveform(scene)?;
    Ok(Simulation::new(
        scene,
        &spec.path,
        &waveform,
        &field_options(spec, threads),
    )?)
}

/// Microphone signal of a recording at the scene's sample rate.
///
/// # Errors
/// [`Interrupted`] after the checkpoint was written; or when the field refuses the scene.
pub fn signal(
    scene: &Scene,
    spec: &RecordingSpec,
    options: &RunOptions<'_>,
    task: &Task,
) -> Result<Vec<f32>> {
    match spec.engine {
        Engine::Fdtd => field_signal(scene, spec, options, task),
        Engine::ImageSource => image_signal(scene, spec),
    }
}

/// The signal by image sources, with the direct wave of a pair that is apart.
///
/// # Errors
/// When a wall is not rigid, or the scene has no such path.
pub fn image_signal(scene: &Scene, spec: &RecordingSpec) -> Result<Vec<f32>> {
    let walls: &[fdtd::walls::Wall] = if spec.free_field { &[] } else { &scene.walls };
    if let Some(index) = walls.iter().position(|wall| wall.impedance.is_some()) {
        anyhow::bail!(
            "walls[{index}] has an impedance, but image sources know rigid walls only; use --engine fdtd or \
            make it rigid"
        );
    }
    let drive = DrivingPair {
        path: scene.path(&spec.path)?,
        loudspeaker_offset_m: scene.robot.loudspeaker_offset_m,
        microphone_offset_m: scene.robot.microphone_offset_m,
    };
    // In pascals, as the field's: the source strength is in it.
    Ok(image_source::synthesize(
        walls,
        &drive,
        &source_waveform(scene)?,
        &scene.medium,
        scene.sample_rate_hz,
        &ImageSourceOptions {
            max_order: spec.image_order,
            include_direct: true,
            stamped: spec.stamped,
            ..ImageSourceOptions::default()
        },
    ))
}

/// The signal by the sound field.
fn field_signal(
    scene: &Scene,
    spec: &RecordingSpec,
    options: &RunOptions<'_>,
    task: &Task,
) -> Result<Vec<f32>> {
    let RunOptions {
        checkpoint,
        snapshots,
        ..
    } = *options;
    let mut simulation = prepare(scene, spec, options.threads)?;
    task.set_length(simulation.steps_total());
    if let Some(checkpoint) = checkpoint
        && checkpoint.resume
        && checkpoint.path.exists()
    {
        simulation.load_checkpoint(&checkpoint.path)?;
    }
    let mut saved = Instant::now();
    // The field runs a little longer than the drive, for the filter; frames end with the drive.
    let end_s = scene.path(&spec.path)?.duration_s();
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
                keep(simulation, checkpoint, task);
            }
            if let Some(snapshots) = snapshots
                && simulation.is_look()
                && simulation.time_s() <= end_s
            {
                (snapshots.receive)(&FieldFrame::of(simulation))?;
            }
            Ok(())
        };
        match duties() {
            Ok(()) if interrupt::requested() => Flow::Stop,
            Ok(()) => match options.freed.map_or(0, |freed| freed()) {
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
        if let Some(checkpoint) = checkpoint {
            keep(&simulation, checkpoint, task);
        }
        return Err(error);
    }
    match (outcome, checkpoint) {
        (Outcome::Finished, checkpoint) => {
            // The recording is still to be written: where that fails, nothing has to be simulated again.
            if let Some(checkpoint) = checkpoint {
                keep(&simulation, checkpoint, task);
            }
            Ok(simulation.signal())
        }
        (Outcome::Stopped, Some(checkpoint)) => {
            save(&simulation, &checkpoint.path)?;
            Err(Interrupted.into())
        }
        (Outcome::Stopped, None) => Err(Interrupted.into()),
    }
}

/// Saves a checkpoint. Where that fails the simulation goes on: it has lost nothing yet.
fn keep(simulation: &Simulation, checkpoint: &Checkpoint, task: &Task) {
    if let Err(error) = save(simulation, &checkpoint.path) {
        task.say(format!("warning: no checkpoint: {error:#}"));
    }
}

/// Saves a checkpoint; creates its folder.
fn save(simulation: &Simulation, path: &Path) -> Result<()> {
    atomic::write_with(path, |temporary| {
        let mut file = std::io::BufWriter::new(std::fs::File::create(temporary)?);
        simulation.write_checkpoint(&mut file)?;
        Ok(file.into_inner()?.sync_all()?)
    })
}
