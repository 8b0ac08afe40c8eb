//! Trials in groups that share measured echoes, and the output of their results.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::Result;
use fdtd::scheme::Scheme;
use localizer::Parameters;

use super::trial::{Approach, Trial, TrialResult};
use crate::data::cache::Cache;
use crate::recordings::noise::Noise;
use crate::run::progress::Task;
use crate::session::measurement_of;

/// The number of a trial in a study, and its result.
pub(super) type Finished = (usize, TrialResult);

/// Trials that share measured echoes.
pub(super) struct Group<'a> {
    /// Scheme of the field; the scene's when `None`.
    pub(super) scheme: Option<Scheme>,
    /// What poses are found by.
    pub(super) approach: Approach,
    /// Parameters of the measurement.
    pub(super) parameters: Parameters,
    /// Noise on the received signal.
    pub(super) noise: Option<Noise>,
    /// Whether the mapping drive has noise too.
    pub(super) noisy_mapping: bool,
    /// The trials with their numbers in the study.
    pub(super) members: Vec<(usize, &'a Trial)>,
}

impl<'a> Group<'a> {
    /// The trials without result, grouped by the echoes they share, in order of appearance. `base` is the session's
    /// parameters.
    pub(super) fn of(
        trials: &'a [Trial],
        results: &[Option<TrialResult>],
        base: &Parameters,
    ) -> Result<Vec<Self>> {
        let mut groups: Vec<Self> = Vec::new();
        let mut places: HashMap<String, usize> = HashMap::new();
        for (index, trial) in trials
            .iter()
            .enumerate()
            .filter(|(index, _)| results[*index].is_none())
        {
            let parameters = measurement_of(&trial.parameters, base);
            let name = serde_json::to_string(&(
                trial.scheme,
                trial.approach,
                &parameters,
                trial.noise,
                trial.noisy_mapping,
            ))?;
            let place = *places.entry(name).or_insert(groups.len());
            if place == groups.len() {
                groups.push(Self {
                    scheme: trial.scheme,
                    approach: trial.approach,
                    parameters,
                    noise: trial.noise,
                    noisy_mapping: trial.noisy_mapping,
                    members: Vec::new(),
                });
            }
            groups[place].members.push((index, trial));
        }
        Ok(groups)
    }

    /// The noise of the mapping drive.
    pub(super) fn mapping_noise(&self) -> Option<Noise> {
        self.noise
            .filter(|_| self.noisy_mapping)
            .map(Noise::of_mapping)
    }

    /// Whether this group and another differ in nothing but their noise, and share a map.
    pub(super) fn differs_in_noise(&self, other: &Group<'_>) -> bool {
        self.scheme == other.scheme
            && self.parameters == other.parameters
            && self.mapping_noise() == other.mapping_noise()
    }
}

/// Destination of results, and progress of a study.
pub(super) struct Output<'a> {
    cache: &'a Cache,
    /// Keys of the trials' results in the cache.
    keys: &'a [String],
    task: &'a Task,
    done: AtomicU64,
    /// Greatest count shown, so that progress never runs backwards.
    shown: AtomicU64,
}

impl<'a> Output<'a> {
    /// An output without results. `keys` are those of all trials; `known` parts of the task are done.
    pub(super) fn new(cache: &'a Cache, keys: &'a [String], task: &'a Task, known: u64) -> Self {
        Self {
            cache,
            keys,
            task,
            done: AtomicU64::new(known),
            shown: AtomicU64::new(0),
        }
    }

    /// Puts the result of a trial into the cache and counts it as done.
    pub(super) fn keep(&self, index: usize, result: &TrialResult) -> Result<()> {
        self.cache.put("trials", &self.keys[index], result)?;
        self.done.fetch_add(1, Ordering::Relaxed);
        self.show(0);
        Ok(())
    }

    /// Shows the trials done, and `in_progress` more that are partly done.
    pub(super) fn show(&self, in_progress: usize) {
        let count = self.done.load(Ordering::Relaxed) + in_progress as u64;
        let before = self.shown.fetch_max(count, Ordering::Relaxed);
        self.task.set(before.max(count));
    }
}
