//! The plain step of each scheme and the recursion of the absorbing layer, written once for a number or a vector of
//! them.

use crate::number::Number;
use crate::scheme::Weights;

/// Weights as numbers of the engine.
#[derive(Clone, Copy)]
pub(super) struct Splat<N> {
    pub(super) centre: N,
    pub(super) edge: N,
    pub(super) corner: N,
    pub(super) far: N,
    pub(super) knight: N,
    pub(super) outer: N,
    /// Contribution of the absorbing layer to a cell, its neighbours along the absorbed axis, those across it, those at
    /// distance two along it, and the diagonal ones.
    layer: [N; 5],
}

impl<N: Number> Splat<N> {
    #[inline(always)]
    pub(super) fn new(weights: &Weights) -> Self {
        Self {
            layer: weights.layer().map(N::splat),
            centre: N::splat(weights.centre),
            edge: N::splat(weights.edge),
            corner: N::splat(weights.corner),
            far: N::splat(weights.far),
            knight: N::splat(weights.knight),
            outer: N::splat(weights.outer),
        }
    }

    /// Standard leapfrog: new pressure from the cell, its west and east, south and north neighbours and its past.
    #[inline(always)]
    pub(super) fn slf(&self, here: N, [west, east]: [N; 2], [south, north]: [N; 2], past: N) -> N {
        let around = south.add(north).add(west.add(east));
        self.centre.mul_add(here, self.edge.mul_sub(around, past))
    }

    /// Part of the 13-point stencil that a column gives to the columns beside it: the column's cell in this row, and
    /// the sum of its cells in the rows below and above.
    #[inline(always)]
    pub(super) fn m13_column(&self, here: N, vertical: N) -> N {
        self.edge.mul_add(here, self.corner.mul(vertical))
    }

    /// 13-point step from the cell, the sum `vertical` of its south and north neighbours, the column parts of its west
    /// and east neighbours ([`Splat::m13_column`]), the neighbours at distance two along x and y, and its past.
    #[inline(always)]
    pub(super) fn m13(
        &self,
        here: N,
        vertical: N,
        columns: [N; 2],
        far_x: [N; 2],
        far_y: [N; 2],
        past: N,
    ) -> N {
        let far = far_y[0].add(far_y[1]).add(far_x[0].add(far_x[1]));
        let sum = self.edge.mul_add(vertical, self.far.mul_sub(far, past));
        self.centre
            .mul_add(here, sum.add(columns[0].add(columns[1])))
    }

    /// Quantity whose second difference the absorbing layer takes (see [`crate::pml`]), from a cell, its neighbours
    /// along the absorbed axis and those across it.
    #[inline(always)]
    pub(super) fn m13_layer(&self, here: N, along: [N; 2], across: [N; 2]) -> N {
        let [own, beside, aside, ..] = self.layer;
        let sum = aside.mul_add(across[0].add(across[1]), own.mul(here));
        beside.mul_add(along[0].add(along[1]), sum)
    }

    /// Contributions of a column to the columns beside it and to those at distance two (25-point step): from its cell
    /// in this row and the sums of its cells one and two rows below and above.
    #[inline(always)]
    pub(super) fn d25_sides(&self, here: N, [near, far]: [N; 2]) -> [N; 2] {
        let beside = self.corner.mul_add(near, self.knight.mul(far));
        [
            self.edge.mul_add(here, beside),
            self.far.mul_add(here, self.knight.mul(near)),
        ]
    }

    /// First term of the 25-point step's sum, which goes from west to east: the cell three to the west, and the past.
    /// Then follow the parts of the columns two and one to the west ([`Splat::d25_sides`]), [`Splat::d25_own`], the
    /// parts of the columns one and two to the east, and [`Splat::d25_last`].
    #[inline(always)]
    pub(super) fn d25_first(&self, west: N, past: N) -> N {
        self.outer.mul_sub(west, past)
    }

    /// Adds the column itself: its cell in this row, and the sums of its cells one, two and three rows below and above.
    #[inline(always)]
    pub(super) fn d25_own(&self, here: N, [near, far, outer]: [N; 3], sum: N) -> N {
        let sum = self.far.mul_add(far, self.outer.mul_add(outer, sum));
        self.centre.mul_add(here, self.edge.mul_add(near, sum))
    }

    /// Adds the cell three to the east.
    #[inline(always)]
    pub(super) fn d25_last(&self, east: N, sum: N) -> N {
        self.outer.mul_add(east, sum)
    }

    /// Quantity whose second difference the absorbing layer takes with the 25-point scheme, from a cell, its neighbours
    /// along the absorbed axis (next and second) and across it, and the diagonal ones.
    #[inline(always)]
    pub(super) fn d25_layer(
        &self,
        here: N,
        [along, beyond]: [[N; 2]; 2],
        across: [N; 2],
        diagonal: [[N; 2]; 2],
    ) -> N {
        let [own, beside, aside, second, corner] = self.layer;
        let pair = |cells: [N; 2]| cells[0].add(cells[1]);
        let sum = aside.mul_add(pair(across), own.mul(here));
        let sum = corner.mul_add(pair(diagonal[0]).add(pair(diagonal[1])), sum);
        let sum = second.mul_add(pair(beyond), sum);
        beside.mul_add(pair(along), sum)
    }
}

/// Memory of the absorbing layer at one cell: lower face, upper face, cell.
pub(super) type LayerMemory<N> = [N; 3];

/// One step of the layer's recursions at one cell from the differences of pressure (with the wide schemes of what
/// [`Splat::m13_layer`] and [`Splat::d25_layer`] give) over its lower and upper face and the decays of lower face,
/// upper face and cell and that of open air; returns the memory after it and what to add to the plain step, in units of
/// the plain step's coefficient of `A + B` (see [`crate::pml`]).
#[inline(always)]
pub(super) fn layer<N: Number>(
    [lower, upper]: [N; 2],
    decay: [N; 3],
    open: N,
    memory: LayerMemory<N>,
) -> (LayerMemory<N>, N) {
    let faces = [
        face_memory(decay[0], open, memory[0], lower),
        face_memory(decay[1], open, memory[1], upper),
    ];
    let (zeta, change) = layer_cell([lower, upper], faces, decay[2], open, memory[2]);
    ([faces[0], faces[1], zeta], change)
}

/// Memory of a face (or cell) with this decay after a step, from that before it and what drives it; `open` is the decay
/// of open air, for which nothing is remembered.
#[inline(always)]
pub(super) fn face_memory<N: Number>(decay: N, open: N, old: N, drive: N) -> N {
    decay.mul_add(old, decay.sub(open).mul(drive))
}

/// The cell's part of [`layer`], from the slopes, the memory of the faces after this step, and the cell's decay and
/// memory before it: the cell's memory after it, and what to add to the plain step.
#[inline(always)]
pub(super) fn layer_cell<N: Number>(
    [lower, upper]: [N; 2],
    faces: [N; 2],
    decay: N,
    open: N,
    memory: N,
) -> (N, N) {
    let bend = faces[1].sub(faces[0]);
    let zeta = face_memory(decay, open, memory, upper.sub(lower).add(bend));
    (zeta, bend.add(zeta))
}
