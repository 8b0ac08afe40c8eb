//! Trials without noise: the echoes of a whole drive are measured once for all trials that share them.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use anyhow::{Context, Result};
use localizer::{EchoSequence, MapImage, Recording, offline};
use rayon::prelude::*;

use super::{Finished, Group, Output, Trial, TrialResult, result_of, seed_of};
use crate::interrupt;
use crate::laboratory::Laboratory;

/// Most sets of measured echoes on which trials run at the same time; up to as many more are being measured.
const MOST_SEQUENCES: usize = 4;

/// Echoes, map and truth on which filters are tried.
struct Bench {
    recording: Arc<Recording>,
    sequence: Arc<EchoSequence>,
    map: Arc<MapImage>,
}

impl Bench {
    /// Runs the filter once.
    fn run(&self, trial: &Trial) -> Result<TrialResult> {
        let start = self.recording.start_pose();
        let parameters = &trial.parameters;
        let estimates =
            offline::localize(&self.sequence, &self.map, parameters, start, seed_of(trial))?;
        result_of(&self.recording, &estimates)
    }
}

impl Laboratory {
    /// Runs the trials of groups without noise. What the next groups need is measured while the last trials of those before run.
    pub(super) fn plain_trials(
        &self,
        groups: Vec<Group<'_>>,
        output: &Output<'_>,
    ) -> Result<Vec<Finished>> {
        let batches: Vec<&[Group<'_>]> = groups
            .chunks(self.threads.clamp(1, MOST_SEQUENCES))
            .collect();
        let measure = |batch: &[Group<'_>]| {
            batch
                .iter()
                .map(|group| self.bench(group))
                .collect::<Result<Vec<Bench>>>()
        };
        let mut finished = Vec::new();
        let mut measured = batches.first().map(|batch| measure(batch));
        for (number, batch) in batches.iter().enumerate() {
            interrupt::check()?;
            let benches = measured.take().context("no echoes were measured")??;
            let runs: Vec<(usize, &Trial, &Bench)> = batch
                .iter()
                .zip(&benches)
                .flat_map(|(group, bench)| {
                    let members = group.members.iter();
                    members.map(move |(index, trial)| (*index, *trial, bench))
                })
                .collect();
            let begun = AtomicUsize::new(0);
            let next = Mutex::new(None);
            let results = rayon::scope(|scope| {
                // One by one: a piece of several that one thread has begun is not shared any more.
                runs.par_iter()
                    .with_max_len(1)
                    .map(|(index, trial, bench)| {
                        interrupt::check()?;
                        let last = begun.fetch_add(1, Ordering::Relaxed) + 1 == runs.len();
                        if let (true, Some(batch)) = (last, batches.get(number + 1)) {
                            // From here on there are threads without a trial.
                            scope.spawn(|_| {
                                let benches = measure(batch);
                                if let Ok(mut next) = next.lock() {
                                    *next = Some(benches);
                                }
                            });
                        }
                        let result = bench.run(trial)?;
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

    /// Measures what the trials of a group share.
    fn bench(&self, group: &Group<'_>) -> Result<Bench> {
        let take = self.take("localization", group.scheme);
        Ok(Bench {
            map: self.map(group.scheme, &group.parameters)?,
            recording: Arc::new(self.recording(&take, false)?),
            sequence: self.echoes(&take, &group.parameters)?,
        })
    }
}
