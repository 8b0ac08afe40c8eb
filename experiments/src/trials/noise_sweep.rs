//! Trials with noise on the received signal: all noises and levels run through the drive together, some blocks at a
//! time.

use anyhow::{Context, Result};
use localizer::echo::noise_sweep::{AddedNoise, NoiseSweep};
use localizer::filter::tracker::Tracker;
use localizer::{Estimate, offline};
use rayon::prelude::*;

use super::group::{Finished, Group, Output};
use super::trial::{Found, TrialResult};
use crate::recordings::noise::Noise;
use crate::run::interrupt;
use crate::session::Session;

/// Echoes held in memory at the same time, in blocks of one drive: some 0.3 GB of the paper's.
const MOST_BLOCKS: usize = 900;

/// Most blocks that are measured together, so that no filter waits long for another.
const MOST_TOGETHER: usize = 32;

/// A filter in the course of a drive with noise.
struct Run {
    /// Its number in the study.
    index: usize,
    /// Its noise and level, counted as the echoes are.
    drive: usize,
    tracker: Tracker,
    estimates: Vec<Estimate>,
}

/// Runs the trials of groups with noise.
pub(super) fn run(
    session: &Session,
    groups: Vec<Group<'_>>,
    output: &Output<'_>,
) -> Result<Vec<Finished>> {
    let mut sets: Vec<Vec<Group<'_>>> = Vec::new();
    for group in groups {
        let place = sets.iter().position(|set| set[0].differs_in_noise(&group));
        match place {
            Some(place) => sets[place].push(group),
            None => sets.push(vec![group]),
        }
    }
    let mut finished = Vec::new();
    for set in sets {
        finished.extend(run_set(session, &set, output)?);
    }
    Ok(finished)
}

/// Runs the trials of groups that differ in nothing but their noise.
fn run_set(session: &Session, set: &[Group<'_>], output: &Output<'_>) -> Result<Vec<Finished>> {
    let (scheme, parameters) = (set[0].scheme, &set[0].parameters);
    let map = session
        .measurements
        .noisy_map(scheme, set[0].mapping_noise(), parameters)?;
    let recording = session
        .recordings
        .read(&session.recordings.spec("localization", scheme), true)?;
    let direct = recording.direct.as_deref().unwrap_or_default();
    // Groups by the number of their noise: the samples are the same, whatever the level.
    let mut noises: Vec<(Noise, Vec<&Group<'_>>)> = Vec::new();
    for group in set {
        let noise = group
            .noise
            .context("a trial without noise among those with it")?;
        match noises
            .iter_mut()
            .find(|(known, _)| known.trial == noise.trial)
        {
            Some((_, groups)) => groups.push(group),
            None => noises.push((noise, vec![group])),
        }
    }
    let added: Vec<AddedNoise> = noises
        .par_iter()
        .map(|(noise, groups)| {
            let samples = noise.samples(recording.signal.len());
            let levels = groups.iter().filter_map(|group| group.noise);
            AddedNoise {
                levels: levels
                    .map(|noise| noise.level(&recording.signal, direct, &samples) as f32)
                    .collect(),
                samples: samples.iter().map(|&sample| sample as f32).collect(),
            }
        })
        .collect();
    let echoes = NoiseSweep::new(&recording, &added, parameters)?;
    let start = recording.start_pose();
    let mut runs = Vec::new();
    for (drive, group) in noises.iter().flat_map(|(_, groups)| groups).enumerate() {
        for &(index, trial) in &group.members {
            let wanted = &trial.parameters;
            runs.push(Run {
                index,
                drive,
                tracker: offline::tracker(parameters, &map, wanted, start, trial.seed())?,
                estimates: Vec::with_capacity(echoes.blocks()),
            });
        }
    }
    let together = (MOST_BLOCKS / set.len()).clamp(1, MOST_TOGETHER);
    let mut buffers = echoes.buffers(together.min(echoes.blocks()));
    let mut first = 0;
    while first < echoes.blocks() {
        interrupt::check()?;
        let count = buffers.len().min(echoes.blocks() - first);
        let blocks = &mut buffers[..count];
        echoes.measure(first, blocks);
        runs.par_iter_mut().with_max_len(1).for_each(|run| {
            for (offset, block) in blocks.iter().enumerate() {
                let recent = echoes.recent_odometry(first + offset);
                let estimate = run.tracker.update(&block[run.drive], recent, &map);
                run.estimates.push(estimate);
            }
        });
        first += count;
        output.show(runs.len() * first / echoes.blocks());
    }
    runs.into_iter()
        .map(|run| {
            let found: Vec<Found> = run.estimates.iter().map(Found::from).collect();
            let result = TrialResult::of(&recording, &found)?;
            output.keep(run.index, &result)?;
            Ok((run.index, result))
        })
        .collect()
}
