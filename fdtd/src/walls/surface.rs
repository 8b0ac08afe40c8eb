//! Open parts of faces, the weights that the spectrum leaves them, and the surfaces of walls that are not rigid.

use super::clip::{Convex, open_face};
use super::{Load, SolidMask, Wall, WallCells, rasterize};
use crate::grid::Grid;
use std::collections::BTreeMap;

/// Open parts by geometry, and the weights that the spectrum leaves them.
pub(super) struct Openings<'a> {
    pub(super) solid: &'a SolidMask,
    pub(super) near: &'a BTreeMap<usize, Vec<&'a Convex>>,
    pub(super) areas: &'a BTreeMap<usize, f64>,
    /// Impedance in Pa s/m of the wall that a cell lies before, or in.
    pub(super) soft: &'a BTreeMap<usize, f64>,
}

impl Openings<'_> {
    pub(super) fn area(&self, ix: isize, iy: isize) -> f64 {
        match self.solid.index(ix, iy) {
            Some(cell) if self.solid.cells[cell] => 0.0,
            Some(cell) => self.areas.get(&cell).copied().unwrap_or(1.0),
            None => 1.0,
        }
    }

    /// Open part of the face of a cell to its neighbour at lower x (`axis` 0) or y (1).
    fn face(&self, axis: usize, ix: isize, iy: isize) -> f64 {
        let other = [(ix - 1, iy), (ix, iy - 1)][axis];
        if self.area(ix, iy) == 0.0 || self.area(other.0, other.1) == 0.0 {
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

    /// What a cell gives to its face at lower (`side` 0) or higher (1) coordinate along an axis.
    fn share(&self, axis: usize, side: usize, ix: isize, iy: isize) -> f64 {
        let next = [(ix + 1, iy), (ix, iy + 1)][axis];
        let faces = [self.face(axis, ix, iy), self.face(axis, next.0, next.1)];
        let soft = self
            .solid
            .index(ix, iy)
            .is_some_and(|cell| self.soft.contains_key(&cell));
        // A surface that gives way takes the share of the part that it closes.
        let all = if soft {
            2.0 * faces[0].max(faces[1])
        } else {
            faces[0] + faces[1]
        };
        4.0 * self.area(ix, iy) * faces[side] / all
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

    /// The surfaces of the soft cells.
    pub(super) fn loads(&self) -> BTreeMap<usize, Load> {
        let load = |(&cell, &impedance_pasm): (&usize, &f64)| {
            let (ix, iy) = (
                (cell % self.solid.nx) as isize,
                (cell / self.solid.nx) as isize,
            );
            let area = self.area(ix, iy);
            let (mut length, mut given) = (0.0_f64, 0.0);
            for axis in 0..2 {
                let next = [(ix + 1, iy), (ix, iy + 1)][axis];
                let faces = [self.face(axis, ix, iy), self.face(axis, next.0, next.1)];
                let closed = (faces[1] - faces[0]).abs();
                let beyond = match (axis, faces[0] < faces[1]) {
                    (0, true) => (ix - 1, iy),
                    (0, false) => (ix + 1, iy),
                    (_, true) => (ix, iy - 1),
                    (_, false) => (ix, iy + 1),
                };
                let rigid = self
                    .solid
                    .index(beyond.0, beyond.1)
                    .is_some_and(|cell| self.solid.cells[cell] && !self.soft.contains_key(&cell));
                if closed > 0.0 && !rigid {
                    length = length.hypot(closed);
                    given += 2.0 * area * closed / faces[0].max(faces[1]);
                }
            }
            (length > 0.0).then(|| {
                let load = Load {
                    impedance_pasm,
                    length,
                    area,
                    least_mass: length / given,
                };
                (cell, load)
            })
        };
        self.soft.iter().filter_map(load).collect()
    }
}

/// Cells in and before walls that are not rigid, and those walls' impedances, from the walls that take cells or parts of them.
pub(super) fn soft_cells(
    walls: &[Wall],
    owners: &BTreeMap<usize, usize>,
    solid: &SolidMask,
) -> BTreeMap<usize, f64> {
    let mut soft = BTreeMap::new();
    if walls.iter().all(|wall| wall.impedance_pasm.is_none()) {
        return soft;
    }
    for (&cell, &wall) in owners {
        let Some(impedance_pasm) = walls[wall].impedance_pasm else {
            continue;
        };
        soft.insert(cell, impedance_pasm);
        if !solid.cells[cell] {
            continue;
        }
        let (ix, iy) = (cell % solid.nx, cell / solid.nx);
        let around = [
            (ix.wrapping_sub(1), iy),
            (ix + 1, iy),
            (ix, iy.wrapping_sub(1)),
            (ix, iy + 1),
        ];
        for (x, y) in around {
            let beside = y.wrapping_mul(solid.nx).wrapping_add(x);
            let free = x < solid.nx && y < solid.ny && !solid.cells[beside];
            if free && !owners.contains_key(&beside) {
                soft.insert(beside, impedance_pasm);
            }
        }
    }
    soft
}

/// Whole cells with the surfaces of walls that are not rigid.
pub(super) fn staircase(grid: &Grid, walls: &[Wall]) -> WallCells {
    let solid = rasterize(grid, walls);
    let mut owners = BTreeMap::new();
    if walls.iter().any(|wall| wall.impedance_pasm.is_some()) {
        for (index, wall) in walls.iter().enumerate() {
            let own = rasterize(grid, std::slice::from_ref(wall));
            owners.extend(own.iter_solid().map(|(ix, iy)| (iy * grid.nx + ix, index)));
        }
    }
    let soft = soft_cells(walls, &owners, &solid);
    let open = Openings {
        solid: &solid,
        near: &BTreeMap::new(),
        areas: &BTreeMap::new(),
        soft: &soft,
    };
    let loads = open.loads();
    WallCells::from(solid).with_loads(loads)
}
