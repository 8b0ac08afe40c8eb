//! Several simulations side by side: each on its share of the threads, the longest first, the last on those of lanes that are done, all
//! resumable.

mod lanes;

use std::collections::VecDeque;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use anyhow::{Context, Result, anyhow};
use fdtd::scene::Scene;
use fdtd::simulation::{Flow, Simulation};

use crate::atomic;
use crate::cache::Cache;
use crate::interrupt;
use crate::progress::{Board, duration};
use crate::simulate::{self, Checkpoint, Engine, Running, Take};

/// Wall-clock time of the speed measurement behind an estimate, seconds.
const MEASURING_S: f64 = 0.4;

/// A recording that has to be simulated.
#[derive(Debug, Clone)]
pub struct Job {
    /// Name for progress and provenance, e.g. `mapping m13`.
    pub label: String,
    /// Key in the cache.
    pub key: String,
    /// Where it is recorded.
    pub scene: Arc<Scene>,
    /// What is recorded.
    pub take: Take,
}

/// Size and expected duration of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// Cells of the grid.
    pub cells: usize,
    /// Steps in time.
    pub steps: u64,
    /// Memory, bytes.
    pub memory_bytes: u64,
    /// Expected duration, seconds.
    pub seconds: f64,
}

impl std::fmt::Display for Estimate {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            formatter,
            "{} cells, {} steps, {:.0} MiB, about {}",
            self.cells,
            self.steps,
            self.memory_bytes as f64 / (1024.0 * 1024.0),
            duration(self.seconds)
        )
    }
}

/// Steps per second that a simulation reaches within about `seconds`. It only serves this measurement: its small numbers are set to zero, as they are
/// gone soon after the start of a long drive.
///
/// # Errors
/// When the field turns non-finite.
pub fn steps_per_second(simulation: &mut Simulation, seconds: f64) -> Result<f64> {
    // The first call comes after the field is in the caches.
    let mut first: Option<(Instant, u64)> = None;
    let mut rate = 0.0;
    simulation.flush_subnormals();
    simulation.run(&mut |progress, _| {
        let (since, from) = *first.get_or_insert((Instant::now(), progress.step));
        let elapsed = since.elapsed().as_secs_f64();
        if progress.step > from {
            rate = (progress.step - from) as f64 / elapsed.max(1e-9);
        }
        if elapsed < seconds && !interrupt::requested() {
            Flow::Continue
        } else {
            Flow::Stop
        }
    })?;
    Ok(rate)
}

/// Size of a take and its duration on `threads` threads, measured by running it for a moment.
///
/// # Errors
/// When the field refuses the scene.
pub fn estimate(scene: &Scene, take: &Take, threads: usize) -> Result<Estimate> {
    let mut simulation = simulate::prepare(scene, take, threads)?;
    let steps = simulation.steps_total();
    let rate = steps_per_second(&mut simulation, MEASURING_S)?;
    Ok(Estimate {
        cells: simulation.cells(),
        steps,
        memory_bytes: simulation.memory_bytes(),
        seconds: if rate > 0.0 { steps as f64 / rate } else { 0.0 },
    })
}

/// Simulates the jobs and puts their recordings into the cache, at most `side_by_side` at a time on `threads` threads in all;
/// without a number, one or two at a time, whichever a short measurement says ends sooner.
/// Jobs that were interrupted earlier go on where they stopped.
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
        jobs.iter().partition(|job| job.take.engine == Engine::Fdtd);
    let measured = (threads / known.unwrap_or(1)).max(1);
    let mut estimates = Vec::with_capacity(field.len());
    for job in &field {
        estimates.push(estimate(&job.scene, &job.take, measured)?);
    }
    let mut order: Vec<(f64, &Job)> = estimates.iter().map(|e| e.seconds).zip(field).collect();
    let (lanes, slower) = match known {
        Some(lanes) => (lanes, 1.0),
        None if order.is_empty() => (threads.clamp(1, 2), 1.0),
        None => {
            let lanes = lanes::choose(&order, threads, board)?;
            (lanes.count, lanes.slower)
        }
    };
    let share = (threads / lanes).max(1);
    for ((_, job), mut estimate) in order.iter().zip(estimates) {
        estimate.seconds *= slower;
        board.say(format!(
            "simulate {}: {estimate} on {share} thread(s)",
            job.label
        ));
    }
    let seconds: f64 = order.iter().map(|(seconds, _)| seconds * slower).sum();
    if seconds > 0.0 {
        board.say(format!(
            "{} simulation(s), {lanes} side by side: about {} in all; interrupt at any time, the same command goes on",
            jobs.len(),
            duration(seconds / lanes as f64)
        ));
    }
    order.extend(quick.into_iter().map(|job| (0.0, job)));
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    let queue: Mutex<VecDeque<&Job>> = Mutex::new(order.into_iter().map(|(_, job)| job).collect());
    let failures: Mutex<Vec<anyhow::Error>> = Mutex::default();
    let spare = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..lanes {
            scope.spawn(|| {
                let mine = AtomicUsize::new(share);
                let freed = || {
                    let more = spare.swap(0, Ordering::Relaxed);
                    mine.fetch_add(more, Ordering::Relaxed);
                    more
                };
                while let Some(job) = next(&queue, &failures) {
                    let running = Running {
                        threads: mine.load(Ordering::Relaxed),
                        freed: Some(&freed),
                        ..Running::default()
                    };
                    if let Err(error) = one(job, cache, running, board)
                        && let Ok(mut failures) = failures.lock()
                    {
                        failures.push(error.context(format!("simulation of {}", job.label)));
                    }
                }
                // A lane without work leaves its threads to one that has some.
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

/// Length of a job's drive.
fn length_s(job: &Job) -> f64 {
    job.scene
        .path(&job.take.path)
        .map_or(0.0, |path| path.duration_s())
}

/// Simulates one job into the cache.
fn one(job: &Job, cache: &Cache, running: Running<'_>, board: &Board) -> Result<()> {
    interrupt::check()?;
    let scene = &job.scene;
    let steps = (length_s(job) / scene.grid.dt_s).ceil() as u64;
    let task = board.task(&job.label, steps);
    let checkpoint = Checkpoint {
        path: cache.checkpoint(&job.key),
        resume: true,
    };
    let started = Instant::now();
    let running = Running {
        checkpoint: Some(&checkpoint),
        ..running
    };
    let signal = simulate::signal(scene, &job.take, &running, &task)?;
    let seconds = started.elapsed().as_secs_f64();
    let recording = simulate::recording(scene, &job.take, signal, seconds)?;
    atomic::write_folder(&cache.recording(&job.key), |folder| {
        Ok(recording.write(folder)?)
    })?;
    if checkpoint.path.exists() {
        std::fs::remove_file(&checkpoint.path)
            .with_context(|| checkpoint.path.display().to_string())?;
    }
    task.finish();
    board.say(format!("simulated {} in {}", job.label, duration(seconds)));
    Ok(())
}
