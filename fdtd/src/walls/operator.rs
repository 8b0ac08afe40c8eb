//! The wave operator near rigid walls, as sparse corrections to the plain stencil.
//!
//! A rigid wall closes faces of the second differences `A` and `B` or parts of them (no flow through the wall): `A`
//! is `-V^-1 D' a D` with the open areas `V` of the cells and the weights `a` of the faces. The scheme's polynomial
//! in the masked `A` and `B` is symmetric and negative semidefinite in the inner product weighted with `V`, whatever
//! the shape of the walls. Its rows near walls are computed once and stored as differences to the plain stencil.
//! Solid cells hold zero pressure, so that the plain stencil reads nothing beyond the wall; next to whole cells few
//! entries per row differ.

use super::patch::{Patch, REACH, Values, WIDTH};
use super::rasterize::SolidMask;
use super::wall_cells::WallCells;
use crate::scheme::{Polynomial, Weights};
use std::collections::BTreeMap;
use std::ops::Range;

/// A row of the operator over the Courant number squared: offsets `[dx, dy]` and weights.
pub(crate) type Row = Vec<([isize; 2], f64)>;

/// A cell near a wall and the difference of its row to the plain stencil.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    /// Column of the cell.
    pub ix: usize,
    /// `(dy, ix, weight)`: row offset and column of a fluid cell, and the weight to add.
    pub entries: Vec<(isize, usize, f32)>,
}

/// Corrections and solid cells of every row of the grid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WallOperator {
    /// Corrections by row, in order of increasing column.
    pub corrections: Vec<Vec<Correction>>,
    /// Columns of the solid cells by row, in increasing order.
    pub solid: Vec<Vec<usize>>,
}

impl WallOperator {
    /// The rows near `walls` for a scheme with `weights`, the rounded ones of `polynomial`, and stencil `radius` (1
    /// to 3).
    pub fn new(
        walls: &WallCells,
        weights: &Weights,
        polynomial: &Polynomial,
        radius: usize,
    ) -> Self {
        let spare = polynomial.spare();
        let mask = walls.solid();
        let (nx, ny) = (mask.nx, mask.ny);
        let plain = Patch::open().operator_row(weights);
        let near = near_walls(walls, radius);
        let mut operator = Self {
            corrections: vec![Vec::new(); ny],
            solid: vec![Vec::new(); ny],
        };
        for iy in 0..ny {
            for ix in 0..nx {
                let cell = iy * nx + ix;
                if mask.cells[cell] {
                    operator.solid[iy].push(ix);
                } else if near[cell] {
                    let patch = Patch::around(walls, [ix, iy], spare);
                    let row = patch.operator_row(weights);
                    let entries = difference(&patch, mask, [ix, iy], &row, &plain);
                    if !entries.is_empty() {
                        operator.corrections[iy].push(Correction { ix, entries });
                    }
                }
            }
        }
        operator
    }

    /// The rows of the operator over the Courant number squared, as a function of the column and row of a fluid cell;
    /// all other arguments as for [`Self::new`].
    pub(crate) fn rows<'a>(
        &'a self,
        walls: &'a WallCells,
        weights: &Weights,
        polynomial: &Polynomial,
        radius: usize,
    ) -> impl Fn([usize; 2]) -> Row + use<'a> {
        let plain = Patch::open().operator_row(weights);
        let (reach, linear) = (radius as isize, polynomial.linear);
        move |[ix, iy]| {
            let [x, y] = [ix as isize, iy as isize];
            let mut row: BTreeMap<[isize; 2], f64> = BTreeMap::new();
            for dy in -reach..=reach {
                for dx in -reach..=reach {
                    let [i, j] = [dx, dy].map(|offset| (offset + REACH) as usize);
                    if plain[j][i] != 0.0 && walls.cut_cell(x + dx, y + dy).is_some() {
                        row.insert([dx, dy], plain[j][i]);
                    }
                }
            }
            let corrections = &self.corrections[iy];
            if let Ok(at) = corrections.binary_search_by_key(&ix, |correction| correction.ix) {
                for &(dy, column, weight) in &corrections[at].entries {
                    *row.entry([column as isize - x, dy]).or_default() += f64::from(weight);
                }
            }
            row.into_iter()
                .map(|(at, weight)| (at, weight / linear))
                .collect()
        }
    }

    /// The solid cells among some columns of a row.
    pub fn solid_within(&self, iy: usize, columns: Range<usize>) -> &[usize] {
        let solid = &self.solid[iy];
        let first = solid.partition_point(|&ix| ix < columns.start);
        let count = solid[first..].partition_point(|&ix| ix < columns.end);
        &solid[first..first + count]
    }

    /// Number of cells with a correction, and of entries in all.
    pub fn size(&self) -> (usize, usize) {
        let cells = self.corrections.iter().map(Vec::len).sum();
        let entries = self
            .corrections
            .iter()
            .flatten()
            .map(|correction| correction.entries.len())
            .sum();
        (cells, entries)
    }
}

/// Entries in which a row differs from the plain stencil, on fluid cells inside the grid only.
///
/// They are rounded to the quantum of the weights, and the entry of the cell itself makes the row sum to exactly
/// zero, so that a constant pressure stays constant.
fn difference(
    patch: &Patch,
    mask: &SolidMask,
    [ix, iy]: [usize; 2],
    row: &Values,
    plain: &Values,
) -> Vec<(isize, usize, f32)> {
    const QUANTUM: f64 = (1u32 << 22) as f64;
    let centre = REACH as usize;
    let mut entries = Vec::new();
    let (mut others, mut own) = (0.0, None);
    for y in 0..WIDTH {
        for x in 0..WIDTH {
            if patch.area[y][x] == 0.0 {
                continue;
            }
            let place = |i: usize, centre: usize| (centre + i).checked_sub(REACH as usize);
            let inside = place(x, ix)
                .zip(place(y, iy))
                .is_some_and(|(x, y)| x < mask.nx && y < mask.ny);
            let mut weight = row[y][x] - plain[y][x];
            if inside {
                weight = (weight * QUANTUM).round() / QUANTUM;
            }
            if [x, y] == [centre, centre] {
                own = Some(entries.len());
                entries.push((0, ix, 0.0));
                continue;
            }
            others += plain[y][x] + weight;
            if inside && weight != 0.0 {
                entries.push((y as isize - REACH, ix + x - centre, weight as f32));
            }
        }
    }
    if let Some(own) = own {
        let weight = -others - plain[centre][centre];
        if weight == 0.0 {
            entries.remove(own);
        } else {
            entries[own].2 = weight as f32;
        }
    }
    entries
}

/// Cells whose stencil reaches a cell that is not whole.
fn near_walls(walls: &WallCells, radius: usize) -> Vec<bool> {
    let mask = walls.solid();
    let (nx, ny, r) = (mask.nx as isize, mask.ny as isize, radius as isize);
    let mut near = vec![false; mask.cells.len()];
    let solid = mask.iter_solid().map(|(ix, iy)| iy * mask.nx + ix);
    for cell in solid.chain(walls.partial().map(|(cell, _)| cell)) {
        let (ix, iy) = (cell as isize % nx, cell as isize / nx);
        for y in (iy - r).max(0)..=(iy + r).min(ny - 1) {
            for x in (ix - r).max(0)..=(ix + r).min(nx - 1) {
                near[(y * nx + x) as usize] = true;
            }
        }
    }
    near
}
