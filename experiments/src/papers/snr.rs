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
pub(super) fn specs(session: &PaperSession) -> Vec<RecordingSpec> {
    let mut specs = session.recordings.localization_specs(None);
    specs.push(
        session
            .recordings
            .direct_spec(&session.recordings.spec("localization", None)),
    );
    specs
}

/// Runs the study.
pub(super) fn run(session: &PaperSession, snr_db: &[f64], summary: &mut Summary) -> Result<()> {
    let count = session.seeds().noise;
    let trials: Vec<Trial> = snr_db
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
    summary.snr = snr_db
        .iter()
        .zip(results.chunks(count))
        .map(|(&snr_db, results)| NoiseCell {
            snr_db,
            accuracy: accuracy(results),
        })
        .collect();
    Ok(())
}
