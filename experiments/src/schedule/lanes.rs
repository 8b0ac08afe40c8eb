//! One simulation after the other on all threads, or two side by side on half of them each? Which is faster depends on how
//! the field divides among threads and on what the cores share, so it is measured before a run.

use std::sync::Barrier;

use anyhow::{Result, anyhow};
use fdtd::scene::Scene;

use super::{Job, MEASURING_S, steps_per_second};
use crate::progress::{Board, duration};
use crate::simulate::{self, Engine};

/// Steps per second of one simulation in either way.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Rates {
    /// Alone on all threads.
    alone: f64,
    /// Beside another one, each on half of the threads.
    beside: f64,
}

/// How many simulations to run side by side, 1 or 2; tells why.
///
/// The largest job is run for a moment in both ways. The others are taken to need as much time for their work as it does:
/// steps of a free field are those of small domains.
///
/// # Errors
/// When the field refuses the scene.
pub(super) fn choose(scene: &Scene, jobs: &[Job], threads: usize, board: &Board) -> Result<usize> {
    let mut field: Vec<(&Job, u64, u64)> = Vec::new();
    for job in jobs.iter().filter(|job| job.take.engine == Engine::Fdtd) {
        let simulation = simulate::prepare(scene, &job.take, 1)?;
        field.push((job, simulation.work(), simulation.steps_total()));
    }
    let largest = field.iter().max_by_key(|(_, work, _)| *work);
    let Some(&(largest, work, steps)) = largest.filter(|_| field.len() > 1 && threads > 1) else {
        return Ok(threads.min(2));
    };
    let rates = measure(scene, largest, threads)?;
    // All work in steps of the largest job.
    let per_step = work as f64 / steps as f64;
    let steps: Vec<f64> = field
        .iter()
        .map(|(_, work, _)| *work as f64 / per_step)
        .collect();
    let (lanes, seconds) = faster(&steps, rates);
    board.say(format!(
        "plan: two simulations side by side on {} thread(s) each would take {}, one after the other on {threads} {} (measured, {:.0} + {:.0} against {:.0} steps/s): {}",
        threads / 2,
        duration(seconds[1]),
        duration(seconds[0]),
        rates.beside,
        rates.beside,
        rates.alone,
        if lanes == 2 { "side by side" } else { "one after the other" },
    ));
    Ok(lanes)
}

/// The number of lanes that ends sooner, and the seconds that one and two of them take.
fn faster(steps: &[f64], rates: Rates) -> (usize, [f64; 2]) {
    let seconds = [
        steps.iter().sum::<f64>() / rates.alone.max(1e-9),
        makespan(steps, 2) / rates.beside.max(1e-9),
    ];
    (if seconds[1] < seconds[0] { 2 } else { 1 }, seconds)
}

/// Length of the fullest of some lanes when each takes the longest job left as soon as it is free.
fn makespan(lengths: &[f64], lanes: usize) -> f64 {
    let mut sorted = lengths.to_vec();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let mut ends = vec![0.0_f64; lanes.max(1)];
    for length in sorted {
        ends.sort_by(f64::total_cmp);
        ends[0] += length;
    }
    ends.into_iter().fold(0.0, f64::max)
}

/// Runs a job for a moment alone on all threads, then two of it at the same time on half of the threads each.
fn measure(scene: &Scene, job: &Job, threads: usize) -> Result<Rates> {
    let alone = steps_per_second(
        &mut simulate::prepare(scene, &job.take, threads)?,
        MEASURING_S,
    )?;
    let mut pair = [
        simulate::prepare(scene, &job.take, threads / 2)?,
        simulate::prepare(scene, &job.take, threads / 2)?,
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
    fn lanes_take_the_longest_job_left() {
        assert_eq!(makespan(&[3.0, 5.0, 4.0], 1), 12.0);
        assert_eq!(makespan(&[3.0, 5.0, 4.0], 2), 7.0);
        assert_eq!(makespan(&[], 2), 0.0);
    }

    #[test]
    fn side_by_side_wins_when_two_shares_are_faster_and_the_jobs_divide_evenly() {
        let rates = |alone, beside| Rates { alone, beside };
        assert_eq!(faster(&[100.0, 100.0], rates(10.0, 6.0)).0, 2);
        assert_eq!(faster(&[100.0, 100.0], rates(10.0, 4.0)).0, 1);
        // A short job leaves its lane idle while the long one runs on half of the threads.
        assert_eq!(faster(&[100.0, 10.0], rates(10.0, 6.0)).0, 1);
        assert_eq!(faster(&[60.0, 60.0], rates(10.0, 6.0)), (2, [12.0, 10.0]));
    }
}
