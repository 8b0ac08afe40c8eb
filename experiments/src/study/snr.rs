//! Position error over the signal-to-noise ratio, eqs. (19)-(21) (Fig. 9).

use anyhow::Result;
use localizer::parameters::FilterParameters;
use localizer::{Method, Parameters};

use crate::laboratory::Laboratory;
use crate::noise::Noise;
use crate::simulate::Take;
use crate::summary::{NoiseCell, Summary};
use crate::table::{Table, cell};
use crate::trials::{Trial, accuracy};

/// Recordings of the study: the direct wave of the localization drive tells the power of the reflected signal.
pub(crate) fn takes(lab: &Laboratory) -> Vec<Take> {
    let mut takes = lab.takes(None);
    takes.push(lab.direct_take(&lab.take("localization", None)));
    takes
}

/// Runs the study.
pub(crate) fn run(lab: &Laboratory, summary: &mut Summary) -> Result<()> {
    let trials: Vec<Trial> = lab
        .plan
        .snr_db
        .iter()
        .flat_map(|&snr_db| {
            (0..lab.plan.noise_trials as u64).map(move |trial| Trial {
                scheme: None,
                parameters: Parameters {
                    filter: FilterParameters {
                        method: Method::Doppler,
                        ..lab.parameters.filter
                    },
                    ..lab.parameters.clone()
                },
                trial,
                noise: Some(Noise { snr_db, trial }),
            })
        })
        .collect();
    let results = lab.trials("snr", &trials)?;
    let mut table = Table::new(["snr_db", "trial", "mae_m"]);
    for (trial, result) in trials.iter().zip(&results) {
        let snr_db = trial.noise.map_or(f64::NAN, |noise| noise.snr_db);
        table.push([
            cell(snr_db, 1),
            trial.trial.to_string(),
            cell(result.mae_m(), 6),
        ]);
    }
    table.write(&lab.data("snr.csv"))?;
    summary.snr = lab
        .plan
        .snr_db
        .iter()
        .zip(results.chunks(lab.plan.noise_trials))
        .map(|(&snr_db, results)| NoiseCell {
            snr_db,
            accuracy: accuracy(results),
        })
        .collect();
    Ok(())
}
