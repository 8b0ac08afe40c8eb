//! Localization trials: measured echoes are shared, filter runs go in parallel, results are kept in the cache.

use std::collections::HashMap;
use std::sync::Arc;

use anyhow::{Context, Result};
use fdtd::scheme::Scheme;
use localizer::pose::wrap_angle;
use localizer::{EchoSequence, MapImage, Parameters, Recording, echoes, offline, random};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::cache::Key;
use crate::interrupt;
use crate::laboratory::{Laboratory, measurement_of};
use crate::metrics::{Accuracy, rounded};
use crate::noise::Noise;

/// Version of the code around the localizer that results depend on (noise, errors).
const VERSION: u32 = 2;

/// Most sets of measured echoes without noise held in memory at the same time.
const MOST_SEQUENCES: usize = 4;

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
    /// When a recording is missing (see [`Laboratory::record`]), the localizer refuses one, or the user interrupts.
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
        let mut done = 0;
        for batch in batches(groups, self.threads.clamp(1, MOST_SEQUENCES)) {
            interrupt::check()?;
            let benches = self.benches(&batch)?;
            let runs: Vec<(usize, &Trial, &Bench)> = batch
                .iter()
                .zip(&benches)
                .flat_map(|(group, bench)| {
                    group
                        .members
                        .iter()
                        .map(move |(index, trial)| (*index, *trial, bench))
                })
                .collect();
            let finished = runs
                .par_iter()
                .map(|(index, trial, bench)| {
                    interrupt::check()?;
                    let result = bench.run(trial)?;
                    self.cache.put("trials", &keys[*index], &result)?;
                    Ok((*index, result))
                })
                .collect::<Result<Vec<_>>>()?;
            done += finished.len() as u64;
            task.set(done);
            for (index, result) in finished {
                results[index] = Some(result);
            }
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

    /// Measures what the trials of each group share.
    fn benches(&self, batch: &[Group<'_>]) -> Result<Vec<Bench>> {
        let Some(noise) = batch.first().and_then(|group| group.noise) else {
            return batch.iter().map(|group| self.bench(group)).collect();
        };
        // They differ in the level of the noise only.
        let group = &batch[0];
        let map = self.map(group.scheme, &group.parameters)?;
        let take = self.take("localization", group.scheme);
        let recording = Arc::new(self.recording(&take, true)?);
        let direct = recording.direct.as_deref().unwrap_or_default();
        let samples = noise.samples(recording.signal.len());
        let levels: Vec<f32> = batch
            .iter()
            .filter_map(|group| group.noise)
            .map(|noise| noise.level(&recording.signal, direct, &samples) as f32)
            .collect();
        let samples: Vec<f32> = samples.iter().map(|&sample| sample as f32).collect();
        let sequences = echoes::measure_noisy(&recording, &samples, &levels, &group.parameters)?;
        let bench = |sequence| Bench {
            recording: Arc::clone(&recording),
            sequence,
            map: Arc::clone(&map),
        };
        Ok(sequences.into_iter().map(bench).collect())
    }

    /// Measures what the trials of a group without noise share.
    fn bench(&self, group: &Group<'_>) -> Result<Bench> {
        let map = self.map(group.scheme, &group.parameters)?;
        let take = self.take("localization", group.scheme);
        let recording = Arc::new(self.recording(&take, false)?);
        let sequence = echoes::measure(&recording, &group.parameters)?;
        Ok(Bench {
            recording,
            sequence,
            map,
        })
    }
}

/// Groups that are measured together, in order of appearance: all that differ in nothing but the level of one noise; of those without noise, up to
/// `most`.
fn batches(groups: Vec<Group<'_>>, most: usize) -> Vec<Vec<Group<'_>>> {
    let mut batches: Vec<Vec<Group<'_>>> = Vec::new();
    for group in groups {
        let place = batches.iter().position(|batch| match group.noise {
            Some(noise) => batch[0].differs_in_level(&group, noise),
            None => batch[0].noise.is_none() && batch.len() < most,
        });
        match place {
            Some(place) => batches[place].push(group),
            None => batches.push(vec![group]),
        }
    }
    batches
}

impl Group<'_> {
    /// Whether another group's noise is this one's but for its level, and all else the same.
    fn differs_in_level(&self, other: &Group<'_>, noise: Noise) -> bool {
        self.noise.is_some_and(|own| own.trial == noise.trial)
            && self.scheme == other.scheme
            && self.parameters == other.parameters
    }
}

/// Echoes, map and truth on which filters are tried.
struct Bench {
    recording: Arc<Recording>,
    sequence: EchoSequence,
    map: Arc<MapImage>,
}

impl Bench {
    /// Runs the filter once.
    fn run(&self, trial: &Trial) -> Result<TrialResult> {
        let seed = random::trial_seed("filter", "", trial.trial);
        let start = self.recording.start_pose();
        let estimates =
            offline::localize(&self.sequence, &self.map, &trial.parameters, start, seed)?;
        let truth = self
            .recording
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
}
