//! Position error over the half-width of the matched window (Fig. 7).

use anyhow::Result;
use localizer::Parameters;
use localizer::parameters::FilterParameters;

use super::doppler_trials;
use crate::laboratory::Laboratory;
use crate::summary::{Summary, WindowCell};
use crate::table::{Table, cell};
use crate::trials::accuracy;

/// Runs the study.
pub(crate) fn run(lab: &Laboratory, summary: &mut Summary) -> Result<()> {
    let trials: Vec<_> = lab
        .plan
        .half_widths_m
        .iter()
        .flat_map(|&window_half_width_m| {
            let parameters = Parameters {
                filter: FilterParameters {
                    window_half_width_m,
                    ..lab.parameters.filter
                },
                ..lab.parameters.clone()
            };
            doppler_trials(&parameters, lab.plan.trials)
        })
        .collect();
    let results = lab.trials("window-size", &trials)?;
    let mut table = Table::new(["half_width_m", "trial", "mae_m"]);
    for (trial, result) in trials.iter().zip(&results) {
        table.push([
            cell(trial.parameters.filter.window_half_width_m, 2),
            trial.trial.to_string(),
            cell(result.mae_m(), 6),
        ]);
    }
    table.write(&lab.data("window_size.csv"))?;
    summary.window_size = lab
        .plan
        .half_widths_m
        .iter()
        .zip(results.chunks(lab.plan.trials))
        .map(|(&half_width_m, results)| WindowCell {
            half_width_m,
            accuracy: accuracy(results),
        })
        .collect();
    Ok(())
}
