//! The wave operator near rigid walls, as sparse corrections to the plain stencil.
//!
//! A rigid wall closes faces of the second differences `A` and `B` (no flow through the face). The scheme's polynomial
//! in the masked `A` and `B` is symmetric and negative semidefinite whatever the walls' shape; here its rows near walls
//! are worked out once and stored as differences to the plain stencil. Solid cells hold zero pressure, so the plain
//! stencil sees nothing beyond the wall, and few entries per row differ.

use crate::scheme::Weights;
use crate::walls::SolidMask;

/// Half width of the patch in which a row of the operator is worked out; a scheme of radius three needs three cells and
/// their faces.
const REACH: isize = 4;
const WIDTH: usize = 2 * REACH as usize + 1;

/// One cell next to a wall and the entries that its row has beside the plain stencil.
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

/// A small piece of field around a cell, and the walls in it.
struct Patch<'a> {
    mask: &'a SolidMask,
    centre: [isize; 2],
}

type Values = [[f64; WIDTH]; WIDTH];

impl Patch<'_> {
    /// Solid or not; what lies outside the grid is open, as the plain stencil has it.
    fn solid(&self, dx: isize, dy: isize) -> bool {
        let (ix, iy) = (self.centre[0] + dx, self.centre[1] + dy);
        let inside =
            ix >= 0 && iy >= 0 && (ix as usize) < self.mask.nx && (iy as usize) < self.mask.ny;
        inside && self.mask.cells[iy as usize * self.mask.nx + ix as usize]
    }

    /// Masked second difference of `u` along x (`axis` 0) or y (1); zero in solid cells and on the patch's rim.
    fn second_difference(&self, u: &Values, axis: usize) -> Values {
        let mut out = [[0.0; WIDTH]; WIDTH];
        for dy in 1 - REACH..REACH {
            for dx in 1 - REACH..REACH {
                if self.solid(dx, dy) {
                    continue;
                }
                let at = |x: isize, y: isize| u[(y + REACH) as usize][(x + REACH) as usize];
                let mut sum = 0.0;
                for side in [-1, 1] {
                    let (nx, ny) = if axis == 0 {
                        (dx + side, dy)
                    } else {
                        (dx, dy + side)
                    };
                    if !self.solid(nx, ny) {
                        sum += at(nx, ny) - at(dx, dy);
                    }
                }
                out[(dy + REACH) as usize][(dx + REACH) as usize] = sum;
            }
        }
        out
    }

    /// Row of the operator at the patch's centre (the operator is symmetric: what a unit pressure there does).
    fn operator_row(&self, weights: &Weights) -> Values {
        let mut unit = [[0.0; WIDTH]; WIDTH];
        unit[REACH as usize][REACH as usize] = 1.0;
        let a = self.second_difference(&unit, 0);
        let b = self.second_difference(&unit, 1);
        let mut out = combine(&[
            (f64::from(weights.linear), &a),
            (f64::from(weights.linear), &b),
        ]);
        if weights.square != 0.0 || weights.mixed != 0.0 {
            let square = f64::from(weights.square);
            let half = 0.5 * f64::from(weights.mixed);
            let aa = self.second_difference(&a, 0);
            let bb = self.second_difference(&b, 1);
            let ba = self.second_difference(&a, 1);
            let ab = self.second_difference(&b, 0);
            out = combine(&[
                (1.0, &out),
                (square, &aa),
                (square, &bb),
                (half, &ab),
                (half, &ba),
            ]);
            if weights.cube != 0.0 || weights.cross != 0.0 {
                let (cube, cross) = (f64::from(weights.cube), f64::from(weights.cross));
                out = combine(&[
                    (1.0, &out),
                    (cube, &self.second_difference(&aa, 0)),
                    (cube, &self.second_difference(&bb, 1)),
                    (cross, &self.second_difference(&ba, 0)),
                    (cross, &self.second_difference(&ab, 1)),
                ]);
            }
        }
        out
    }
}

fn combine(terms: &[(f64, &Values)]) -> Values {
    let mut out = [[0.0; WIDTH]; WIDTH];
    for (factor, values) in terms {
        for (row, from) in out.iter_mut().zip(values.iter()) {
            for (cell, value) in row.iter_mut().zip(from) {
                *cell += factor * value;
            }
        }
    }
    out
}

impl WallOperator {
    /// Works out the rows near the walls of `mask` for a scheme with `weights` and stencil `radius` (1 to 3).
    pub fn new(mask: &SolidMask, weights: &Weights, radius: usize) -> Self {
        let (nx, ny) = (mask.nx, mask.ny);
        let open = SolidMask {
            nx: 0,
            ny: 0,
            cells: Vec::new(),
        };
        let plain = Patch {
            mask: &open,
            centre: [0, 0],
        }
        .operator_row(weights);
        let near = near_walls(mask, radius);
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
                    let patch = Patch {
                        mask,
                        centre: [ix as isize, iy as isize],
                    };
                    let entries = difference(&patch, &patch.operator_row(weights), &plain);
                    if !entries.is_empty() {
                        operator.corrections[iy].push(Correction { ix, entries });
                    }
                }
            }
        }
        operator
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
fn difference(patch: &Patch<'_>, row: &Values, plain: &Values) -> Vec<(isize, usize, f32)> {
    let mut entries = Vec::new();
    for dy in -REACH..=REACH {
        for dx in -REACH..=REACH {
            let (i, j) = ((dy + REACH) as usize, (dx + REACH) as usize);
            let weight = row[i][j] - plain[i][j];
            let (ix, iy) = (patch.centre[0] + dx, patch.centre[1] + dy);
            let inside = ix >= 0
                && iy >= 0
                && (ix as usize) < patch.mask.nx
                && (iy as usize) < patch.mask.ny;
            if weight != 0.0 && inside && !patch.solid(dx, dy) {
                entries.push((dy, ix as usize, weight as f32));
            }
        }
    }
    entries
}

/// Cells whose stencil can feel a solid cell.
fn near_walls(mask: &SolidMask, radius: usize) -> Vec<bool> {
    let (nx, ny, r) = (mask.nx as isize, mask.ny as isize, radius as isize);
    let mut near = vec![false; mask.cells.len()];
    for (cell, _) in mask.cells.iter().enumerate().filter(|(_, solid)| **solid) {
        let (ix, iy) = (cell as isize % nx, cell as isize / nx);
        for y in (iy - r).max(0)..=(iy + r).min(ny - 1) {
            for x in (ix - r).max(0)..=(ix + r).min(nx - 1) {
                near[(y * nx + x) as usize] = true;
            }
        }
    }
    near
}
