//! `echolot localize`.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::ValueEnum;
use localizer::landmarks::{LandmarkMap, Start};
use localizer::pose::wrap_angle;
use localizer::{MapImage, Method, Pose, Recording, echo, offline};

use super::arguments::{ForceArgument, ParameterArguments, files_of_map, files_of_recording};
use super::landmarks;
use super::output::{print, print_json};
use crate::data::estimate;
use crate::data::place::Place;
use crate::metrics::{mean, quantile, rounded};
use crate::run::progress::Board;

/// Method of localization.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodArgument {
    /// Echoes in range and bearing.
    Doppler,
    /// Echoes in range only.
    ToaOnly,
    /// Wheel odometry alone.
    Odometry,
    /// Peaks of the echoes among the landmarks of `map --method landmarks`.
    Landmarks,
}

impl MethodArgument {
    /// The method among echo images; none for landmarks.
    fn of_images(self) -> Option<Method> {
        match self {
            Self::Doppler => Some(Method::Doppler),
            Self::ToaOnly => Some(Method::ToaOnly),
            Self::Odometry => Some(Method::Odometry),
            Self::Landmarks => None,
        }
    }
}

/// Arguments of `localize`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot localize recordings/drive --map maps/room -o drive.tum --seed 1\n  \
    echolot localize recordings/drive --map maps/room -o drive.tum --method landmarks --start unknown\n\n\
    With truth.tum in the recording the mean absolute error is printed. Unless given, the start is the truth at time \
    0, the start of recording.json, or the origin. By landmarks a table with covariance and status is written beside \
    EST.tum."
)]
pub(crate) struct Arguments {
    /// Recording folder.
    recording: PathBuf,
    /// Map folder.
    #[arg(long)]
    map: PathBuf,
    /// Estimated trajectory (TUM).
    #[arg(short, long, value_name = "EST.tum")]
    output: PathBuf,
    /// Method.
    #[arg(long, value_enum, default_value_t = MethodArgument::Doppler)]
    method: MethodArgument,
    /// Periods M in a block; the map's unless given.
    #[arg(long, value_name = "M")]
    periods: Option<usize>,
    /// Half-width of the matched window, metres.
    #[arg(long, value_name = "METRES")]
    window: Option<f64>,
    /// Number of particles.
    #[arg(long, value_name = "N")]
    particles: Option<usize>,
    /// Seed of the filter's random numbers.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Start of the drive: x and y in metres and the heading in degrees, or unknown (landmarks only).
    #[arg(long, value_name = "X,Y,DEG|unknown", allow_hyphen_values = true, value_parser = start)]
    start: Option<StartArgument>,
    #[command(flatten)]
    parameters: ParameterArguments,
    #[command(flatten)]
    force: ForceArgument,
}

/// Start of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
enum StartArgument {
    Pose(Pose),
    Unknown,
}

/// Reads `X,Y,DEG` or `unknown`.
fn start(text: &str) -> Result<StartArgument, String> {
    if text == "unknown" {
        return Ok(StartArgument::Unknown);
    }
    let numbers: Vec<f64> = text
        .split(',')
        .filter_map(|part| part.trim().parse().ok())
        .collect();
    match numbers[..] {
        [x_m, y_m, degrees]
            if text.split(',').count() == 3 && numbers.iter().all(|x| x.abs() <= FARTHEST) =>
        {
            Ok(StartArgument::Pose(Pose {
                x_m,
                y_m,
                heading_rad: wrap_angle(degrees.to_radians()),
            }))
        }
        _ => Err("give three numbers as in 1.5,2,90, or unknown".into()),
    }
}

/// Largest number of a start.
const FARTHEST: f64 = 1e5;

impl Arguments {
    /// Localizes among landmarks.
    fn among_landmarks(&self, recording: &Recording, json: bool) -> Result<()> {
        for (option, given) in [
            ("--window", self.window.is_some()),
            ("--particles", self.particles.is_some()),
        ] {
            if given {
                bail!("{option}: is for echo images; leave it out with --method landmarks");
            }
        }
        let map = LandmarkMap::read(&self.map)?;
        let mut parameters = match self.parameters.parameters {
            Some(_) => self.parameters.read()?,
            None => map.parameters.clone(),
        }
        .for_recording(&recording.meta);
        parameters.measurement.periods = self.periods.unwrap_or(parameters.measurement.periods);
        parameters.check()?;
        let [sigma_m, sigma_rad] = landmarks::START_SIGMA;
        let known = |pose| Start::Known {
            pose,
            sigma_m,
            sigma_rad,
        };
        let start = match self.start {
            Some(StartArgument::Unknown) => Start::Unknown,
            Some(StartArgument::Pose(pose)) => known(pose),
            None => known(recording.start_pose()),
        };
        landmarks::localize(recording, &map, &parameters, &start, &self.output, json)
    }

    /// Checks the place of the trajectory, and of the table beside it.
    fn check_output(&self) -> Result<()> {
        let mut inputs = files_of_recording(&self.recording);
        inputs.extend(files_of_map(&self.map));
        inputs.extend(self.parameters.parameters.clone());
        let table = self.output.with_extension("csv");
        let place = |path| Place {
            inputs: inputs.clone(),
            ..Place::of(path, self.force.force)
        };
        place(&self.output).file(estimate::is_ours)?;
        if self.method == MethodArgument::Landmarks {
            if table == self.output {
                bail!(
                    "{}: is the name of the table beside the trajectory; give one that ends in .tum",
                    table.display()
                );
            }
            place(&table).file(landmarks::is_table)?;
        }
        Ok(())
    }

    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        self.check_output()?;
        let recording = Recording::read(&self.recording)?;
        let Some(method) = self.method.of_images() else {
            return self.among_landmarks(&recording, json);
        };
        let start = match self.start {
            Some(StartArgument::Unknown) => {
                bail!("--start unknown: needs --method landmarks; give X,Y,DEG")
            }
            Some(StartArgument::Pose(pose)) => pose,
            None => recording.start_pose(),
        };
        let map = MapImage::read(&self.map)?;
        let mut parameters = match self.parameters.parameters {
            Some(_) => self.parameters.read()?,
            None => map.parameters.clone(),
        }
        .for_recording(&recording.meta);
        parameters.filter.method = method;
        parameters.measurement.periods = self.periods.unwrap_or(parameters.measurement.periods);
        parameters.filter.window_half_width_m =
            self.window.unwrap_or(parameters.filter.window_half_width_m);
        parameters.filter.particles = self.particles.unwrap_or(parameters.filter.particles);
        parameters.check()?;
        let task = Board::new().task("localize", 2);
        let sequence = echo::measure(&recording, &parameters)?;
        task.set(1);
        let estimates = offline::localize(&sequence, &map, &parameters, start, self.seed)?;
        task.finish();
        estimate::write(&self.output, &offline::trajectory(&estimates))?;
        let errors: Option<Vec<f64>> = recording.truth.as_ref().map(|truth| {
            let distance =
                |t_s: f64, pose: &Pose| truth.pose_at(t_s).map(|truth| pose.distance_m(&truth));
            estimates
                .iter()
                .filter_map(|estimate| distance(estimate.t_s, &estimate.pose))
                .collect()
        });
        let mae_m = errors.as_ref().map(|errors| rounded(mean(errors)));
        if json {
            return print_json(&serde_json::json!({
                "estimate": self.output,
                "poses": estimates.len(),
                "mae_m": mae_m,
                "p90_m": errors.as_ref().map(|errors| rounded(quantile(errors, 0.9))),
            }));
        }
        eprintln!(
            "wrote {} ({} poses)",
            self.output.display(),
            estimates.len()
        );
        match mae_m {
            Some(mae_m) => print(&format!("mean absolute position error {mae_m:.4} m\n"))?,
            None => eprintln!("no truth.tum: no error to tell"),
        }
        Ok(())
    }
}
