//! Speed of the field engines on a case with everything on: layers on four sides, slanted rigid walls, moving source and
//! receiver with eight-point spreading. Beside it: the machine's [`peaks`], a field that starts, where [`subnormal`] numbers are, and the steps of
//! the [`localizer`].

pub mod localizer;
pub mod peaks;
mod stopwatch;
pub mod subnormal;

use std::time::Instant;

use anyhow::Result;
use fdtd::field::{
    FastField, Field, FieldSetup, FieldState, Injection, ReferenceField, StepForcing,
};
use fdtd::grid::{Grid, Medium};
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::walls::SolidMask;
use serde::Serialize;

use crate::data::peaks::{self as measured, Peaks};
use crate::run::interrupt;

/// Cells of the absorbing layers.
const LAYER_CELLS: usize = 20;
/// Fewest cells along a side: the layers (in whole vectors) and the spreading between them.
pub const SMALLEST: usize = 64;
/// Steps whose forcing is made beforehand and repeated.
const FORCING: usize = 1024;
/// Time that a row takes when no steps are given, in s.
const ROW_S: f64 = 1.0;
/// Least time of a piece of a row, in s. The fastest piece counts: on a shared machine the others tell what else ran.
const PIECE_S: f64 = 0.2;

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
    /// Speed of the fastest piece of a fifth of a second, in 10^9 cells per second.
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
        Scheme::M13 | Scheme::O13 => 15.0,
        Scheme::D25 => 27.0,
    }
}

/// The setup of the case.
fn setup(nx: usize, ny: usize, scheme: Scheme) -> FieldSetup {
    let grid = Grid {
        nx,
        ny,
        dx_m: 0.005,
        dt_s: 1.0 / 120_000.0,
    };
    let medium = Medium {
        c_mps: 340.0,
        rho_kgpm3: 1.293,
    };
    let mut cells = vec![false; nx * ny];
    for k in 0..nx / 2 {
        for t in 0..4 {
            let walls = [
                (ny / 5 + k / 8 + t, nx / 4 + k),
                (ny / 4 + k * ny / nx, nx / 5 + t + k / 10),
            ];
            for (iy, ix) in walls {
                if iy < ny && ix < nx {
                    cells[iy * nx + ix] = true;
                }
            }
        }
    }
    let mask = SolidMask { nx, ny, cells };
    FieldSetup::new(&grid, &medium, scheme, LAYER_CELLS, &mask.into())
}

/// What moves: source and receiver drift along x. No step is quiet, as in a long drive.
fn forcing(nx: usize, ny: usize) -> Vec<StepForcing> {
    let at = |n: usize| {
        let stencil =
            Spread::Kaiser12.stencil([0.5 * nx as f64 + 1e-3 * n as f64, 0.45 * ny as f64]);
        let injection = Injection {
            stencil,
            amplitude: (0.5 * n as f32).sin(),
        };
        StepForcing {
            quiet: false,
            injections: [injection; 2],
            receiver: stencil,
        }
    };
    (0..FORCING).map(at).collect()
}

/// A field of noise around 1: in full swing, as it is in nearly all of a drive.
fn noise(state: FieldState) -> FieldState {
    let mut seed = 1_u32;
    let pressure: Vec<f32> = (0..state.pressure.len())
        .map(|_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / 8_388_608.0 - 1.0
        })
        .collect();
    FieldState {
        previous: pressure.clone(),
        pressure,
        ..state
    }
}

/// Steps taken, and the rate of the fastest piece in Gcell/s.
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
    let mut piece = (done, start);
    loop {
        interrupt::check()?;
        let from = done % FORCING;
        let left = steps.map_or(block, |steps| steps - done);
        let count = block.min(left).min(FORCING - from);
        field.advance(&forcing[from..from + count], &mut received);
        received.clear();
        done += count;
        let seconds = piece.1.elapsed().as_secs_f64();
        let ended = steps.map_or(start.elapsed().as_secs_f64() >= ROW_S, |steps| {
            done >= steps
        });
        // A short rest at the end says little, unless it is all there is.
        if seconds >= PIECE_S || (ended && best == 0.0) {
            best = best.max((cells * (done - piece.0)) as f64 / seconds / 1e9);
            piece = (done, Instant::now());
        }
        if ended {
            return Ok((done, best));
        }
    }
}

/// Measures all schemes and engines on one grid beside the `peaks` of as many threads (NaN where they were not measured);
/// `told` hears each row as it is done.
///
/// # Errors
/// [`interrupt::Interrupted`] on request.
///
/// # Panics
/// When a side has fewer than [`SMALLEST`] cells, or the threads cannot be started.
pub fn measure(
    nx: usize,
    ny: usize,
    steps: Option<usize>,
    threads: &[usize],
    peaks: &[Peaks],
    mut told: impl FnMut(&Row),
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
            let peak_gflops = measured::of(peaks, count).map_or(f64::NAN, |peak| peak.fma_gflops);
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
            told(&row);
            rows.push(row);
        }
    }
    Ok(rows)
}
