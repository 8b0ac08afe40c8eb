//! Estimates of `localize` and `track` as files, and their errors.

use std::fmt::Write as _;

use clap::ValueEnum;
use localizer::io::recording_source::RecordingSource;
use localizer::{Estimate, Method, Parameters, Trajectory};

use crate::metrics::{mean, quantile, rounded};

/// Largest distance in time of a true pose from an estimate of which it is the truth, in seconds: that of `evo_ape`.
const LARGEST_APART_S: f64 = 0.01;

/// Clock of the times of estimates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Clock {
    /// That of truth.tum.
    Truth,
    /// That of odometry.csv.
    Wheels,
    /// Time since the first period of the sound.
    Sound,
}

impl Clock {
    /// What it shows at the first period of a recording.
    pub(super) fn reading_s(self, source: &RecordingSource) -> f64 {
        match self {
            Self::Truth => source.alignment.truth.map_or(0.0, |clock| clock.reading_s),
            Self::Wheels => source.alignment.odometry.reading_s,
            Self::Sound => 0.0,
        }
    }

    /// The truth's where there is one, else the wheels'.
    pub(super) fn usual(source: &RecordingSource) -> Self {
        match source.truth {
            Some(_) => Self::Truth,
            None => Self::Wheels,
        }
    }
}

/// Poses with their times on a clock that shows `reading_s` at the first period.
pub(super) fn trajectory(estimates: &[Estimate], reading_s: f64) -> Trajectory {
    Trajectory {
        t_s: estimates
            .iter()
            .map(|estimate| estimate.t_s + reading_s)
            .collect(),
        poses: estimates.iter().map(|estimate| estimate.pose).collect(),
    }
}

/// First line of a table of estimates.
pub(super) const HEADER: &str = "t_s,x_m,y_m,heading_rad,xx_m2,xy_m2,yy_m2,xh_mrad,yh_mrad,hh_rad2,status,\
    effective_sample_size,latest_s,latest_x_m,latest_y_m,latest_heading_rad\n";

/// What an estimate rests on.
pub(super) fn status(estimate: &Estimate, by_wheels: bool) -> &'static str {
    match (by_wheels, estimate.stationary) {
        (true, _) => "wheels",
        (false, true) => "slow",
        (false, false) => "echoes",
    }
}

/// The table of a whole drive.
pub(super) fn table(estimates: &[Estimate], parameters: &Parameters, reading_s: f64) -> String {
    let by_wheels = parameters.filter.method == Method::Odometry;
    let rest = parameters.measurement.periods as f64 - parameters.measurement.reference_periods();
    let mut text = String::from(HEADER);
    for estimate in estimates {
        let status = status(estimate, by_wheels);
        line(
            &mut text,
            estimate,
            reading_s,
            rest * parameters.period_s(),
            status,
        );
    }
    text
}

/// A line of the table. `block_end_s` is the time of the newest sample after the estimate's instant.
pub(super) fn line(
    text: &mut String,
    estimate: &Estimate,
    reading_s: f64,
    end_s: f64,
    status: &str,
) {
    let [[xx, xy, xh], [_, yy, yh], [.., hh]] = estimate.covariance;
    let (pose, latest) = (estimate.pose, estimate.latest);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{:.6},{:.6},{:.6},{:.6},{xx:.3e},{xy:.3e},{yy:.3e},{xh:.3e},{yh:.3e},{hh:.3e},{status},{:.1},{:.6},{:.6},\
         {:.6},{:.6}",
        estimate.t_s + reading_s,
        pose.x_m,
        pose.y_m,
        pose.heading_rad,
        estimate.effective_sample_size,
        estimate.t_s + reading_s + end_s,
        latest.x_m,
        latest.y_m,
        latest.heading_rad,
    );
}

/// Errors of a path.
pub(super) struct Errors {
    /// Distance from the truth of every estimate, in metres.
    pub(super) all_m: Vec<f64>,
}

impl Errors {
    /// Distances from the nearest true pose in time, as `evo_ape` takes it; between true poses where these lie further
    /// apart.
    pub(super) fn of(estimates: &[Estimate], truth: &Trajectory) -> Self {
        let distance = |estimate: &Estimate| {
            let nearest = nearest(truth, estimate.t_s)?;
            let apart_s = (truth.t_s[nearest] - estimate.t_s).abs();
            let truth = match apart_s <= LARGEST_APART_S {
                true => truth.poses[nearest],
                false => truth.pose_at(estimate.t_s)?,
            };
            Some(estimate.pose.distance_m(&truth))
        };
        Self {
            all_m: estimates.iter().filter_map(distance).collect(),
        }
    }

    pub(super) fn mae_m(&self) -> f64 {
        mean(&self.all_m)
    }

    pub(super) fn p90_m(&self) -> f64 {
        rounded(quantile(&self.all_m, 0.9))
    }
}

/// Index of the pose nearest in time, the first of two.
fn nearest(truth: &Trajectory, t_s: f64) -> Option<usize> {
    let next = truth.t_s.partition_point(|&time| time < t_s);
    let apart = |index: &usize| (truth.t_s[*index] - t_s).abs();
    (next.saturating_sub(1)..=next)
        .filter(|&index| index < truth.len())
        .min_by(|a, b| apart(a).total_cmp(&apart(b)))
}
