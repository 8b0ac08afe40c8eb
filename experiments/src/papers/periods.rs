//! Position error and paths for several numbers of periods in a block (2023 abstract).

use anyhow::Result;
use localizer::parameters::MeasurementParameters;
use localizer::{Method, Parameters};

use super::PaperSession;
use super::cells::{doppler_trials, trials_of};
use crate::data::table::{Table, cell};
use crate::summary::{PeriodsCell, Summary};
use crate::trials::{self, TrialResult, accuracy};

/// Runs the study.
pub(super) fn run(session: &PaperSession, counts: &[usize], summary: &mut Summary) -> Result<()> {
    let seeds = session.seeds().filter;
    let trials: Vec<_> = counts
        .iter()
        .flat_map(|&periods| {
            let parameters = Parameters {
                measurement: MeasurementParameters {
                    periods,
                    ..session.parameters.measurement
                },
                ..session.parameters.clone()
            };
            doppler_trials(&parameters, seeds)
        })
        .collect();
    let results = trials::run(session, "periods", &trials)?;
    // Dead reckoning is shown beside the paths.
    let odometry = trials::run(
        session,
        "periods",
        &trials_of(&session.parameters, Method::Odometry, 1),
    )?;
    let mut table = Table::new(["m", "trial", "mae_m"]);
    let mut paths = Table::new(["m", "t_s", "x_m", "y_m"]);
    let mut add_path = |name: &str, result: &TrialResult| {
        for index in 0..result.t_s.len() {
            paths.push([
                name.to_string(),
                cell(result.t_s[index], 4),
                cell(result.x_m[index], 4),
                cell(result.y_m[index], 4),
            ]);
        }
    };
    for (trial, result) in trials.iter().zip(&results) {
        let m = trial.parameters.measurement.periods.to_string();
        table.push([m.clone(), trial.trial.to_string(), cell(result.mae_m(), 6)]);
        if trial.trial == 0 {
            add_path(&m, result);
        }
    }
    for result in &odometry {
        add_path("odometry", result);
    }
    table.write(&session.data("periods.csv"))?;
    paths.write(&session.data("periods_paths.csv"))?;
    summary.periods = counts
        .iter()
        .zip(results.chunks(seeds))
        .map(|(&m, results)| PeriodsCell {
            m,
            accuracy: accuracy(results),
        })
        .collect();
    Ok(())
}
