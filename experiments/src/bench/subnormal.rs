//! Speed while the first wave front crosses a silent field, beside that of a field of normal numbers. Ahead of the
//! front the field falls off through all magnitudes, and some processors take a hundred cycles for each operation on a
//! subnormal number; flushing steps flush them ([`fdtd::field::flushes_subnormals`]). The third measurement leaves the
//! flushing steps out.

use anyhow::Result;
use fdtd::field::{FastField, Field, StepForcing, flushes_subnormals};
use fdtd::scheme::Scheme;
use serde::Serialize;

use super::case::{FORCING, forcing, noise, setup};
use super::stopwatch::Stopwatch;
use crate::run::interrupt;

/// Rounds of all measurements in turn; their sum counts.
const ROUNDS: usize = 5;
/// Cell updates of a timed interval.
const INTERVAL_CELLS: usize = 200_000_000;

/// The fast engine on one thread, in time that the thread was running.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The scheme.
    pub scheme: &'static str,
    /// Cells along x.
    pub nx: usize,
    /// Cells along y.
    pub ny: usize,
    /// Steps of each timed interval.
    pub steps: usize,
    /// Speed on numbers around 1, 10^9 cells per second.
    pub normal_gcells_per_s: f64,
    /// Speed in the first steps of a source in silence.
    pub start_gcells_per_s: f64,
    /// The same without flushing steps.
    pub loud_start_gcells_per_s: f64,
    /// Time of the start over that on numbers around 1.
    pub time_ratio: f64,
    /// The same without flushing steps: the cost of subnormal numbers on this machine.
    pub loud_time_ratio: f64,
    /// Share of cells that are subnormal after the start.
    pub subnormal_share: f64,
    /// The same without flushing steps.
    pub loud_subnormal_share: f64,
}

fn subnormal_share(field: &FastField) -> f64 {
    let pressure = field.state().pressure;
    let count = pressure.iter().filter(|p| p.is_subnormal()).count();
    count as f64 / pressure.len() as f64
}

/// Measures all schemes on one grid.
///
/// # Errors
/// [`interrupt::Interrupted`] on request.
///
/// # Panics
/// When a side has fewer than [`super::SMALLEST`] cells.
pub fn measure(nx: usize, ny: usize, steps: Option<usize>) -> Result<Vec<Row>> {
    let steps = steps.unwrap_or((INTERVAL_CELLS / (nx * ny)).clamp(8, FORCING));
    let mut rows = Vec::new();
    for scheme in Scheme::ALL {
        let loud: Vec<StepForcing> = forcing(nx, ny).into_iter().cycle().take(steps).collect();
        let mut flushing = loud.clone();
        for (n, step) in flushing.iter_mut().enumerate() {
            step.flush = flushes_subnormals(scheme, n as u64);
        }
        let mut field = FastField::new(setup(nx, ny, scheme), 1);
        let silent = field.state();
        let full = noise(silent.clone());
        let cases = [(&full, &flushing), (&silent, &flushing), (&silent, &loud)];
        let mut seconds = [0.0_f64; 3];
        let mut shares = [0.0_f64; 3];
        let mut received = Vec::new();
        for _ in 0..ROUNDS {
            for (case, (state, forcing)) in cases.into_iter().enumerate() {
                interrupt::check()?;
                field.set_state(state);
                received.clear();
                let stopwatch = Stopwatch::start();
                field.advance(forcing, &mut received);
                seconds[case] += stopwatch.seconds();
                shares[case] = subnormal_share(&field);
            }
        }
        let [normal, start, loud_start] = seconds.map(|seconds| seconds.max(1e-9) / ROUNDS as f64);
        let rate = |seconds: f64| (nx * ny * steps) as f64 / seconds / 1e9;
        rows.push(Row {
            scheme: scheme.name(),
            nx,
            ny,
            steps,
            normal_gcells_per_s: rate(normal),
            start_gcells_per_s: rate(start),
            loud_start_gcells_per_s: rate(loud_start),
            time_ratio: start / normal,
            loud_time_ratio: loud_start / normal,
            subnormal_share: shares[1],
            loud_subnormal_share: shares[2],
        });
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test may panic")]

    use super::*;

    #[test]
    fn there_are_subnormal_numbers_without_quiet_steps_and_none_with_them() {
        for row in measure(160, 150, Some(90)).unwrap() {
            let [flushing, loud] = [row.subnormal_share, row.loud_subnormal_share];
            assert!(loud > 0.002, "{}: {loud}", row.scheme);
            assert!(
                flushing < 0.02 * loud,
                "{}: {flushing} and {loud}",
                row.scheme
            );
        }
    }
}
