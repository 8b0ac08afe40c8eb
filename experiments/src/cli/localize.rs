//! `echolot localize`.

use std::path::PathBuf;

use anyhow::Result;
use clap::ValueEnum;
use localizer::{MapImage, Method, Pose, Recording, echo, offline};

use super::arguments::ParameterArguments;
use super::output::{print, print_json};
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
}

impl From<MethodArgument> for Method {
    fn from(argument: MethodArgument) -> Self {
        match argument {
            MethodArgument::Doppler => Self::Doppler,
            MethodArgument::ToaOnly => Self::ToaOnly,
            MethodArgument::Odometry => Self::Odometry,
        }
    }
}

/// Arguments of `localize`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot localize recordings/drive --map maps/room -o drive.tum --seed 1\n\n\
    With truth.tum in the recording the mean absolute error is printed. The start is the truth at time 0, the start of \
    recording.json, or the origin."
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
    #[command(flatten)]
    parameters: ParameterArguments,
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let recording = Recording::read(&self.recording)?;
        let map = MapImage::read(&self.map)?;
        let mut parameters = match self.parameters.parameters {
            Some(_) => self.parameters.read()?,
            None => map.parameters.clone(),
        }
        .for_recording(&recording.meta);
        parameters.filter.method = self.method.into();
        parameters.measurement.periods = self.periods.unwrap_or(parameters.measurement.periods);
        parameters.filter.window_half_width_m =
            self.window.unwrap_or(parameters.filter.window_half_width_m);
        parameters.filter.particles = self.particles.unwrap_or(parameters.filter.particles);
        parameters.check()?;
        let task = Board::new().task("localize", 2);
        let sequence = echo::measure(&recording, &parameters)?;
        task.set(1);
        let estimates = offline::localize(
            &sequence,
            &map,
            &parameters,
            recording.start_pose(),
            self.seed,
        )?;
        task.finish();
        offline::trajectory(&estimates).write_tum(&self.output)?;
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
