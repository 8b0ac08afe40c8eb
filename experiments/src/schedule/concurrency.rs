//! Concurrency of simulations: one after the other on all threads, or two side by side on half of them each. Which is
//! faster depends on how the field divides among threads and on the caches that cores share, so it is measured before a
//! run.

use std::sync::Barrier;

use anyhow::{Result, anyhow};

use super::estimate::{MEASURING_S, steps_per_second};
use super::job::Job;
use crate::recordings::simulate::prepare;
use crate::run::progress::{Board, duration};

/// Steps per second of one simulation in either way.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Rates {
    /// Alone on all threads.
    alone: f64,
    /// Beside another one, each on half of the threads.
    beside: f64,
}

/// How the simulations of a run share the threads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Concurrency {
    /// Number that run side by side.
    pub(super) workers: usize,
    /// Duration of one on its share of the threads over that alone on all.
    pub(super) slowdown: f64,
}

impl Concurrency {
    /// A number of workers that is not compared with others: durations count as measured.
    pub(super) fn of(workers: usize) -> Self {
        Self {
            workers,
            slowdown: 1.0,
        }
    }
}

/// One simulation after the other, or two side by side; the reason is shown on the board. Each job stands beside its
/// duration in seconds alone on all threads. The slowdown beside another is measured on the longest job and taken to
/// hold for all.
///
/// # Errors
/// When the field refuses a scene.
pub(super) fn choose(jobs: &[(f64, &Job)], threads: usize, board: &Board) -> Result<Concurrency> {
    let longest = jobs.iter().max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, longest)) = longest.filter(|_| jobs.len() > 1 && threads > 1) else {
        return Ok(Concurrency::of(1));
    };
    let rates = measure(longest, threads)?;
    let seconds: Vec<f64> = jobs.iter().map(|(seconds, _)| *seconds).collect();
    let (chosen, ends) = faster(&seconds, rates);
    board.say(format!(
        "plan: two simulations side by side on {} thread(s) each would take {}, one after the other on \
        {threads} {} (measured, {:.0} + {:.0} against {:.0} steps/s): {}",
        threads / 2,
        duration(ends[1]),
        duration(ends[0]),
        rates.beside,
        rates.beside,
        rates.alone,
        if chosen.workers == 2 { "side by side" } else { "one after the other" },
    ));
    Ok(chosen)
}

/// The concurrency that ends sooner, and the ends of one worker and of two, for simulations that take these `seconds`
/// alone.
fn faster(seconds: &[f64], rates: Rates) -> (Concurrency, [f64; 2]) {
    let slowdown = rates.alone / rates.beside.max(1e-9);
    // The worker that is left alone goes on with all threads.
    let [first, last] = two_ends(seconds);
    let ends = [seconds.iter().sum(), first * slowdown + (last - first)];
    let chosen = match ends[1] < ends[0] {
        true => Concurrency {
            workers: 2,
            slowdown,
        },
        false => Concurrency::of(1),
    };
    (chosen, ends)
}

/// Ends of two workers, each taking the longest job left as soon as it is free; the sooner first.
fn two_ends(lengths: &[f64]) -> [f64; 2] {
    let mut sorted = lengths.to_vec();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let mut ends = [0.0_f64; 2];
    for length in sorted {
        ends[0] += length;
        ends.sort_by(f64::total_cmp);
    }
    ends
}

/// Runs a job for a moment alone on all threads, then two of it at the same time on half of the threads each.
fn measure(job: &Job, threads: usize) -> Result<Rates> {
    let alone = steps_per_second(&mut prepare(&job.scene, &job.spec, threads)?, MEASURING_S)?;
    let mut pair = [
        prepare(&job.scene, &job.spec, threads / 2)?,
        prepare(&job.scene, &job.spec, threads / 2)?,
    ];
    let start = Barrier::new(pair.len());
    let rates = std::thread::scope(|scope| {
        let runs = pair.each_mut().map(|simulation| {
            scope.spawn(|| {
                start.wait();
                steps_per_second(simulation, MEASURING_S)
            })
        });
        runs.map(|run| {
            run.join()
                .unwrap_or_else(|_| Err(anyhow!("a simulation panicked")))
        })
    });
    let [first, second] = rates;
    Ok(Rates {
        alone,
        beside: 0.5 * (first? + second?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn workers_take_the_longest_job_left() {
        assert_eq!(two_ends(&[3.0, 5.0, 4.0]), [5.0, 7.0]);
        assert_eq!(two_ends(&[3.0]), [0.0, 3.0]);
        assert_eq!(two_ends(&[]), [0.0, 0.0]);
    }

    #[test]
    fn side_by_side_wins_when_two_shares_are_faster_and_the_jobs_divide_evenly() {
        let ends = |seconds: &[f64], alone, beside| faster(seconds, Rates { alone, beside });
        assert_eq!(ends(&[10.0, 10.0], 10.0, 6.0).0.workers, 2);
        assert_eq!(ends(&[10.0, 10.0], 10.0, 4.0).0.workers, 1);
        // A short job leaves its threads to the long one.
        assert_eq!(ends(&[10.0, 1.0], 9.0, 6.0).1, [11.0, 10.5]);
        assert_eq!(ends(&[6.0, 6.0], 9.0, 6.0).1, [12.0, 9.0]);
    }
}
