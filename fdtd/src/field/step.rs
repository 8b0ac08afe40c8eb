//! One step of a field as both engines take it: its forcing, its state, and the rules that they share.

use crate::number::Real;
use crate::scheme::Scheme;
use crate::spread::Stencil;

/// A source contribution to one step: `amplitude * wx[i] * wy[j]` is added to the new pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Injection {
    /// Where.
    pub stencil: Stencil,
    /// Its amplitude in Pa.
    pub amplitude: f32,
}

/// Pressure that a flushing step takes for zero, in Pa: 400 dB below one.
pub const FLUSH_BELOW_PA: f32 = 1e-20;

/// Whether step `step` of a run sets small numbers to zero. Two steps in a row do, for a step takes two levels and sets
/// only the newest to zero; then none until the front, which runs ahead with the stencil's outermost weights (0.3,
/// -0.02, 0.004 on the papers' grid), or the layers' memory, which keeps a tenth from step to step, comes near to
/// 1e-38, where the normal range of `f32` ends.
pub fn flushes_subnormals(scheme: Scheme, step: u64) -> bool {
    let period = match scheme {
        Scheme::Slf => 16,
        Scheme::Iwb | Scheme::M13 | Scheme::O13 => 8,
        Scheme::D25 => 6,
    };
    step % period < 2
}

/// Input and output of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepForcing {
    /// Whether the step sets what is below [`FLUSH_BELOW_PA`] to zero.
    pub flush: bool,
    /// Added to the new pressure, in this order.
    pub injections: [Injection; 2],
    /// Where the new pressure is read.
    pub receiver: Stencil,
}

/// State of a field in plain order, the same for both engines, as in a checkpoint.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FieldState {
    /// Pressure now, `[iy, ix]`.
    pub pressure: Vec<f32>,
    /// Pressure one step ago, `[iy, ix]`.
    pub previous: Vec<f32>,
    /// Memory of the layers along x: `[iy, 6, width]` (low side: lower face, upper face, cell; then high side).
    pub layer_x: Vec<f32>,
    /// Memory of the layers along y: `[row of layer, 3, ix]`, rows of the low side first.
    pub layer_y: Vec<f32>,
    /// Velocity times `rho c` into surfaces that are not rigid, half a step before `pressure`, in Pa: one for each
    /// surface and row of the grid that it takes its flow from. With branches velocity and spring of each of them, see
    /// [`crate::boundary::Branches`].
    pub surfaces: Vec<f32>,
}

/// A field that can be advanced.
pub trait Field: Send {
    /// Takes one step per entry of `steps` and appends what the receiver reads after each of them, in Pa.
    fn advance(&mut self, steps: &[StepForcing], received: &mut Vec<f32>);

    /// Adds a contribution to the newest pressure, as the injections of a step: for sources beyond a step's own. Solid
    /// cells take nothing.
    fn add(&mut self, injection: &Injection);

    /// What a receiver reads of the newest pressure, in Pa.
    fn read(&self, receiver: &Stencil) -> f32;

    /// How many steps per call of [`Field::advance`] suit the engine.
    fn preferred_block(&self) -> usize;

    /// Goes on with another number of threads, at least one; an engine of one thread does nothing.
    ///
    /// # Panics
    /// When the threads cannot be started.
    fn set_threads(&mut self, _threads: usize) {}

    /// The state in plain order.
    fn state(&self) -> FieldState;

    /// Takes over a state.
    ///
    /// # Panics
    /// When the state belongs to another setup (lengths differ).
    fn set_state(&mut self, state: &FieldState);

    /// Whether a sample row of the field is finite; another row with each `turn`.
    fn row_is_finite(&self, turn: usize) -> bool;
}

/// Row of the layers' memory along y that belongs to grid row `iy`, if any.
pub(super) fn layer_row(cells: usize, ny: usize, iy: usize) -> Option<usize> {
    if iy < cells {
        Some(iy)
    } else if iy + cells >= ny {
        Some(iy + 2 * cells - ny)
    } else {
        None
    }
}

/// Sets what is below [`FLUSH_BELOW_PA`] to zero.
#[inline(always)]
pub(super) fn flush_subnormals<N: Real>(numbers: &mut [N]) {
    for number in numbers {
        if number.is_below(FLUSH_BELOW_PA) {
            *number = N::default();
        }
    }
}

/// Sum of the receiver's row sums, in row order.
pub(super) fn combine_rows(receiver: &Stencil, rows: &[f64]) -> f32 {
    let sum: f64 = receiver
        .wy
        .iter()
        .zip(rows)
        .map(|(&w, &row)| f64::from(w) * row)
        .sum();
    sum as f32
}
