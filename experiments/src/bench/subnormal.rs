//! Speed on numbers below the normal range of `f32` beside that on normal ones. Some processors take a hundred cycles for
//! each operation on a subnormal number; ahead of the first wave front every run has a rim of them.

use anyhow::Result;
use fdtd::field::{FastField, Field, FieldState, Injection, StepForcing};
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use serde::Serialize;

use super::stopwatch::Stopwatch;
use crate::interrupt;

/// Amplitude of the subnormal field, Pa: 7000 times the smallest number, a thousandth of the smallest normal one.
const SUBNORMAL: f32 = 1e-41;
/// Rounds of both ranges in turn; their sum counts.
const ROUNDS: usize = 7;
/// Cells that a timed piece updates.
const PIECE_CELLS: usize = 200_000_000;

/// The fast engine on one thread with normal and with subnormal numbers, in time that the thread was running.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The scheme.
    pub scheme: &'static str,
    /// Cells along x.
    pub nx: usize,
    /// Cells along y.
    pub ny: usize,
    /// Steps of each timed piece.
    pub steps: usize,
    /// Speed on numbers around 1, 10^9 cells per second.
    pub normal_gcells_per_s: f64,
    /// Speed on subnormal numbers.
    pub subnormal_gcells_per_s: f64,
    /// Time with subnormal numbers over that with normal ones: 1 when they cost nothing.
    pub time_ratio: f64,
    /// Share of cells that are subnormal after the timed steps; the rest is zero, in walls and where the layer took it.
    pub subnormal_share: f64,
}

/// A field of noise around `amplitude`, the same for every amplitude.
fn noise(state: &FieldState, amplitude: f32) -> FieldState {
    let mut seed = 1_u32;
    let pressure: Vec<f32> = (0..state.pressure.len())
        .map(|_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            amplitude * ((seed >> 8) as f32 / 8_388_608.0 - 1.0)
        })
        .collect();
    FieldState {
        previous: pressure.clone(),
        pressure,
        ..state.clone()
    }
}

/// Steps in which the source adds nothing.
fn silence(nx: usize, ny: usize, steps: usize) -> Vec<StepForcing> {
    let stencil = Spread::Kaiser8.stencil([0.5 * nx as f64, 0.5 * ny as f64]);
    let injection = Injection {
        stencil,
        amplitude: 0.0,
    };
    let step = StepForcing {
        injections: [injection; 2],
        receiver: stencil,
    };
    vec![step; steps]
}

/// Measures all schemes on one grid.
///
/// # Errors
/// [`interrupt::Interrupted`] on request.
///
/// # Panics
/// When a side has fewer than [`super::SMALLEST`] cells.
pub fn measure(nx: usize, ny: usize, steps: Option<usize>) -> Result<Vec<Row>> {
    let steps = steps.unwrap_or((PIECE_CELLS / (nx * ny)).clamp(8, 4096));
    let forcing = silence(nx, ny, steps);
    let mut rows = Vec::new();
    for scheme in Scheme::ALL {
        let mut field = FastField::new(super::setup(nx, ny, scheme), 1);
        let silent = field.state();
        let states = [1.0, SUBNORMAL].map(|amplitude| noise(&silent, amplitude));
        let mut seconds = [0.0_f64; 2];
        let mut received = Vec::new();
        for _ in 0..ROUNDS {
            for (state, seconds) in states.iter().zip(&mut seconds) {
                interrupt::check()?;
                field.set_state(state);
                received.clear();
                let stopwatch = Stopwatch::start();
                field.advance(&forcing, &mut received);
                *seconds += stopwatch.seconds();
            }
        }
        let [normal, subnormal] = seconds.map(|seconds| seconds.max(1e-9) / ROUNDS as f64);
        let left = field.state().pressure;
        let rate = |seconds: f64| (nx * ny * steps) as f64 / seconds / 1e9;
        rows.push(Row {
            scheme: scheme.name(),
            nx,
            ny,
            steps,
            normal_gcells_per_s: rate(normal),
            subnormal_gcells_per_s: rate(subnormal),
            time_ratio: subnormal / normal,
            subnormal_share: left.iter().filter(|p| p.is_subnormal()).count() as f64
                / left.len() as f64,
        });
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test may panic")]

    use super::*;

    #[test]
    fn the_field_stays_subnormal_while_it_is_timed() {
        for row in measure(160, 150, Some(64)).unwrap() {
            assert!(
                row.subnormal_share > 0.4,
                "{}: {}",
                row.scheme,
                row.subnormal_share
            );
        }
    }
}
