//! Position error over the signal-to-noise ratio, eqs. (19)-(21) (Fig. 9).

use anyhow::Result;

use super::PaperSession;
use super::cells::doppler_trials;
use crate::data::table::{Table, cell};
use crate::recordings::noise::Noise;
use crate::recordings::spec::RecordingSpec;
use crate::summary::{NoiseCell, Summary};
use crate::trials::{self, Trial, accuracy};

/// Recordings of the study: the direct wave of the localization drive gives the power of the reflected signal.
pub(crate) fn specs(session: &PaperSession) -> Vec<RecordingSpec> {
    let mut specs = session.recordings.localization_specs(None);
    specs.push(
        session
            .recordings
            .direct_spec(&session.recordings.spec("localization", None)),
    );
    specs
}

/// Runs the study.
pub(crate) fn run(session: &PaperSession, summary: &mut Summary) -> Result<()> {
    let count = session.plan.noise_trials;
    let trials: Vec<Trial> = session
        .plan
        .snr_db
        .iter()
        .flat_map(|&snr_db| {
            doppler_trials(&session.parameters, count)
                .into_iter()
                .map(move |plain| Trial {
                    noise: Some(Noise {
                        snr_db,
                        trial: plain.trial,
                    }),
                    ..plain
                })
        })
        .collect();
    let results = trials::run(session, "snr", &trials)?;
    let mut table = Table::new(["snr_db", "trial", "mae_m"]);
    for (trial, result) in trials.iter().zip(&results) {
        let snr_db = trial.noise.map_or(f64::NAN, |noise| noise.snr_db);
        table.push([
            cell(snr_db, 1),
            trial.trial.to_string(),
            cell(result.mae_m(), 6),
        ]);
    }
    table.write(&session.data("snr.csv"))?;
    summary.snr = session
        .plan
        .snr_db
        .iter()
        .zip(results.chunks(session.plan.noise_trials))
        .map(|(&snr_db, results)| NoiseCell {
            snr_db,
            accuracy: accuracy(results),
        })
        .collect();
    Ok(())
}
