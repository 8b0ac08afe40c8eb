//! Several simulations side by side: each on its share of the threads, the longest first; threads that become free go
//! to the simulations that are left. All are resumable.

mod concurrency;
mod estimate;
mod job;

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Result, anyhow};

use self::concurrency::Concurrency;
use crate::data::atomic;
use crate::data::cache::Cache;
use crate::data::lease::Asked;
use crate::data::manifest::Manifest;
use crate::recordings::recording::recording;
use crate::recordings::simulate::{Checkpoint, RunOptions, signal};
use crate::recordings::spec::Engine;
use crate::run::interrupt;
use crate::run::progress::{Board, duration};

pub use self::estimate::{Estimate, estimate, steps_per_second};
pub use self::job::Job;

/// Pause before a job that another worker has is looked at again.
const LOOK_AGAIN: Duration = Duration::from_millis(200);

/// Simulates the jobs and puts their recordings into the cache, at most `side_by_side` at a time on `threads` threads
/// in all; without a number, one or two at a time, whichever a short measurement predicts to end sooner. Interrupted
/// jobs resume from their checkpoints.
///
/// # Errors
/// [`interrupt::Interrupted`], or the first job's error.
pub fn run(
    jobs: &[Job],
    cache: &Cache,
    threads: usize,
    side_by_side: Option<usize>,
    board: &Board,
) -> Result<()> {
    if jobs.is_empty() {
        return Ok(());
    }
    let known = side_by_side.map(|wanted| wanted.clamp(1, jobs.len()).min(threads.max(1)));
    let (field, quick): (Vec<&Job>, Vec<&Job>) =
        jobs.iter().partition(|job| job.spec.engine == Engine::Fdtd);
    let measured = (threads / known.unwrap_or(1)).max(1);
    let mut estimates = Vec::with_capacity(field.len());
    for job in &field {
        estimates.push(estimate(&job.scene, &job.spec, measured)?);
    }
    let mut order: Vec<(f64, &Job)> = estimates.iter().map(|e| e.seconds).zip(field).collect();
    let Concurrency { workers, slowdown } = match known {
        Some(workers) => Concurrency::of(workers),
        None if order.is_empty() => Concurrency::of(threads.clamp(1, 2)),
        None => concurrency::choose(&order, threads, board)?,
    };
    let share = (threads / workers).max(1);
    for ((_, job), mut estimate) in order.iter().zip(estimates) {
        estimate.seconds *= slowdown;
        board.say(format!(
            "simulate {}: {estimate} on {share} thread(s)",
            job.label
        ));
    }
    let seconds: f64 = order.iter().map(|(seconds, _)| seconds * slowdown).sum();
    if seconds > 0.0 {
        board.say(format!(
            "{} simulation(s), {workers} side by side: about {} in all; interrupt at any time, the same command \
            goes on",
            jobs.len(),
            duration(seconds / workers as f64)
        ));
    }
    order.extend(quick.into_iter().map(|job| (0.0, job)));
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    let total = order.len() as u64;
    let all = (total > 2).then(|| board.task("simulations", total));
    let ended = AtomicUsize::new(0);
    let queue: Mutex<VecDeque<&Job>> = Mutex::new(order.into_iter().map(|(_, job)| job).collect());
    let failures: Mutex<Vec<anyhow::Error>> = Mutex::default();
    let spare = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                let mine = AtomicUsize::new(share);
                let freed = || {
                    let more = spare.swap(0, Ordering::Relaxed);
                    mine.fetch_add(more, Ordering::Relaxed);
                    more
                };
                while let Some(job) = next(&queue, &failures) {
                    let options = RunOptions {
                        threads: mine.load(Ordering::Relaxed),
                        freed: Some(&freed),
                        ..RunOptions::default()
                    };
                    match leased(job, cache, options, board) {
                        Ok(true) => {}
                        Ok(false) => {
                            // Another worker is at it: behind all others, and looked at again.
                            std::thread::sleep(LOOK_AGAIN);
                            if let Ok(mut queue) = queue.lock() {
                                queue.push_back(job);
                            }
                            continue;
                        }
                        Err(error) => {
                            if let Ok(mut failures) = failures.lock() {
                                failures
                                    .push(error.context(format!("simulation of {}", job.label)));
                            }
                        }
                    }
                    if let Some(all) = &all {
                        all.set(ended.fetch_add(1, Ordering::Relaxed) as u64 + 1);
                    }
                }
                // A worker without a job leaves its threads to those that have one.
                spare.fetch_add(mine.into_inner(), Ordering::Relaxed);
            });
        }
    });
    let mut failures = failures
        .into_inner()
        .map_err(|_| anyhow!("a simulation panicked"))?;
    match failures.is_empty() {
        true => Ok(()),
        false => Err(failures.remove(0)),
    }
}

/// The next job, unless one failed or the user asked to stop.
fn next<'a>(
    queue: &Mutex<VecDeque<&'a Job>>,
    failures: &Mutex<Vec<anyhow::Error>>,
) -> Option<&'a Job> {
    if interrupt::requested() || !failures.lock().ok()?.is_empty() {
        return None;
    }
    queue.lock().ok()?.pop_front()
}

/// The sound of a job, which is not kept: to measure how long it takes.
///
/// # Errors
/// When the scene does not run.
pub fn sound(job: &Job) -> Result<Vec<f32>> {
    let task = Board::new().task(&job.label, 1);
    signal(&job.scene, &job.spec, &RunOptions::default(), &task)
}

/// Simulates one job into the cache under its lease; false while another worker has it.
fn leased(job: &Job, cache: &Cache, options: RunOptions<'_>, board: &Board) -> Result<bool> {
    let Asked::Held(lease) = cache.lease(&job.key)? else {
        // It may have ended since, or be dead soon.
        return Ok(cache.is_whole(&job.key));
    };
    // Another worker may have been quicker between our look into the cache and now.
    if !cache.is_whole(&job.key) {
        simulate(job, cache, options, board)?;
    }
    drop(lease);
    Ok(true)
}

/// Simulates one job into the cache.
fn simulate(job: &Job, cache: &Cache, options: RunOptions<'_>, board: &Board) -> Result<()> {
    interrupt::check()?;
    let scene = &job.scene;
    let steps = (job.length_s() / scene.grid.dt_s).ceil() as u64;
    let task = board.task(&job.label, steps);
    let checkpoint = Checkpoint {
        path: cache.checkpoint(&job.key),
        resume: true,
    };
    let started = Instant::now();
    let options = RunOptions {
        checkpoint: Some(&checkpoint),
        ..options
    };
    let signal = match signal(scene, &job.spec, &options, &task) {
        Err(error) if is_of_checkpoint(&error) => {
            board.say(format!("{error:#}; {} starts anew", job.label));
            remove(&checkpoint.path)?;
            signal(scene, &job.spec, &options, &task)?
        }
        signal => signal?,
    };
    let seconds = started.elapsed().as_secs_f64();
    let recording = recording(scene, &job.spec, signal, seconds)?;
    atomic::write_folder(&cache.recording(&job.key), |folder| {
        recording.write(folder)?;
        Manifest::of(folder)?.write(folder)
    })?;
    remove(&checkpoint.path)?;
    task.finish();
    // Image sources take seconds each, and a study has hundreds.
    if job.spec.engine == Engine::Fdtd {
        board.say(format!("simulated {} in {}", job.label, duration(seconds)));
    }
    Ok(())
}

/// Whether a simulation could not go on from its checkpoint.
fn is_of_checkpoint(error: &anyhow::Error) -> bool {
    let of_field = error.downcast_ref::<fdtd::Error>();
    matches!(of_field, Some(fdtd::Error::Checkpoint { .. }))
}

/// Removes a file that another process may have removed already.
fn remove(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(anyhow::Error::from(error).context(path.display().to_string()))
        }
        _ => Ok(()),
    }
}
