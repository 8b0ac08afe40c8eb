//! Correction of the drift of wheel odometry by echoes (Fig. 6).

use anyhow::Result;
use localizer::Method;

use super::PaperSession;
use super::cells::{method_name, trials_of};
use crate::data::frames::FRAMES;
use crate::data::table::{Table, cell};
use crate::summary::{Methods, Summary};
use crate::trials::{self, accuracy};

/// Runs the study.
pub(super) fn run(session: &PaperSession, summary: &mut Summary) -> Result<()> {
    let count = session.seeds().filter;
    let methods = [
        (Method::Doppler, count),
        (Method::ToaOnly, count),
        // Dead reckoning has no random numbers.
        (Method::Odometry, 1),
    ];
    let trials: Vec<_> = methods
        .iter()
        .flat_map(|&(method, count)| trials_of(&session.parameters, method, count))
        .collect();
    let results = trials::run(session, "odometry-drift", &trials)?;
    let mut paths = Table::new([
        "method",
        "trial",
        "t_s",
        "x_m",
        "y_m",
        "heading_rad",
        "error_m",
    ]);
    for (trial, result) in trials.iter().zip(&results) {
        for index in 0..result.t_s.len() {
            paths.push([
                method_name(trial.parameters.filter.method).to_string(),
                trial.trial.to_string(),
                cell(result.t_s[index], 4),
                cell(result.x_m[index], 4),
                cell(result.y_m[index], 4),
                cell(result.heading_rad[index], 4),
                cell(result.error_m[index], 5),
            ]);
        }
    }
    paths.write(&session.data("drift_paths.csv"))?;
    if let Some(frames) = trials::watch(session, &trials[0], method_name(Method::Doppler))? {
        frames.write(&session.data(FRAMES))?;
    }
    summary.odometry_drift = Some(Methods {
        doppler: accuracy(&results[..count]),
        toa_only: accuracy(&results[count..2 * count]),
        odometry: accuracy(&results[2 * count..]),
    });
    Ok(())
}
