//! Position error when the field is computed with the standard leapfrog scheme.

use anyhow::Result;
use fdtd::scheme::Scheme;
use localizer::Method;

use super::PaperSession;
use super::cells::{method_name, trials_of};
use crate::data::table::{Table, cell};
use crate::recordings::spec::RecordingSpec;
use crate::summary::{SchemeAccuracy, Schemes, Summary};
use crate::trials::{self, Trial, accuracy};

/// Recordings of the study.
pub(super) fn specs(session: &PaperSession) -> Vec<RecordingSpec> {
    session.recordings.localization_specs(Some(Scheme::Slf))
}

/// Runs the study.
pub(super) fn run(session: &PaperSession, summary: &mut Summary) -> Result<()> {
    let trials: Vec<Trial> = [Method::Doppler, Method::ToaOnly]
        .into_iter()
        .flat_map(|method| trials_of(&session.parameters, method, session.seeds().filter))
        .map(|trial| Trial {
            scheme: Some(Scheme::Slf),
            ..trial
        })
        .collect();
    let results = trials::run(session, "schemes", &trials)?;
    let mut table = Table::new(["scheme", "method", "trial", "mae_m"]);
    for (trial, result) in trials.iter().zip(&results) {
        table.push([
            Scheme::Slf.name().to_string(),
            method_name(trial.parameters.filter.method).to_string(),
            trial.trial.to_string(),
            cell(result.mae_m(), 6),
        ]);
    }
    table.write(&session.data("schemes.csv"))?;
    let (doppler, toa_only) = results.split_at(session.seeds().filter);
    summary.schemes = Some(Schemes {
        slf: SchemeAccuracy {
            doppler: accuracy(doppler),
            toa_only: accuracy(toa_only),
        },
    });
    Ok(())
}
