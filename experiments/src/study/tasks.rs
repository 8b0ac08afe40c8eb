//! The tasks of a study, and workers that do them: simulations, and batches of trials on their recordings.
//!
//! The cache is the only state. A worker takes the lease of a task before it begins, so that any number of workers, on
//! any number of machines that share the cache, do every task once.

use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use serde::Serialize;

use super::Study;
use super::plan::{Batch, Plan};
use crate::data::lease::Asked;
use crate::run::interrupt;
use crate::run::progress::Task as Progress;
use crate::session::{Session, Workspace};
use crate::trials::{self, Trial, TrialResult};

/// Pause before a batch that another worker has is looked at again.
const LOOK_AGAIN: Duration = Duration::from_millis(200);

/// A task, as `echolot plan` lists it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct TaskLine {
    /// Its key: the hash of all that determines what it makes.
    pub key: String,
    /// What it makes.
    pub kind: &'static str,
    /// Name for people.
    pub label: String,
    /// Keys of the tasks that have to be done before.
    pub needs: Vec<String>,
    /// Number of trials.
    pub trials: usize,
    /// Whether its results are in the cache, or nothing that is left to do needs them.
    pub done: bool,
}

impl Plan {
    /// All tasks: simulations first.
    pub fn tasks(&self, study: &Study, workspace: &Workspace) -> Vec<TaskLine> {
        let simulations = self.jobs.iter().map(|(job, done)| TaskLine {
            key: job.key.clone(),
            kind: "simulation",
            label: job.label.clone(),
            needs: Vec::new(),
            trials: 0,
            done: *done,
        });
        let batches = self.batches.iter().map(|batch| TaskLine {
            key: batch.key.clone(),
            kind: "trials",
            label: self.label(study, batch),
            needs: batch.needs.clone(),
            trials: batch.members.len(),
            done: self.is_done(batch, workspace),
        });
        simulations.chain(batches).collect()
    }

    /// Number of tasks whose results are in the cache, by a quick look.
    pub fn done(&self, workspace: &Workspace) -> u64 {
        let jobs = self.jobs.iter();
        let simulated =
            jobs.filter(|(job, done)| *done || workspace.cache.recording(&job.key).is_dir());
        let batches = self.batches.iter();
        let run = batches.filter(|batch| self.is_done(batch, workspace));
        (simulated.count() + run.count()) as u64
    }

    /// Name of a batch for people.
    fn label(&self, study: &Study, batch: &Batch) -> String {
        let first = batch.members.first().map(|&index| &self.trials[index]);
        first.map_or(String::new(), |planned| {
            let method = study.file.methods[planned.method].method().name();
            let prefix = &self.setups[batch.session].prefix;
            format!("{prefix}{method} ({})", study.cells[planned.cell].name())
        })
    }

    /// Whether the results of a batch are in the cache.
    fn is_done(&self, batch: &Batch, workspace: &Workspace) -> bool {
        batch
            .members
            .iter()
            .all(|&index| workspace.cache.has("trials", &self.trials[index].key))
    }
}

/// Simulates what is missing.
pub(super) fn simulate(plan: &Plan, workspace: &Workspace) -> Result<()> {
    workspace.simulate(&plan.missing())?;
    Ok(interrupt::check()?)
}

/// Runs all trials that are left; batches that other workers have are waited for.
pub(super) fn run_trials(study: &Study, plan: &Plan, workspace: &Workspace) -> Result<()> {
    let task = workspace.board.task(
        format!("trials of {}", study.file.name),
        plan.trials.len() as u64,
    );
    let mut left: Vec<&Batch> = plan.batches.iter().collect();
    let mut done = 0;
    while !left.is_empty() {
        let mut busy = Vec::new();
        let before = left.len();
        for batch in left {
            interrupt::check()?;
            match run_batch(study, plan, batch, workspace, &task, done)? {
                true => {
                    done += batch.members.len() as u64;
                    task.set(done);
                }
                false => busy.push(batch),
            }
        }
        if busy.len() == before {
            std::thread::sleep(LOOK_AGAIN);
        }
        left = busy;
    }
    task.finish();
    Ok(())
}

/// Runs the trials of a batch under its lease; false while another worker has it.
fn run_batch(
    study: &Study,
    plan: &Plan,
    batch: &Batch,
    workspace: &Workspace,
    task: &Progress,
    done: u64,
) -> Result<bool> {
    if plan.is_done(batch, workspace) {
        return Ok(true);
    }
    let Asked::Held(lease) = workspace.cache.lease(&batch.key)? else {
        return Ok(false);
    };
    let setup = &plan.setups[batch.session];
    let session = Session::new(setup.clone(), workspace)?;
    let trials: Vec<Trial> = batch
        .members
        .iter()
        .map(|&index| plan.trials[index].trial.clone())
        .collect();
    let is_missing = |index: &&usize| !workspace.cache.has("trials", &plan.trials[**index].key);
    let missing = batch.members.iter().filter(is_missing).count();
    let started = Instant::now();
    trials::run_under(&session, task, done, &trials)
        .with_context(|| format!("{} of study {}", plan.label(study, batch), study.file.name))?;
    let took = (missing, started.elapsed().as_secs_f64());
    plan.note_speed(study, batch, took, workspace);
    drop(lease);
    Ok(true)
}

/// Does the tasks with these keys; all that are left where there are none.
///
/// # Errors
/// A key that the study does not have, a task whose recordings are not there yet, or the first failure.
pub fn work(study: &Study, plan: &Plan, keys: &[String], workspace: &Workspace) -> Result<()> {
    if keys.is_empty() {
        simulate(plan, workspace)?;
        return run_trials(study, plan, workspace);
    }
    let is_known = |key: &String| {
        plan.jobs.iter().any(|(job, _)| job.key == *key)
            || plan.batches.iter().any(|batch| batch.key == *key)
    };
    if let Some(key) = keys.iter().find(|key| !is_known(key)) {
        bail!(
            "{key}: is no task of study {}; `echolot plan` lists them",
            study.file.name
        );
    }
    let jobs: Vec<_> = plan
        .missing()
        .into_iter()
        .filter(|job| keys.contains(&job.key))
        .collect();
    workspace.simulate(&jobs)?;
    let task = workspace.board.task("trials", keys.len() as u64);
    for batch in plan
        .batches
        .iter()
        .filter(|batch| keys.contains(&batch.key))
    {
        let missing = batch
            .needs
            .iter()
            .find(|key| !workspace.cache.has_recording(key));
        if let Some(missing) = missing {
            bail!(
                "{}: needs task {missing}, which is not done; do that first",
                batch.key
            );
        }
        while !run_batch(study, plan, batch, workspace, &task, 0)? {
            interrupt::check()?;
            std::thread::sleep(LOOK_AGAIN);
        }
    }
    Ok(interrupt::check()?)
}

/// Results of all trials in their order.
///
/// # Errors
/// When a trial has not been run.
pub(super) fn results(
    study: &Study,
    plan: &Plan,
    workspace: &Workspace,
) -> Result<Vec<TrialResult>> {
    let found: Vec<Option<TrialResult>> = plan
        .trials
        .par_iter()
        .map(|planned| workspace.cache.get("trials", &planned.key))
        .collect();
    let missing = found.iter().filter(|result| result.is_none()).count();
    if missing > 0 {
        bail!(
            "study {}: {missing} of {} trials are not done; `echolot run` or `echolot task` does them",
            study.file.name,
            found.len()
        );
    }
    Ok(found.into_iter().flatten().collect())
}
