//! Estimates of `localize` and `track` as files, and their errors.

use std::fmt::Write as _;

use anyhow::Result;
use clap::ValueEnum;
use localizer::io::recording_source::RecordingSource;
use localizer::quality::Fit;
use localizer::{Estimate, Method, Parameters, Trajectory};
use serde_json::Value;

use super::output::print;
use crate::localization::status;
use crate::scores::Scores;
use crate::trust::Warnings;

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
    effective_sample_size,latest_s,latest_x_m,latest_y_m,latest_heading_rad,fit,trust\n";

/// How far to trust an estimate by images.
pub(super) fn trust(fit: &Fit) -> &'static str {
    if fit.sure { "sure" } else { "doubtful" }
}

/// First line of a table of estimates among landmarks.
pub(super) const HEADER_AMONG_LANDMARKS: &str = "t_s,x_m,y_m,heading_rad,xx_m2,xy_m2,yy_m2,xh_mrad,yh_mrad,hh_rad2,\
    status,fit,hypotheses,latest_s,latest_x_m,latest_y_m,latest_heading_rad,turn_rate_error_radps,speed_error,\
    speed_of_sound_mps\n";

/// Whether bytes are a table of estimates by any method.
pub(super) fn is_table(bytes: &[u8]) -> bool {
    bytes.starts_with(HEADER.as_bytes()) || bytes.starts_with(HEADER_AMONG_LANDMARKS.as_bytes())
}

/// The table of a whole drive: estimates and fits correspond.
pub(super) fn table(
    estimates: &[Estimate],
    fits: &[Fit],
    parameters: &Parameters,
    reading_s: f64,
) -> String {
    let by_wheels = parameters.filter.method == Method::Odometry;
    let rest = parameters.measurement.periods as f64 - parameters.measurement.reference_periods();
    let mut text = String::from(HEADER);
    let end_s = rest * parameters.period_s();
    for (estimate, fit) in estimates.iter().zip(fits) {
        let status = status(estimate, by_wheels);
        let trust = trust(fit);
        let [[xx, xy, xh], [_, yy, yh], [.., hh]] = estimate.covariance;
        let (pose, latest) = (estimate.pose, estimate.latest);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:.6},{:.6},{:.6},{:.6},{xx:.3e},{xy:.3e},{yy:.3e},{xh:.3e},{yh:.3e},{hh:.3e},{status},{:.1},{:.6},\
             {:.6},{:.6},{:.6},{:.3},{trust}",
            estimate.t_s + reading_s,
            pose.x_m,
            pose.y_m,
            pose.heading_rad,
            estimate.effective_sample_size,
            // The newest sample comes after the estimate's instant.
            estimate.t_s + reading_s + end_s,
            latest.x_m,
            latest.y_m,
            latest.heading_rad,
            fit.fit,
        );
    }
    text
}

/// The errors of a drive, and how much of it they are of.
pub(super) struct Scored {
    /// The errors, where the truth covers any pose.
    pub(super) scores: Option<Scores>,
    /// Share of the drive that the truth covers.
    pub(super) coverage: f64,
    /// Whether there is a truth.
    pub(super) has_truth: bool,
}

impl Scored {
    /// A word on a truth that covers a part.
    pub(super) fn warn(&self, warnings: &mut Warnings) {
        if self.has_truth && self.coverage < 1.0 {
            warnings.add(format!(
                "truth.tum covers {:.0} % of the drive; only that is scored",
                100.0 * self.coverage
            ));
        }
    }

    /// Adds the errors to a report, an object.
    pub(super) fn put_into(&self, mut report: Value) -> Value {
        let score = |of: &dyn Fn(&Scores) -> f64| self.scores.as_ref().map(of);
        for (field, value) in [
            ("mae_m", score(&|scores| scores.mae_m)),
            (
                "interpolated_mae_m",
                score(&|scores| scores.interpolated_mae_m),
            ),
            ("rmse_m", score(&|scores| scores.rmse_m)),
            ("p90_m", score(&|scores| scores.p90_m)),
            ("max_m", score(&|scores| scores.max_m)),
            ("final_m", score(&|scores| scores.final_m)),
            ("heading_mae_rad", score(&|scores| scores.heading_mae_rad)),
            ("coverage", Some(self.coverage)),
        ] {
            report[field] = value.into();
        }
        report
    }

    /// The errors as names and numbers of a table.
    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        let Some(scores) = &self.scores else {
            return vec![["error".into(), "not known: there is no truth".into()]];
        };
        let metres = |name: &str, value: f64| [name.to_string(), format!("{value:.4} m")];
        vec![
            metres("mean error (MAE)", scores.mae_m),
            metres("between true poses", scores.interpolated_mae_m),
            metres("root mean square", scores.rmse_m),
            metres("90 % below", scores.p90_m),
            metres("largest", scores.max_m),
            metres("at the end", scores.final_m),
            [
                "heading, mean".into(),
                format!("{:.4} rad", scores.heading_mae_rad),
            ],
            [
                "covered by the truth".into(),
                format!("{:.0} % of the drive", 100.0 * self.coverage),
            ],
        ]
    }

    /// Prints the mean error.
    ///
    /// # Errors
    /// When standard output cannot be written.
    pub(super) fn tell(&self) -> Result<()> {
        match &self.scores {
            Some(scores) => print(&format!(
                "mean absolute position error {:.4} m ({:.4} m between true poses) over {:.0} % of the drive\n",
                scores.mae_m,
                scores.interpolated_mae_m,
                100.0 * self.coverage
            )),
            None => {
                if !self.has_truth {
                    eprintln!("no truth.tum: no error to tell");
                }
                Ok(())
            }
        }
    }
}
