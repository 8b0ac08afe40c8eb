//! Surface elements of walls of an impedance: where they lie, how long they are and which way they face.

use super::face_weights::FaceWeights;
use super::rasterize::SolidMask;
use super::wall::Wall;
use crate::grid::Grid;
use crate::impedance::Impedance;
use std::collections::BTreeMap;

/// Distance in cell widths from the centre of a cell to its corners: walls farther away do not cut it.
const FARTHEST: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// An element of the surface of a wall of an impedance, within one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// Impedance of the surface.
    pub impedance: Impedance,
    /// Length of the element, in cell widths.
    pub length: f64,
    /// Column and row of the cell in which it lies.
    pub cell: [usize; 2],
    /// Unit vector from the wall into the air.
    pub normal: [f64; 2],
    /// Distance of the centre of the cell from the wall in cell widths, negative within the wall.
    pub distance: f64,
}

impl Load {
    /// Axis of the grid nearest to the normal, 0 for x and 1 for y, and the cosine of the angle between them.
    pub(crate) fn nearest_axis(&self) -> (usize, f64) {
        let [x, y] = self.normal.map(f64::abs);
        if y > x { (1, y) } else { (0, x) }
    }
}

/// The surface elements in `cells`, which maps cell indices to walls as [`impedance_cells`] does, in the order of
/// the cells.
pub(super) fn loads(
    faces: &FaceWeights<'_>,
    grid: &Grid,
    walls: &[Wall],
    cells: &BTreeMap<usize, usize>,
) -> Vec<Load> {
    let load = |(&cell, &index): (&usize, &usize)| {
        let wall = &walls[index];
        let (ix, iy) = (
            (cell % faces.solid.nx) as isize,
            (cell / faces.solid.nx) as isize,
        );
        // Closed parts of the faces, positive where the wall is at higher coordinates: length times normal. The
        // direction comes from the shapes alone; the length includes the surface of slivers, which goes to the cells
        // beside them.
        let (mut closed, mut shaped) = ([0.0_f64; 2], [0.0_f64; 2]);
        for (axis, (closed, shaped)) in closed.iter_mut().zip(&mut shaped).enumerate() {
            let next = [(ix + 1, iy), (ix, iy + 1)][axis];
            let part = faces.face(axis, ix, iy) - faces.face(axis, next.0, next.1);
            let step = if part > 0.0 { 1 } else { -1 };
            let beyond = [(ix + step, iy), (ix, iy + step)][axis];
            let rigid = faces
                .solid
                .index(beyond.0, beyond.1)
                .is_some_and(|cell| faces.solid.cells[cell] && !cells.contains_key(&cell));
            if !rigid {
                *closed = part;
                *shaped = faces.shaped_face(axis, ix, iy) - faces.shaped_face(axis, next.0, next.1);
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
            // The far side of a sliver.
            return None;
        }
        let distance = if faces.near.contains_key(&cell) {
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
    cells.iter().filter_map(load).collect()
}

/// Cells in and beside walls of an impedance, with the places of these walls in the list; `owners` gives the wall
/// that takes a cell or a part of it. Both maps are by cell index.
pub(super) fn impedance_cells(
    walls: &[Wall],
    owners: &BTreeMap<usize, usize>,
    solid: &SolidMask,
) -> BTreeMap<usize, usize> {
    let mut found = BTreeMap::new();
    if walls.iter().all(|wall| wall.impedance.is_none()) {
        return found;
    }
    for (&cell, &wall) in owners {
        if walls[wall].impedance.is_none() {
            continue;
        }
        found.insert(cell, wall);
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
                found.insert(beside, wall);
            }
        }
    }
    found
}
