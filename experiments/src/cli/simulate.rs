//! `echolot simulate`.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use fdtd::medium::{Air, STANDARD_PRESSURE_PA};
use fdtd::scene::Scene;
use fdtd::scheme::Scheme;
use fdtd::simulation::Simulation;
use fdtd::spread::Spread;
use fdtd::walls::WallModel;

use super::arguments::{EngineArguments, ForceArgument, named, threads};
use super::output::print_json;
use crate::data::field_frame::FieldFrame;
use crate::data::place::Place;
use crate::figures;
use crate::figures::drawing::png;
use crate::recordings::preflight;
use crate::recordings::recording::{self, Extras, record};
use crate::recordings::robot::Robot;
use crate::recordings::simulate::{Checkpoint, RunOptions, Snapshots, signal};
use crate::recordings::spec::{Engine, ODOMETRY_BIAS_RADPS, RecordingSpec};
use crate::run::progress::{Board, duration};
use crate::schedule;

/// Arguments of `simulate`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot simulate scenes/quick.json --path localization -o recordings/quick\n\n\
    An interrupted simulation leaves a checkpoint beside the recording; the same command with --resume goes on \
    and gives the same bytes."
)]
pub(crate) struct Arguments {
    /// The scene file.
    scene: PathBuf,
    /// Drive path of the scene.
    #[arg(long, value_name = "NAME")]
    path: String,
    /// Folder of the recording.
    #[arg(short, long, value_name = "RECORDING")]
    output: PathBuf,
    /// Leave out the walls: the direct wave alone. Fast, because only the field around the robot is simulated.
    #[arg(long)]
    free_field: bool,
    /// Simulate the scene's whole domain. By default the absorbing layer begins where walls and drive end, which does
    /// not change the signal.
    #[arg(long)]
    whole_domain: bool,
    /// Simulate the drive without walls too and write it as direct.wav.
    #[arg(long, conflicts_with = "free_field")]
    with_direct: bool,
    /// Scheme of the field, slf, m13, o13, d25 or iwb; the scene's unless given.
    #[arg(long, value_parser = named::<Scheme>)]
    scheme: Option<Scheme>,
    /// Spreading of source and receiver, bilinear, gaussian, kaiser8 or kaiser12; the scene's unless given.
    #[arg(long, value_parser = named::<Spread>)]
    spread: Option<Spread>,
    /// Model of the walls, staircase or cut-cells; the scene's unless given.
    #[arg(long, value_name = "MODEL", value_parser = wall_model)]
    walls: Option<WallModel>,
    #[command(flatten)]
    engine: EngineArguments,
    #[command(flatten)]
    force: ForceArgument,
    /// Threads; 0 takes all.
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = threads)]
    threads: usize,
    /// Absorption by air (ISO 9613-1), each echo by its path length. The drive is simulated a second time with the
    /// source strength times the time of emission, from which path lengths follow. Needs a scene whose medium is
    /// given by temperature and humidity, or --temperature and --humidity.
    #[arg(long)]
    absorption: bool,
    /// Temperature for --absorption, degC, where the scene's medium is plain numbers.
    #[arg(long, value_name = "DEG_C", requires_all = ["absorption", "humidity"], allow_hyphen_values = true)]
    temperature: Option<f64>,
    /// Relative humidity for --absorption, percent.
    #[arg(long, value_name = "PERCENT", requires_all = ["absorption", "temperature"])]
    humidity: Option<f64>,
    /// Resume from the checkpoint of an interrupted simulation.
    #[arg(long)]
    resume: bool,
    /// Folder for pictures of the field, and for the animation (pressure.apng) that joins them.
    #[arg(long, value_name = "DIR", requires = "every")]
    snapshots: Option<PathBuf>,
    /// Time between two pictures, seconds of the drive: at most its length.
    #[arg(long, value_name = "SECONDS", requires = "snapshots")]
    every: Option<f64>,
    /// Steady error of the odometry's turn rate, rad/s.
    #[arg(long, default_value_t = ODOMETRY_BIAS_RADPS, value_name = "RAD_PER_S", allow_hyphen_values = true)]
    odometry_bias: f64,
    /// Robot whose slipping wheels, microphone noise, 16-bit converter and clocks the recording gets, instead of the
    /// steady error; see experiments/robots.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["odometry_bias", "free_field"])]
    robot: Option<PathBuf>,
}

/// A wall model by its name in scene files, or with dashes as on the command line.
fn wall_model(text: &str) -> Result<WallModel, String> {
    named(&text.replace('-', "_"))
}

impl Arguments {
    /// The requested recording.
    fn spec(&self) -> Result<RecordingSpec> {
        if !self.odometry_bias.is_finite() {
            bail!(
                "--odometry-bias: {} is not finite; give a number",
                self.odometry_bias
            );
        }
        Ok(RecordingSpec {
            image_order: self.engine.image_order()?,
            scheme: self.scheme,
            spread: self.spread,
            wall_model: self.walls,
            free_field: self.free_field,
            whole_domain: self.whole_domain,
            odometry_bias_radps: self.odometry_bias,
            ..RecordingSpec::of(&self.path, self.engine.engine)
        })
    }

    /// The air that absorbs, when absorption is requested.
    fn air(&self, scene: &Scene) -> Result<Option<Air>> {
        let file = self.scene.display();
        match (self.temperature.zip(self.humidity), scene.air) {
            _ if !self.absorption => Ok(None),
            (Some(_), Some(_)) => bail!(
                "--temperature: {file} has a temperature and a humidity of its own; leave out --temperature and \
                --humidity"
            ),
            (None, None) => bail!(
                "--absorption: the medium of {file} has no temperature and humidity; give --temperature and \
                --humidity, or both in the scene"
            ),
            (None, air) => Ok(air),
            (Some((temperature_degc, relative_humidity_percent)), None) => {
                let air = Air {
                    temperature_degc,
                    relative_humidity_percent,
                    pressure_pa: STANDARD_PRESSURE_PA,
                };
                air.check("--temperature, --humidity", "")?;
                Ok(Some(air))
            }
        }
    }

    /// Folder of the requested pictures and the time between two, seconds.
    fn pictures(&self) -> Result<Option<(PathBuf, f64)>> {
        match (&self.snapshots, self.every) {
            (Some(_), Some(_)) if self.engine.engine == Engine::ImageSource => bail!(
                "--snapshots: image sources have no field to show; leave it out, or use --engine fdtd"
            ),
            (Some(folder), Some(every_s)) if every_s.is_finite() && every_s > 0.0 => {
                Ok(Some((folder.clone(), every_s)))
            }
            (Some(_), Some(every_s)) => {
                bail!("--every: {every_s} is no time; give a positive number of seconds")
            }
            _ => Ok(None),
        }
    }

    /// Files that the command reads: scene, robot, and poses of drives.
    fn inputs(&self) -> Vec<PathBuf> {
        let mut inputs = vec![self.scene.clone()];
        inputs.extend(self.robot.clone());
        let text = std::fs::read_to_string(&self.scene).unwrap_or_default();
        let scene: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
        let paths = scene["paths"].as_object().into_iter().flatten();
        inputs.extend(
            paths
                .filter_map(|(_, path)| path["file"].as_str())
                .map(|file| self.scene.with_file_name(file)),
        );
        inputs
    }

    /// Checks the places of the recording, of its checkpoints, and of the pictures.
    fn check_output(&self, scene: &Scene, length_s: f64) -> Result<()> {
        let signals = 1 + u64::from(self.with_direct);
        let samples = (length_s * scene.sample_rate_hz) as u64;
        let place = |path: PathBuf, bytes| Place {
            inputs: self.inputs(),
            bytes,
            ..Place::of(path, self.force.force)
        };
        place(self.output.clone(), 4 * signals * samples).whole_folder()?;
        if self.engine.engine == Engine::Fdtd {
            // Two time levels of the field, and the signal so far.
            let bytes = 8 * scene.grid.cells() as u64 + 4 * samples;
            place(self.beside(".checkpoint"), bytes).file(Simulation::is_checkpoint)?;
        }
        let Some((folder, every_s)) = self.pictures()? else {
            return Ok(());
        };
        if every_s > length_s {
            bail!(
                "--every: {every_s} s is longer than the drive of {length_s} s; give the time between two pictures"
            );
        }
        for name in [figures::animation::NAME, "pressure_000000000us.png"] {
            place(folder.join(name), 0).file(png::is_ours)?;
        }
        Ok(())
    }

    /// A file beside the recording.
    fn beside(&self, ending: &str) -> PathBuf {
        let mut name = self.output.file_name().unwrap_or_default().to_os_string();
        name.push(ending);
        self.output.with_file_name(name)
    }

    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let mut scene = Scene::load(&self.scene)?;
        // Another scheme may have another stability limit or reach.
        scene.scheme = self.scheme.unwrap_or(scene.scheme);
        scene.spread = self.spread.unwrap_or(scene.spread);
        scene.wall_model = self.walls.unwrap_or(scene.wall_model);
        scene.check(&self.scene.display().to_string())?;
        let spec = self.spec()?;
        let pictures = self.pictures()?;
        let air = self.air(&scene)?;
        let path = scene.path(&spec.path)?;
        let robot = self.robot.as_deref().map(Robot::read).transpose()?;
        preflight::check(
            &scene,
            &self.scene.display().to_string(),
            &spec,
            robot.as_ref(),
        )?;
        self.check_output(&scene, path.duration_s())?;
        let board = Board::new();
        let estimate = match spec.engine {
            Engine::Fdtd => {
                let estimate = schedule::estimate(&scene, &spec, self.threads)?;
                board.say(format!("{}, {}: {estimate}", scene.name, spec.path));
                Some(estimate)
            }
            Engine::ImageSource => None,
        };
        let started = Instant::now();
        let mut leftovers = Vec::new();
        let mut simulate = |own: &RecordingSpec| -> Result<Vec<f32>> {
            let direct = if own.free_field && !spec.free_field {
                ".direct"
            } else {
                ""
            };
            let stamped = if own.stamped { ".stamped" } else { "" };
            let checkpoint = Checkpoint {
                path: self.beside(&format!("{direct}{stamped}.checkpoint")),
                resume: self.resume,
            };
            leftovers.push(checkpoint.path.clone());
            let pictures = pictures.as_ref().filter(|_| *own == spec);
            self.signal(&scene, own, (&board, estimate), &checkpoint, pictures)
        };
        let extras = Extras {
            air: air.as_ref(),
            with_direct: self.with_direct,
            robot: robot.as_ref(),
        };
        let recording = record(&scene, &spec, &extras, &mut simulate)?;
        let seconds = started.elapsed().as_secs_f64();
        let robot = robot.as_ref().map(|robot| (robot, spec.path.as_str()));
        recording::write(&recording, robot, &self.output).with_context(|| {
            match leftovers.iter().any(|path| path.exists()) {
                true => "the simulation is kept: the same command with --resume writes it",
                false => "nothing is kept",
            }
        })?;
        for path in leftovers.iter().filter(|path| path.exists()) {
            std::fs::remove_file(path)?;
        }
        if json {
            return print_json(&serde_json::json!({
                "recording": self.output,
                "samples": recording.signal.len(),
                "duration_s": recording.duration_s(),
                "seconds": seconds,
                "estimate": estimate,
            }));
        }
        eprintln!(
            "wrote {} ({:.1} s of sound) in {}",
            self.output.display(),
            recording.duration_s(),
            duration(seconds)
        );
        Ok(())
    }

    /// The signal of one drive, with pictures of the field where these are wanted.
    fn signal(
        &self,
        scene: &Scene,
        spec: &RecordingSpec,
        (board, estimate): (&Board, Option<schedule::Estimate>),
        checkpoint: &Checkpoint,
        pictures: Option<&(PathBuf, f64)>,
    ) -> Result<Vec<f32>> {
        let steps = estimate.map_or(1, |estimate| estimate.steps);
        let task = board.task(&spec.path, steps);
        let draw = |frame: &FieldFrame| -> Result<()> {
            if let Some((folder, _)) = pictures {
                figures::snapshot::draw(scene, &spec.path, frame, folder)?;
            }
            Ok(())
        };
        let options = RunOptions {
            threads: self.threads,
            checkpoint: Some(checkpoint),
            snapshots: pictures.map(|&(_, every_s)| Snapshots {
                every_s,
                receive: &draw,
            }),
            ..RunOptions::default()
        };
        let signal = signal(scene, spec, &options, &task)?;
        if let Some((folder, _)) = pictures {
            figures::animation::animate(folder)?;
        }
        Ok(signal)
    }
}
