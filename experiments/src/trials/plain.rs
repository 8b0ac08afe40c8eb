//! Trials without noise: the echoes of a whole drive are measured once for all trials that share them.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use anyhow::{Context, Result};
use localizer::{EchoSequence, MapImage, Recording, offline};
use rayon::prelude::*;

use super::group::{Finished, Group, Output};
use super::trial::{Found, Trial, TrialResult};
use crate::run::interrupt;
use crate::session::Session;

/// Most sets of measured echoes on which trials run at the same time; up to as many more are being measured.
const MOST_SEQUENCES: usize = 4;

/// Echoes, map and truth that the trials of a group share.
struct Measured {
    recording: Recording,
    sequence: Arc<EchoSequence>,
    map: Arc<MapImage>,
}

impl Measured {
    /// Measures the recordings of a group.
    fn of(session: &Session, group: &Group<'_>) -> Result<Self> {
        let spec = session.recordings.spec("localization", group.scheme);
        Ok(Self {
            map: session.measurements.map(group.scheme, &group.parameters)?,
            recording: session.recordings.read(&spec, false)?,
            sequence: session.measurements.echoes(&spec, &group.parameters)?,
        })
    }

    /// Runs the filter once.
    fn run(&self, trial: &Trial) -> Result<TrialResult> {
        let start = self.recording.start_pose();
        let parameters = &trial.parameters;
        let estimates =
            offline::localize(&self.sequence, &self.map, parameters, start, trial.seed())?;
        let found: Vec<Found> = estimates.iter().map(Found::from).collect();
        TrialResult::of(&self.recording, &found)
    }
}

/// Runs the trials of groups without noise. The measurements of the next groups run beside the last trials of the
/// groups before.
pub(super) fn run(
    session: &Session,
    groups: &[Group<'_>],
    output: &Output<'_>,
) -> Result<Vec<Finished>> {
    let batches: Vec<&[Group<'_>]> = groups
        .chunks(session.threads.clamp(1, MOST_SEQUENCES))
        .collect();
    let measure = |batch: &[Group<'_>]| {
        batch
            .iter()
            .map(|group| Measured::of(session, group))
            .collect::<Result<Vec<Measured>>>()
    };
    let mut finished = Vec::new();
    let mut measured = batches.first().map(|batch| measure(batch));
    for (number, batch) in batches.iter().enumerate() {
        interrupt::check()?;
        let shared_by_group = measured.take().context("no echoes were measured")??;
        let runs: Vec<(usize, &Trial, &Measured)> = batch
            .iter()
            .zip(&shared_by_group)
            .flat_map(|(group, shared)| {
                let members = group.members.iter();
                members.map(move |(index, trial)| (*index, *trial, shared))
            })
            .collect();
        let begun = AtomicUsize::new(0);
        let next = Mutex::new(None);
        let results = rayon::scope(|scope| {
            // One by one: rayon does not share a batch of several that one thread has begun.
            runs.par_iter()
                .with_max_len(1)
                .map(|(index, trial, shared)| {
                    interrupt::check()?;
                    let last = begun.fetch_add(1, Ordering::Relaxed) + 1 == runs.len();
                    if let (true, Some(batch)) = (last, batches.get(number + 1)) {
                        // From here on there are threads without a trial.
                        scope.spawn(|_| {
                            let shared_by_group = measure(batch);
                            if let Ok(mut next) = next.lock() {
                                *next = Some(shared_by_group);
                            }
                        });
                    }
                    let result = shared.run(trial)?;
                    output.keep(*index, &result)?;
                    Ok((*index, result))
                })
                .collect::<Result<Vec<_>>>()
        });
        finished.extend(results?);
        measured = next.into_inner().unwrap_or_default();
    }
    Ok(finished)
}
