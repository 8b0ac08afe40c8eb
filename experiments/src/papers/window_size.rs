//! Position error over the half-width of the matched window (Fig. 7).

use anyhow::Result;
use localizer::Parameters;
use localizer::parameters::FilterParameters;

use super::PaperSession;
use super::cells::doppler_trials;
use crate::data::table::{Table, cell};
use crate::summary::{Summary, WindowCell};
use crate::trials::{self, accuracy};

/// Runs the study.
pub(super) fn run(
    session: &PaperSession,
    half_widths_m: &[f64],
    summary: &mut Summary,
) -> Result<()> {
    let count = session.seeds().filter;
    let trials: Vec<_> = half_widths_m
        .iter()
        .flat_map(|&window_half_width_m| {
            let parameters = Parameters {
                filter: FilterParameters {
                    window_half_width_m,
                    ..session.parameters.filter
                },
                ..session.parameters.clone()
            };
            doppler_trials(&parameters, count)
        })
        .collect();
    let results = trials::run(session, "window-size", &trials)?;
    let mut table = Table::new(["half_width_m", "trial", "mae_m"]);
    for (trial, result) in trials.iter().zip(&results) {
        table.push([
            cell(trial.parameters.filter.window_half_width_m, 2),
            trial.trial.to_string(),
            cell(result.mae_m(), 6),
        ]);
    }
    table.write(&session.data("window_size.csv"))?;
    summary.window_size = half_widths_m
        .iter()
        .zip(results.chunks(count))
        .map(|(&half_width_m, results)| WindowCell {
            half_width_m,
            accuracy: accuracy(results),
        })
        .collect();
    Ok(())
}
