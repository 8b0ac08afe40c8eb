//! Localization trials: measured echoes are shared, filter runs go in parallel, results are kept in the cache.

mod noisy;
mod plain;

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::{Context, Result};
use fdtd::scheme::Scheme;
use localizer::pose::wrap_angle;
use localizer::{Estimate, Parameters, Recording, random};
use serde::{Deserialize, Serialize};

use crate::cache::{Cache, Key};
use crate::laboratory::{Laboratory, measurement_of};
use crate::metrics::{Accuracy, rounded};
use crate::noise::Noise;
use crate::progress::Task;

/// Version of the code around the localizer that results depend on (noise, errors).
const VERSION: u32 = 2;

/// One run of the filter.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Scheme of the field; the scene's when `None`.
    pub scheme: Option<Scheme>,
    /// Parameters of the localizer.
    pub parameters: Parameters,
    /// Number of the filter's random stream. The same in every cell, so that cells differ by nothing else.
    pub trial: u64,
    /// Noise on the received signal.
    pub noise: Option<Noise>,
}

/// What a trial gave.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialResult {
    /// Times of the estimates, seconds.
    pub t_s: Vec<f64>,
    /// Estimated position, metres.
    pub x_m: Vec<f64>,
    /// Estimated position, metres.
    pub y_m: Vec<f64>,
    /// Estimated heading, radians.
    pub heading_rad: Vec<f64>,
    /// Distance from the true position, metres.
    pub error_m: Vec<f64>,
    /// Difference from the true heading, radians.
    pub heading_error_rad: Vec<f64>,
}

impl TrialResult {
    /// Mean distance from the true position, metres.
    pub fn mae_m(&self) -> f64 {
        crate::metrics::mean(&self.error_m)
    }
}

/// Accuracy over trials.
pub fn accuracy(results: &[TrialResult]) -> Accuracy {
    let errors: Vec<(&[f64], &[f64])> = results
        .iter()
        .map(|result| {
            (
                result.error_m.as_slice(),
                result.heading_error_rad.as_slice(),
            )
        })
        .collect();
    Accuracy::over(&errors)
}

/// The number of a trial in a study, and what it gave.
type Finished = (usize, TrialResult);

/// Where results go, and how far a study is.
struct Output<'a> {
    cache: &'a Cache,
    /// Names of the trials' results in the cache.
    keys: &'a [String],
    task: &'a Task,
    done: AtomicU64,
    /// Most that was shown: what is on its way does not seem undone when it arrives.
    shown: AtomicU64,
}

impl Output<'_> {
    /// Keeps the result of a trial, which is thereby done.
    fn keep(&self, index: usize, result: &TrialResult) -> Result<()> {
        self.cache.put("trials", &self.keys[index], result)?;
        self.done.fetch_add(1, Ordering::Relaxed);
        self.show(0);
        Ok(())
    }

    /// Shows that beside the trials done some are on their way, as if so many were done.
    fn show(&self, on_their_way: usize) {
        let count = self.done.load(Ordering::Relaxed) + on_their_way as u64;
        let before = self.shown.fetch_max(count, Ordering::Relaxed);
        self.task.set(before.max(count));
    }
}

/// Trials that share measured echoes.
struct Group<'a> {
    scheme: Option<Scheme>,
    parameters: Parameters,
    noise: Option<Noise>,
    members: Vec<(usize, &'a Trial)>,
}

impl Laboratory {
    /// Results of the trials in their order, from the cache where it has them. `label` names the progress bar.
    ///
    /// # Errors
    /// When a recording is missing (see [`Laboratory::simulate`]), the localizer refuses one, or the user interrupts.
    pub fn trials(&self, label: &str, trials: &[Trial]) -> Result<Vec<TrialResult>> {
        let keys = trials
            .iter()
            .map(|trial| self.trial_key(trial))
            .collect::<Result<Vec<_>>>()?;
        let mut results: Vec<Option<TrialResult>> = keys
            .iter()
            .map(|key| self.cache.get("trials", key))
            .collect();
        let groups = self.groups(trials, &results)?;
        let missing: u64 = groups.iter().map(|group| group.members.len() as u64).sum();
        let task = self.board.task(label, missing);
        let output = Output {
            cache: &self.cache,
            keys: &keys,
            task: &task,
            done: AtomicU64::new(0),
            shown: AtomicU64::new(0),
        };
        let (noisy, plain): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group| group.noise.is_some());
        let mut finished = self.plain_trials(plain, &output)?;
        finished.extend(self.noisy_trials(noisy, &output)?);
        task.finish();
        for (index, result) in finished {
            results[index] = Some(result);
        }
        results
            .into_iter()
            .map(|result| result.context("a trial has no result"))
            .collect()
    }

    /// Key of a trial: everything that determines its result.
    fn trial_key(&self, trial: &Trial) -> Result<String> {
        let mut key = Key::new("trial");
        key.numbers("version", &[f64::from(VERSION)]);
        key.text("localizer", env!("LOCALIZER_PRINT"));
        for path in ["mapping", "localization"] {
            key.text(path, &self.key(&self.take(path, trial.scheme))?);
        }
        if let Some(robot) = &self.robot {
            key.value("robot", robot)?;
        }
        key.value("parameters", &trial.parameters)?;
        key.value("trial", &trial.trial)?;
        key.value("noise", &trial.noise)?;
        Ok(key.finish())
    }

    /// The trials without result, grouped by the echoes they share, in order of appearance.
    fn groups<'a>(
        &self,
        trials: &'a [Trial],
        results: &[Option<TrialResult>],
    ) -> Result<Vec<Group<'a>>> {
        let mut groups: Vec<Group<'a>> = Vec::new();
        let mut places: HashMap<String, usize> = HashMap::new();
        for (index, trial) in trials
            .iter()
            .enumerate()
            .filter(|(index, _)| results[*index].is_none())
        {
            let parameters = measurement_of(&trial.parameters, &self.parameters);
            let name = serde_json::to_string(&(trial.scheme, &parameters, trial.noise))?;
            let place = *places.entry(name).or_insert(groups.len());
            if place == groups.len() {
                groups.push(Group {
                    scheme: trial.scheme,
                    parameters,
                    noise: trial.noise,
                    members: Vec::new(),
                });
            }
            groups[place].members.push((index, trial));
        }
        Ok(groups)
    }
}

/// Random stream of a trial's filter.
fn seed_of(trial: &Trial) -> u64 {
    random::trial_seed("filter", "", trial.trial)
}

/// What a filter's estimates are off the truth of a recording.
///
/// # Errors
/// When the recording has no truth.
fn result_of(recording: &Recording, estimates: &[Estimate]) -> Result<TrialResult> {
    let truth = recording
        .truth
        .as_ref()
        .context("recording: truth.tum: is missing")?;
    let mut result = TrialResult {
        t_s: Vec::new(),
        x_m: Vec::new(),
        y_m: Vec::new(),
        heading_rad: Vec::new(),
        error_m: Vec::new(),
        heading_error_rad: Vec::new(),
    };
    for estimate in estimates {
        let pose = estimate.pose;
        let true_pose = truth
            .pose_at(estimate.t_s)
            .context("recording: truth.tum: is empty")?;
        result.t_s.push(rounded(estimate.t_s));
        result.x_m.push(rounded(pose.x_m));
        result.y_m.push(rounded(pose.y_m));
        result.heading_rad.push(rounded(pose.heading_rad));
        result.error_m.push(rounded(pose.distance_m(&true_pose)));
        result.heading_error_rad.push(rounded(wrap_angle(
            pose.heading_rad - true_pose.heading_rad,
        )));
    }
    Ok(result)
}
