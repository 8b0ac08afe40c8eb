//! Open parts of faces, the weights that the spectrum leaves them, and the surfaces of walls that are not rigid.

use super::clip::{Convex, open_face};
use super::{Load, SolidMask, Wall, WallCells, rasterize};
use crate::grid::Grid;
use std::collections::{BTreeMap, BTreeSet};

/// Distance in cell widths from a cell's middle to its corners: walls farther away do not cut it.
const FARTHEST: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Open parts by geometry, and the weights that the spectrum leaves them.
pub(super) struct Openings<'a> {
    pub(super) solid: &'a SolidMask,
    pub(super) near: &'a BTreeMap<usize, Vec<&'a Convex>>,
    pub(super) areas: &'a BTreeMap<usize, f64>,
    /// Solid cells that hold a little air.
    pub(super) slivers: &'a BTreeSet<usize>,
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
    pub(super) fn face(&self, axis: usize, ix: isize, iy: isize) -> f64 {
        let other = [(ix - 1, iy), (ix, iy - 1)][axis];
        if self.area(ix, iy) == 0.0 || self.area(other.0, other.1) == 0.0 {
            return 0.0;
        }
        self.shaped_face(axis, ix, iy)
    }

    /// The same by the shapes alone: faces to slivers are not closed for their sake.
    fn shaped_face(&self, axis: usize, ix: isize, iy: isize) -> f64 {
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

    /// What a cell gives to its face at lower (`side` 0) or higher (1) coordinate along an axis.
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

    /// The surfaces of the soft cells, which `soft` gives with their walls.
    pub(super) fn loads(
        &self,
        grid: &Grid,
        walls: &[Wall],
        soft: &BTreeMap<usize, usize>,
    ) -> Vec<Load> {
        let load = |(&cell, &index): (&usize, &usize)| {
            let wall = &walls[index];
            let (ix, iy) = (
                (cell % self.solid.nx) as isize,
                (cell / self.solid.nx) as isize,
            );
            // Closed parts, positive where the wall is on the side of higher coordinates: the surface's length times its normal. Those by shape
            // are without the slivers' surface, which is added to that of the cells beside them.
            let (mut closed, mut shaped) = ([0.0_f64; 2], [0.0_f64; 2]);
            for (axis, (closed, shaped)) in closed.iter_mut().zip(&mut shaped).enumerate() {
                let next = [(ix + 1, iy), (ix, iy + 1)][axis];
                let part = self.face(axis, ix, iy) - self.face(axis, next.0, next.1);
                let step = if part > 0.0 { 1 } else { -1 };
                let beyond = [(ix + step, iy), (ix, iy + step)][axis];
                let rigid = self
                    .solid
                    .index(beyond.0, beyond.1)
                    .is_some_and(|cell| self.solid.cells[cell] && !soft.contains_key(&cell));
                if !rigid {
                    *closed = part;
                    *shaped =
                        self.shaped_face(axis, ix, iy) - self.shaped_face(axis, next.0, next.1);
                }
            }
            let along = if shaped == [0.0; 2] { closed } else { shaped };
            let along_length = along[0].hypot(along[1]);
            if along_length == 0.0 {
                return None;
            }
            let normal = along.map(|part| -part / along_length);
            let length = -(closed[0] * normal[0] + closed[1] * normal[1]);
            if length <= 0.0 {
                // Nothing but the side of a sliver that looks the other way.
                return None;
            }
            let distance = if self.near.contains_key(&cell) {
                let centre_m = [ix, iy].map(|at| (at as f64 + 0.5) * grid.dx_m);
                (wall.distance_m(centre_m) / grid.dx_m).clamp(-FARTHEST, FARTHEST)
            } else {
                0.5 * normal[0].abs().max(normal[1].abs())
            };
            Some(Load {
                impedance: wall.impedance.clone()?,
                length,
                cell: [ix as usize, iy as usize],
                normal,
                distance,
            })
        };
        soft.iter().filter_map(load).collect()
    }
}

/// Cells in and before walls that are not rigid, and those walls' places in the list, from the walls that take cells or parts of them.
pub(super) fn soft_cells(
    walls: &[Wall],
    owners: &BTreeMap<usize, usize>,
    solid: &SolidMask,
) -> BTreeMap<usize, usize> {
    let mut soft = BTreeMap::new();
    if walls.iter().all(|wall| wall.impedance.is_none()) {
        return soft;
    }
    for (&cell, &wall) in owners {
        if walls[wall].impedance.is_none() {
            continue;
        }
        soft.insert(cell, wall);
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
                soft.insert(beside, wall);
            }
        }
    }
    soft
}

/// Whole cells with the surfaces of walls that are not rigid.
pub(super) fn staircase(grid: &Grid, walls: &[Wall]) -> WallCells {
    let solid = rasterize(grid, walls);
    let mut owners = BTreeMap::new();
    if walls.iter().any(|wall| wall.impedance.is_some()) {
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
        slivers: &BTreeSet::new(),
    };
    let loads = open.loads(grid, walls, &soft);
    WallCells::from(solid).with_loads(loads)
}
