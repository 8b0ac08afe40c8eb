//! Speed of the field engines on one grid beside the peaks of the machine.

use std::time::Instant;

use anyhow::Result;
use fdtd::field::{FastField, Field, ReferenceField, StepForcing};
use fdtd::scheme::Scheme;
use serde::Serialize;

use super::case::{FORCING, forcing, noise, setup};
use crate::data::peaks::{self, Peaks};
use crate::run::interrupt;

/// Duration of a row when no steps are given, seconds.
const ROW_S: f64 = 1.0;
/// Least duration of a timed interval of a row, seconds. The fastest interval counts: on a shared machine the others
/// include the load of other programs.
const INTERVAL_S: f64 = 0.2;

/// One line of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// `reference` or `fast`.
    pub engine: &'static str,
    /// `slf`, `m13` or `d25`.
    pub scheme: &'static str,
    /// Cells along x.
    pub nx: usize,
    /// Cells along y.
    pub ny: usize,
    /// Threads of the engine.
    pub threads: usize,
    /// Steps timed.
    pub steps: usize,
    /// Speed of the fastest interval of a fifth of a second, in 10^9 cells per second.
    pub gcells_per_s: f64,
    /// Floating-point operations that the scheme needs for a cell far from walls and layers.
    pub flops_per_cell: f64,
    /// Bytes that a cell moves to and from memory where nothing stays in the caches: two pressures read, one written.
    pub bytes_per_cell: f64,
    /// Arithmetic over the measured peak of as many threads.
    pub peak_fraction: f64,
    /// Speed per thread over that of the reference in the same run.
    pub ratio_per_thread: f64,
}

/// Floating-point operations per cell of a scheme's plain step, a fused multiply-add being two. Sums that neighbouring
/// cells share are counted once.
fn flops(scheme: Scheme) -> f64 {
    match scheme {
        Scheme::Slf => 7.0,
        Scheme::Iwb | Scheme::M13 | Scheme::O13 => 15.0,
        Scheme::D25 => 27.0,
    }
}

/// Steps taken, and the rate of the fastest interval in Gcell/s.
fn time(
    field: &mut dyn Field,
    cells: usize,
    forcing: &[StepForcing],
    steps: Option<usize>,
) -> Result<(usize, f64)> {
    let block = field.preferred_block().clamp(1, FORCING);
    let mut received = Vec::new();
    field.set_state(&noise(field.state()));
    field.advance(&forcing[..block.min(steps.unwrap_or(block))], &mut received);
    let start = Instant::now();
    let (mut done, mut best) = (0, 0.0_f64);
    let mut interval = (done, start);
    loop {
        interrupt::check()?;
        let from = done % FORCING;
        let left = steps.map_or(block, |steps| steps - done);
        let count = block.min(left).min(FORCING - from);
        field.advance(&forcing[from..from + count], &mut received);
        received.clear();
        done += count;
        let seconds = interval.1.elapsed().as_secs_f64();
        let ended = steps.map_or(start.elapsed().as_secs_f64() >= ROW_S, |steps| {
            done >= steps
        });
        // A short interval at the end is inaccurate; it counts only when there is no other.
        if seconds >= INTERVAL_S || (ended && best == 0.0) {
            best = best.max((cells * (done - interval.0)) as f64 / seconds / 1e9);
            interval = (done, Instant::now());
        }
        if ended {
            return Ok((done, best));
        }
    }
}

/// Measures all schemes and engines on one grid beside the `peaks` of as many threads (NaN where they were not
/// measured); `report` gets each row as soon as it is measured.
///
/// # Errors
/// [`interrupt::Interrupted`] on request.
///
/// # Panics
/// When a side has fewer than [`super::SMALLEST`] cells, or the threads cannot be started.
pub fn measure(
    nx: usize,
    ny: usize,
    steps: Option<usize>,
    threads: &[usize],
    peaks: &[Peaks],
    mut report: impl FnMut(&Row),
) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for scheme in Scheme::ALL {
        let forcing = forcing(nx, ny);
        let setup = setup(nx, ny, scheme);
        let mut base = f64::NAN;
        for threads in std::iter::once(None).chain(threads.iter().copied().map(Some)) {
            let mut field: Box<dyn Field> = match threads {
                None => Box::new(ReferenceField::new(setup.clone())),
                Some(threads) => Box::new(FastField::new(setup.clone(), threads)),
            };
            let (steps, rate) = time(&mut *field, nx * ny, &forcing, steps)?;
            let count = threads.unwrap_or(1);
            if threads.is_none() {
                base = rate;
            }
            let peak_gflops = peaks::of(peaks, count).map_or(f64::NAN, |peak| peak.fma_gflops);
            let row = Row {
                engine: if threads.is_none() {
                    "reference"
                } else {
                    "fast"
                },
                scheme: scheme.name(),
                nx,
                ny,
                threads: count,
                steps,
                gcells_per_s: rate,
                flops_per_cell: flops(scheme),
                bytes_per_cell: 12.0,
                peak_fraction: flops(scheme) * rate / peak_gflops,
                ratio_per_thread: rate / count as f64 / base,
            };
            report(&row);
            rows.push(row);
        }
    }
    Ok(rows)
}
