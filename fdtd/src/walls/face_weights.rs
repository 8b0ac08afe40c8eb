//! Open parts of faces, and the weights that stability leaves them ([`super::cut_cells`]).

use super::clip::{Convex, open_face};
use super::rasterize::SolidMask;
use std::collections::{BTreeMap, BTreeSet};

/// Open areas and faces of the cells of a grid. Cells outside the grid are open.
pub(super) struct FaceWeights<'a> {
    pub(super) solid: &'a SolidMask,
    /// Shapes that cover a part of a cell, by cell index `iy nx + ix`.
    pub(super) near: &'a BTreeMap<usize, Vec<&'a Convex>>,
    /// Open area fractions of the cells that are partly covered, by cell index.
    pub(super) areas: &'a BTreeMap<usize, f64>,
    /// Solid cells that hold a little air.
    pub(super) slivers: &'a BTreeSet<usize>,
}

impl FaceWeights<'_> {
    /// Open area fraction of a cell, 0 in solid ones.
    pub(super) fn area(&self, ix: isize, iy: isize) -> f64 {
        match self.solid.index(ix, iy) {
            Some(cell) if self.solid.cells[cell] => 0.0,
            Some(cell) => self.areas.get(&cell).copied().unwrap_or(1.0),
            None => 1.0,
        }
    }

    /// Open part of the face of a cell to its neighbour at lower x (`axis` 0) or y (1).
    pub(super) fn face(&self, axis: usize, ix: isize, iy: isize) -> f64 {
        let other = [(ix - 1, iy), (ix, iy - 1)][axis];
        if self.area(ix, iy) == 0.0 || self.area(other.0, other.1) == 0.0 {
            return 0.0;
        }
        self.shaped_face(axis, ix, iy)
    }

    /// [`Self::face`] by the shapes alone: faces to slivers stay open.
    pub(super) fn shaped_face(&self, axis: usize, ix: isize, iy: isize) -> f64 {
        let other = [(ix - 1, iy), (ix, iy - 1)][axis];
        let is_sliver = |x: isize, y: isize| {
            let cell = self.solid.index(x, y);
            cell.is_some_and(|cell| self.slivers.contains(&cell))
        };
        let closed = |x: isize, y: isize| self.area(x, y) == 0.0 && !is_sliver(x, y);
        if closed(ix, iy) || closed(other.0, other.1) {
            return 0.0;
        }
        let (Some(here), Some(there)) =
            (self.solid.index(ix, iy), self.solid.index(other.0, other.1))
        else {
            return 1.0;
        };
        let shapes: Vec<&Convex> = [here, there]
            .iter()
            .filter_map(|cell| self.near.get(cell))
            .flatten()
            .copied()
            .collect();
        if shapes.is_empty() {
            return 1.0;
        }
        let place = [ix as f64, iy as f64];
        open_face(&shapes, axis, place[axis], place[1 - axis])
    }

    /// The part of four times a cell's area that falls to its face at lower (`side` 0) or higher (1) coordinate along
    /// an axis.
    fn share(&self, axis: usize, side: usize, ix: isize, iy: isize) -> f64 {
        let next = [(ix + 1, iy), (ix, iy + 1)][axis];
        let faces = [self.face(axis, ix, iy), self.face(axis, next.0, next.1)];
        4.0 * self.area(ix, iy) * faces[side] / (faces[0] + faces[1])
    }

    /// Weight of the face of a cell to its neighbour at lower x (`axis` 0) or y (1).
    pub(super) fn weight(&self, axis: usize, ix: isize, iy: isize) -> f64 {
        let face = self.face(axis, ix, iy);
        if face == 0.0 {
            return 0.0;
        }
        let other = [(ix - 1, iy), (ix, iy - 1)][axis];
        let here = self.share(axis, 0, ix, iy);
        let there = self.share(axis, 1, other.0, other.1);
        face.min(here * there / (here + there))
    }
}
