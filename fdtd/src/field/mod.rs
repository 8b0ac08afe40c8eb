//! The sound field: what one step is, and the two engines that take it.
//!
//! One step at every cell, in this order of operations (all of them fused multiply-adds, so that both engines, any
//! thread count and any instruction set give the same bytes):
//! 1. the plain stencil of the scheme, 2. the layer along y, 3. the layers along x, 4. the corrections and surfaces at walls,
//! 5. the source's injections, 6. zero in solid cells, 7. the receiver reads.
//!
//! *Subnormal numbers.* Ahead of the first wave front the field falls off through all magnitudes to zero. Some processors take a hundred cycles for
//! every operation on a number below the normal range, which made the first thousands of steps there ten times as slow as all others. A step that is
//! [`StepForcing::flush`] therefore sets to zero what is below [`FLUSH_BELOW_PA`]: in the layers' memory before 2, in the pressure after 3, and once more
//! after 4 in the cells that 4 changed and in the surfaces' memory; [`flushes_subnormals`] says when that must be. It is part of the step, not of an engine or
//! a processor's mode. What is taken is far below the last digit of anything that is heard; other roundings follow all the same, 120 dB below the
//! signal. Long drives, to which the start is nothing, go without ([`crate::simulation`]).
//!
//! [`ReferenceField`] does this row by row in plain order and is the oracle of [`FastField`], which advances several
//! steps at once in cache (see [`fast`]).

pub mod fast;
pub mod probe;
pub mod reference;
mod stencil;

pub use fast::FastField;
pub use reference::{PreciseField, ReferenceField};

use crate::boundary::{Surfaces, surfaces};
use crate::grid::{Grid, Medium};
use crate::number::Real;
use crate::pml::Profile;
use crate::scheme::{Scheme, Weights};
use crate::spread::Stencil;
use crate::walls::WallCells;
use crate::walls::operator::WallOperator;

/// Everything that stays the same from step to step.
#[derive(Debug, Clone)]
pub struct FieldSetup {
    /// Cells along x.
    pub nx: usize,
    /// Cells along y.
    pub ny: usize,
    /// The scheme.
    pub scheme: Scheme,
    /// Its weights.
    pub weights: Weights,
    /// The absorbing layer on all four sides; zero cells for none (then the edge is pressure-free).
    pub layer: Profile,
    /// The operator near rigid walls.
    pub walls: WallOperator,
    /// Surfaces of walls of an impedance.
    pub surfaces: Surfaces,
}

impl FieldSetup {
    /// Setup of `grid` in `medium` with `scheme`, a layer of `layer_cells` and these walls.
    ///
    /// # Panics
    /// When the walls have another size than the grid, the step is unstable, or two layers would meet.
    pub fn new(
        grid: &Grid,
        medium: &Medium,
        scheme: Scheme,
        layer_cells: usize,
        walls: &WallCells,
    ) -> Self {
        assert_eq!(
            walls.size(),
            [grid.nx, grid.ny],
            "walls and grid differ in size"
        );
        let width = layer_cells.next_multiple_of(8);
        assert!(
            2 * width < grid.nx && 2 * layer_cells < grid.ny,
            "the absorbing layers meet"
        );
        let courant = grid.courant(medium);
        assert!(
            courant <= scheme.max_courant(),
            "Courant number {courant} over the stability limit"
        );
        let weights = scheme.weights(courant);
        let polynomial = scheme.polynomial(courant);
        let operator = WallOperator::new(walls, &weights, &polynomial, scheme.radius());
        Self {
            nx: grid.nx,
            ny: grid.ny,
            scheme,
            weights,
            layer: Profile::new(layer_cells, courant),
            surfaces: surfaces(walls, &operator, grid, medium, scheme),
            walls: operator,
        }
    }
}

/// A source contribution to one step: `amplitude * wx[i] * wy[j]` is added to the new pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Injection {
    /// Where.
    pub stencil: Stencil,
    /// How much, in Pa.
    pub amplitude: f32,
}

/// Pressure that a flushing step takes for zero, in Pa: 400 dB below one.
pub const FLUSH_BELOW_PA: f32 = 1e-20;

/// Whether step `step` of a run sets small numbers to zero. Two steps in a row do, for a step takes two levels and sets only the newest to zero; then none
/// until the front, which runs ahead with the stencil's outermost weights (0.3, -0.02, 0.004 on the papers' grid), or the layers' memory, which keeps
/// a tenth from step to step, comes near to 1e-38, where the normal range of `f32` ends.
pub fn flushes_subnormals(scheme: Scheme, step: u64) -> bool {
    let period = match scheme {
        Scheme::Slf => 16,
        Scheme::M13 | Scheme::O13 => 8,
        Scheme::D25 => 6,
    };
    step % period < 2
}

/// What the outside does to and reads from one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepForcing {
    /// Whether the step sets what is below [`FLUSH_BELOW_PA`] to zero.
    pub flush: bool,
    /// Added to the new pressure, in this order.
    pub injections: [Injection; 2],
    /// Where the new pressure is read.
    pub receiver: Stencil,
}

/// State of a field in plain order, the same for both engines: what a checkpoint holds.
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
    /// Velocity times `rho c` into surfaces that are not rigid, half a step before `pressure`, in Pa: one for each surface and row of the grid that it
    /// takes its flow from. With branches velocity and spring of each of them, see [`crate::boundary::Branches`].
    pub surfaces: Vec<f32>,
}

/// A field that can be advanced.
pub trait Field: Send {
    /// Takes one step per entry of `steps` and appends what the receiver reads after each of them, in Pa.
    fn advance(&mut self, steps: &[StepForcing], received: &mut Vec<f32>);

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
fn layer_row(cells: usize, ny: usize, iy: usize) -> Option<usize> {
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
fn flush_subnormals<N: Real>(numbers: &mut [N]) {
    for number in numbers {
        if number.is_below(FLUSH_BELOW_PA) {
            *number = N::default();
        }
    }
}

/// Sum of the receiver's row sums, in row order.
fn combine_rows(receiver: &Stencil, rows: &[f64]) -> f32 {
    let sum: f64 = receiver
        .wy
        .iter()
        .zip(rows)
        .map(|(&w, &row)| f64::from(w) * row)
        .sum();
    sum as f32
}
