//! Memory of the absorbing layers' recursions.
//!
//! A face between two cells of a layer is the upper face of one and the lower face of the other. Its memory is kept
//! once: every cell keeps its own and that of its outer face, two numbers instead of three. The innermost face of a
//! layer does not decay and remembers zero. Checkpoints hold both copies.

use super::layout::RowLayout;
use super::line::LINE;

/// Memory of the layers along x, row by row: cells and lower faces of the low side, zeros, upper faces and cells of the
/// high side.
#[derive(Debug, Clone, Copy)]
pub(super) struct MemoryX {
    width: usize,
}

impl MemoryX {
    /// For layers `width` cells wide.
    pub(super) fn new(width: usize) -> Self {
        Self { width }
    }

    /// Distance of the rows.
    pub(super) fn stride(self) -> usize {
        4 * self.width + LINE
    }

    /// Offsets in a row of the first face and the first cell of side 0 (low) or 1 (high). Beyond the innermost face
    /// lies a zero.
    #[inline(always)]
    pub(super) fn at(self, side: usize) -> [usize; 2] {
        let high = 2 * self.width + LINE;
        [[self.width, 0], [high, high + self.width]][side]
    }

    /// The rows as a checkpoint holds them: `[iy, 6, width]`.
    pub(super) fn state(self, memory: &[f32]) -> Vec<f32> {
        let w = self.width;
        let ([low, low_cells], [high, high_cells]) = (self.at(0), self.at(1));
        let parts = [low, low + 1, low_cells, high - 1, high, high_cells];
        let rows = memory.chunks_exact(self.stride());
        rows.flat_map(|row| parts.iter().flat_map(move |&part| &row[part..part + w]))
            .copied()
            .collect()
    }

    /// Takes over what [`MemoryX::state`] gave.
    ///
    /// # Panics
    /// When the state belongs to another layer.
    pub(super) fn set_state(self, state: &[f32], memory: &mut [f32]) {
        let w = self.width;
        let rows = memory.len() / self.stride();
        assert_eq!(state.len(), rows * 6 * w, "state of another layer");
        let ([low, low_cells], [high, high_cells]) = (self.at(0), self.at(1));
        let parts = [(0, low), (2, low_cells), (4, high), (5, high_cells)];
        for (iy, row) in memory.chunks_exact_mut(self.stride()).enumerate() {
            for (from, to) in parts {
                row[to..to + w].copy_from_slice(&state[(iy * 6 + from) * w..][..w]);
            }
        }
    }
}

/// Memory of the layers along y: for every row of a layer its outer face and its cells, in the order of the rows of the
/// field. Between the sides lies a row of zeros.
#[derive(Debug, Clone, Copy)]
pub(super) struct MemoryY {
    cells: usize,
    stride: usize,
}

impl MemoryY {
    /// For layers of `cells` rows, `stride` apart in the field.
    pub(super) fn new(cells: usize, stride: usize) -> Self {
        Self { cells, stride }
    }

    /// Numbers in all.
    pub(super) fn len(self) -> usize {
        (2 * self.cells + 1) * 2 * self.stride
    }

    /// Offset of the outer face of row `row` of the layers, low side first; its cells follow a field's row later, the
    /// next row's face two later.
    #[inline(always)]
    pub(super) fn face(self, row: usize) -> usize {
        (row + usize::from(self.is_high(row))) * 2 * self.stride
    }

    /// Whether a row of the layers belongs to the high side.
    #[inline(always)]
    pub(super) fn is_high(self, row: usize) -> bool {
        row >= self.cells
    }

    /// Offsets of lower face, upper face and cells of a row of the layers.
    fn parts(self, row: usize) -> [usize; 3] {
        let (face, both) = (self.face(row), 2 * self.stride);
        let (lower, upper) = if self.is_high(row) {
            (face - both, face)
        } else {
            (face, face + both)
        };
        [lower, upper, face + self.stride]
    }

    /// The rows as a checkpoint holds them: `[row of layer, 3, ix]`.
    pub(super) fn state(self, layout: &RowLayout, memory: &[f32]) -> Vec<f32> {
        let mut state = vec![0.0; 6 * self.cells * layout.nx];
        let parts = (0..2 * self.cells).flat_map(|row| self.parts(row));
        for (part, to) in parts.zip(state.chunks_exact_mut(layout.nx)) {
            layout.unpack(&memory[part..part + self.stride], to);
        }
        state
    }

    /// Takes over what [`MemoryY::state`] gave.
    ///
    /// # Panics
    /// When the state belongs to another layer.
    pub(super) fn set_state(self, layout: &RowLayout, state: &[f32], memory: &mut [f32]) {
        let nx = layout.nx;
        assert_eq!(state.len(), 6 * self.cells * nx, "state of another layer");
        for row in 0..2 * self.cells {
            let face = self.face(row);
            let outer = usize::from(self.is_high(row));
            for (from, to) in [(outer, face), (2, face + self.stride)] {
                let plain = &state[(3 * row + from) * nx..][..nx];
                layout.pack(plain, &mut memory[to..to + self.stride]);
            }
        }
    }
}
