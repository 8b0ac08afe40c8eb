//! `echolot localize`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::ValueEnum;
use localizer::filter::motion_model::advance;
use localizer::io::recording_source::RecordingSource;
use localizer::landmarks::{LandmarkMap, Start};
use localizer::odometry::mean_over_time;
use localizer::pose::wrap_angle;
use localizer::{Estimate, MapImage, Method, Parameters, Pose, Trajectory, offline};

use super::alignment::AlignmentArguments;
use super::arguments::ParameterArguments;
use super::estimates::{self, Clock, Errors};
use super::landmarks;
use super::output::{print, print_json};
use crate::data::atomic;
use crate::figures;
use crate::figures::localization::Localization;
use crate::metrics::rounded;
use crate::run::progress::Board;

/// Method of localization.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum MethodArgument {
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
    pub(super) fn of_images(self) -> Option<Method> {
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
    /// Standard deviations of the start in metres and degrees; a known start unless given.
    #[arg(long, value_name = "M,DEG", value_parser = start_sigma)]
    start_sigma: Option<[f64; 2]>,
    /// Clock of the estimates' times; the truth's where there is one, else the wheels'.
    #[arg(long, value_enum)]
    clock: Option<Clock>,
    /// Picture of path, truth and wheels over the map, error and fit over time (PNG).
    #[arg(long, value_name = "PNG")]
    figure: Option<PathBuf>,
    #[command(flatten)]
    parameters: ParameterArguments,
    #[command(flatten)]
    alignment: AlignmentArguments,
}

/// Start of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum StartArgument {
    Pose(Pose),
    Unknown,
}

/// Reads `X,Y,DEG` or `unknown`.
pub(super) fn start(text: &str) -> Result<StartArgument, String> {
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

/// Reads `M,DEG` as metres and radians.
pub(super) fn start_sigma(text: &str) -> Result<[f64; 2], String> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|part| part.trim().parse().ok())
        .collect();
    match numbers.as_deref() {
        Some(&[metres, degrees])
            if (0.0..=100.0).contains(&metres) && (0.0..=180.0).contains(&degrees) =>
        {
            Ok([metres, degrees.to_radians()])
        }
        _ => Err("give two numbers as in 0.1,5: at most 100 m and 180 degrees".into()),
    }
}

/// Largest number of a start.
const FARTHEST: f64 = 1e5;

impl Arguments {
    /// Localizes among landmarks.
    fn among_landmarks(&self, source: RecordingSource, json: bool) -> Result<()> {
        let recording = source.load()?;
        for (option, given) in [
            ("--figure", self.figure.is_some()),
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
        let [sigma_m, sigma_rad] = self.start_sigma.unwrap_or(landmarks::START_SIGMA);
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
        landmarks::localize(&recording, &map, &parameters, &start, &self.output, json)
    }

    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let source = self.alignment.open(&self.recording)?;
        let Some(method) = self.method.of_images() else {
            return self.among_landmarks(source, json);
        };
        let start = match self.start {
            Some(StartArgument::Unknown) => {
                bail!("--start unknown: needs --method landmarks; give X,Y,DEG")
            }
            Some(StartArgument::Pose(pose)) => pose,
            None => source.start_pose(),
        };
        let map = MapImage::read(&self.map)?;
        let parameters = self.of_images(&map, &source, method)?;
        let task = Board::new().task("localize", 1);
        let estimates = offline::localize_source(&source, &map, &parameters, start, self.seed)?;
        task.finish();
        let table = self.output.with_extension("csv");
        let clock = self.clock.unwrap_or_else(|| Clock::usual(&source));
        let reading_s = clock.reading_s(&source);
        estimates::trajectory(&estimates, reading_s).write_tum(&self.output)?;
        let text = estimates::table(&estimates, &parameters, reading_s);
        atomic::write(&table, text.as_bytes())?;
        if let Some(picture) = &self.figure {
            self.draw(&source, &map, &parameters, (start, &estimates), picture)?;
        }
        let errors = source
            .truth
            .as_ref()
            .map(|truth| Errors::of(&estimates, truth));
        let mae_m = errors.as_ref().map(Errors::mae_m);
        if json {
            return print_json(&serde_json::json!({
                "estimate": self.output,
                "table": table,
                "poses": estimates.len(),
                "mae_m": mae_m,
                "p90_m": errors.as_ref().map(|errors| rounded(errors.p90_m())),
            }));
        }
        eprintln!(
            "wrote {} and {} ({} poses)",
            self.output.display(),
            table.display(),
            estimates.len()
        );
        match mae_m {
            Some(mae_m) => print(&format!("mean absolute position error {mae_m:.4} m\n"))?,
            None => eprintln!("no truth.tum: no error to tell"),
        }
        Ok(())
    }

    /// Draws path, truth and wheels over the map.
    fn draw(
        &self,
        source: &RecordingSource,
        map: &MapImage,
        parameters: &Parameters,
        (start, found): (Pose, &[Estimate]),
        picture: &Path,
    ) -> Result<()> {
        let period_s = parameters.period_s();
        let mut wheels = Trajectory {
            t_s: vec![0.0],
            poses: vec![start],
        };
        let mut pose = start;
        for number in 0..(source.duration_s() / period_s) as usize {
            let [from_s, to_s] = [number, number + 1].map(|n| n as f64 * period_s);
            let mean = mean_over_time(&source.odometry, from_s, to_s);
            pose = advance(&pose, mean, period_s, parameters.filter.integration);
            wheels.t_s.push(to_s);
            wheels.poses.push(pose);
        }
        let particles = parameters.filter.particles.max(1) as f64;
        let fit: Vec<f64> = found
            .iter()
            .map(|estimate| estimate.effective_sample_size / particles)
            .collect();
        let shown = Localization {
            map,
            path: &offline::trajectory(found),
            truth: source.truth.as_ref(),
            wheels: &wheels,
            fit: &fit,
        };
        figures::localization::draw(&shown, picture)?;
        eprintln!("wrote {}", picture.display());
        Ok(())
    }

    /// Parameters of a localization by echo images.
    fn of_images(
        &self,
        map: &MapImage,
        source: &RecordingSource,
        method: Method,
    ) -> Result<Parameters> {
        let mut parameters = match self.parameters.parameters {
            Some(_) => self.parameters.read()?,
            None => map.parameters.clone(),
        }
        .for_recording(&source.meta);
        parameters.filter.method = method;
        parameters.measurement.periods = self.periods.unwrap_or(parameters.measurement.periods);
        parameters.filter.window_half_width_m =
            self.window.unwrap_or(parameters.filter.window_half_width_m);
        parameters.filter.particles = self.particles.unwrap_or(parameters.filter.particles);
        if let Some([sigma_m, sigma_rad]) = self.start_sigma {
            parameters.filter.start_sigma_m = sigma_m;
            parameters.filter.start_sigma_rad = sigma_rad;
        }
        parameters.check()?;
        Ok(parameters)
    }
}
