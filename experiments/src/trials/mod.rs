//! Localization trials: measured echoes are shared, filter runs go in parallel, results are kept in the cache.

pub mod arrivals;
pub mod drives;
mod group;
mod noise_sweep;
mod plain;
mod surroundings;
mod trial;
mod watch;

use anyhow::{Context, Result};

use self::group::{Group, Output};
use crate::data::cache::Key;
use crate::run::progress::Task;
use crate::session::Session;

pub use self::surroundings::{Surroundings, surroundings};
pub use self::trial::{Approach, Trial, TrialResult, accuracy};
pub use self::watch::watch;

/// Version of the code around the localizer that results depend on (noise, errors).
const VERSION: u32 = 3;

/// Results of the trials in their order, from the cache where it has them. `label` names the progress bar.
///
/// # Errors
/// When a recording is missing (see [`Session::simulate`]), the localizer refuses one, or the user interrupts.
pub fn run(session: &Session, label: &str, trials: &[Trial]) -> Result<Vec<TrialResult>> {
    let task = session.board.task(label, trials.len() as u64);
    let results = run_under(session, &task, 0, trials)?;
    task.finish();
    Ok(results)
}

/// As [`run`], as a part of a task of which `before` parts are done.
///
/// # Errors
/// As [`run`].
pub fn run_under(
    session: &Session,
    task: &Task,
    before: u64,
    trials: &[Trial],
) -> Result<Vec<TrialResult>> {
    let keys = trials
        .iter()
        .map(|trial| key_of(session, trial))
        .collect::<Result<Vec<_>>>()?;
    let mut results: Vec<Option<TrialResult>> = keys
        .iter()
        .map(|key| session.cache.get("trials", key))
        .collect();
    let groups = Group::of(trials, &results, &session.parameters)?;
    let missing: usize = groups.iter().map(|group| group.members.len()).sum();
    let known = before + (trials.len() - missing) as u64;
    task.set(known);
    let output = Output::new(&session.cache, &keys, task, known);
    let (images, others): (Vec<_>, Vec<_>) = groups
        .into_iter()
        .partition(|group| group.approach == Approach::Images);
    let (noisy, plain): (Vec<_>, Vec<_>) =
        images.into_iter().partition(|group| group.noise.is_some());
    let mut finished = plain::run(session, &plain, &output)?;
    finished.extend(noise_sweep::run(session, noisy, &output)?);
    finished.extend(drives::run(session, &others, &output)?);
    for (index, result) in finished {
        results[index] = Some(result);
    }
    results
        .into_iter()
        .map(|result| result.context("a trial has no result"))
        .collect()
}

/// Key of a trial: everything that determines its result.
///
/// # Errors
/// When the scene has no such drives or the engine does not run.
pub fn key_of(session: &Session, trial: &Trial) -> Result<String> {
    let recordings = &session.recordings;
    let mut key = Key::new("trial");
    key.numbers("version", &[f64::from(VERSION)]);
    key.text("localizer", env!("LOCALIZER_FINGERPRINT"));
    for path in ["mapping", "localization"] {
        key.text(path, &recordings.key(&recordings.spec(path, trial.scheme))?);
    }
    if let Some(robot) = recordings.robot() {
        key.value("robot", robot)?;
    }
    key.value("parameters", &trial.parameters)?;
    key.value("trial", &trial.trial)?;
    key.value("noise", &trial.noise)?;
    if trial.approach != Approach::Images {
        key.value("approach", &trial.approach)?;
    }
    if trial.noisy_mapping {
        key.value("noisy mapping", &trial.noisy_mapping)?;
    }
    Ok(key.finish())
}
