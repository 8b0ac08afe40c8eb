//! The buffers that the tiles of one time block share, and the levels and weights of their steps.

use super::super::super::stencil::Splat;
use super::super::plan::Plan;
use super::vector::Vector;

/// The buffers of a field as the tiles of one time block see them.
#[derive(Clone, Copy)]
pub(in super::super) struct Shared {
    /// Level of the first step, and the past that it overwrites; both start at the first row of the rim.
    pub(in super::super) levels: [*mut f32; 2],
    /// Layer memory along x, see `pml_memory`.
    pub(in super::super) layer_x: *mut f32,
    /// Layer memory along y, see `pml_memory`.
    pub(in super::super) layer_y: *mut f32,
    /// Memory of surfaces that are not rigid; that of a row belongs to who writes the row.
    pub(in super::super) surfaces: *mut f32,
}

/// The stencil's weights for whole vectors and for the narrow ones of the strips, worked out once for all rows of a
/// tile.
pub(super) struct Weights<V: Vector> {
    pub(super) wide: Splat<V>,
    pub(super) narrow: Splat<V::Narrow>,
}

impl<V: Vector> Weights<V> {
    #[inline(always)]
    pub(super) fn new(plan: &Plan) -> Self {
        let weights = &plan.setup.weights;
        Self {
            wide: Splat::new(weights),
            narrow: Splat::new(weights),
        }
    }
}

/// The levels of one step: the one it reads, and the past that it overwrites.
#[derive(Clone, Copy)]
pub(super) struct Levels {
    pub(super) now: *const f32,
    pub(super) next: *mut f32,
}

// SAFETY: the pointers are only used by tiles of one block, on disjoint rows (see `tiles`), while the field that owns
// the buffers is mutably borrowed by the call that starts them.
unsafe impl Send for Shared {}
// SAFETY: as above.
unsafe impl Sync for Shared {}
