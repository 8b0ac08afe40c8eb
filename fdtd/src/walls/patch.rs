//! A row of the wave operator, computed in a small part of the grid around its cell.

use super::slant::place_in;
use super::wall_cells::{CutCell, WallCells};
use crate::scheme::Weights;

/// Half width of a patch in cells; a scheme of radius three needs three cells and their faces.
pub(super) const REACH: isize = 4;
/// Width of a patch in cells.
pub(super) const WIDTH: usize = 2 * REACH as usize + 1;

/// Numbers by cell of a patch, `[y][x]`.
pub(super) type Values = [[f64; WIDTH]; WIDTH];

/// Open areas and face weights in a small part of the grid around a cell.
pub(super) struct Patch {
    /// Open area of each cell; 0 in solid ones.
    pub(super) area: Values,
    west: Values,
    south: Values,
    /// Share of the square of A - B that is left out at slanted walls ([`super::slant`]).
    slanted: Values,
    /// Bridges past small cells: the pairs of cells `[x, y]` that they join, and weights.
    bridges: Vec<([[usize; 2]; 2], f64)>,
}

impl Patch {
    /// Without walls.
    pub(super) fn open() -> Self {
        let full = [[1.0; WIDTH]; WIDTH];
        Self {
            area: full,
            west: full,
            south: full,
            slanted: [[0.0; WIDTH]; WIDTH],
            bridges: Vec::new(),
        }
    }

    /// Around a cell, for a scheme with `spare` ([`crate::scheme::Polynomial::spare`]). Outside the grid everything
    /// is open, as for the plain stencil.
    pub(super) fn around(walls: &WallCells, [ix, iy]: [usize; 2], spare: f64) -> Self {
        let mut patch = Self::open();
        for y in 0..WIDTH {
            for x in 0..WIDTH {
                let at = |i: usize, centre: usize| centre as isize + i as isize - REACH;
                let cut = walls.cut_cell(at(x, ix), at(y, iy)).unwrap_or(CutCell {
                    area: 0.0,
                    west: 0.0,
                    south: 0.0,
                });
                patch.area[y][x] = cut.area;
                patch.west[y][x] = cut.west;
                patch.south[y][x] = cut.south;
                if let Some(slant) = walls.slant(at(x, ix), at(y, iy)) {
                    patch.slanted[y][x] = slant.share;
                }
            }
        }
        let first = [ix, iy].map(|at| at as isize - REACH);
        for (ends, weight) in walls.bridges(first, WIDTH, spare) {
            // Bridges across the rim of the patch do not reach the row.
            if let [Some(end), Some(other)] = ends.map(|end| place_in(end, WIDTH)) {
                patch.bridges.push(([end, other], weight));
            }
        }
        patch
    }

    /// Contribution of the bridges to `A u + B u`.
    fn bridged(&self, u: &Values) -> Values {
        let mut out = [[0.0; WIDTH]; WIDTH];
        for &([[x, y], [to_x, to_y]], weight) in &self.bridges {
            let flow = weight * (u[to_y][to_x] - u[y][x]);
            out[y][x] += flow / self.area[y][x];
            out[to_y][to_x] -= flow / self.area[to_y][to_x];
        }
        out
    }

    /// `(A - B) (1 - Q) (A - B) u` with the shares 1 - Q of [`super::slant`], from `a = A u` and `b = B u`.
    fn left_out(&self, a: &Values, b: &Values) -> Values {
        let mut between = combine(&[(1.0, a), (-1.0, b)]);
        for (value, slanted) in (between.iter_mut().flatten()).zip(self.slanted.iter().flatten()) {
            *value *= slanted;
        }
        combine(&[
            (1.0, &self.second_difference(&between, 0)),
            (-1.0, &self.second_difference(&between, 1)),
        ])
    }

    /// Masked second difference of `u` along x (`axis` 0) or y (1); zero in solid cells and on the patch's rim.
    fn second_difference(&self, u: &Values, axis: usize) -> Values {
        let mut out = [[0.0; WIDTH]; WIDTH];
        for y in 1..WIDTH - 1 {
            for x in 1..WIDTH - 1 {
                if self.area[y][x] == 0.0 {
                    continue;
                }
                let (low, high) = if axis == 0 {
                    (
                        self.west[y][x] * (u[y][x - 1] - u[y][x]),
                        self.west[y][x + 1] * (u[y][x + 1] - u[y][x]),
                    )
                } else {
                    (
                        self.south[y][x] * (u[y - 1][x] - u[y][x]),
                        self.south[y + 1][x] * (u[y + 1][x] - u[y][x]),
                    )
                };
                out[y][x] = (low + high) / self.area[y][x];
            }
        }
        out
    }

    /// Row of the operator at the centre of the patch: the response to a unit pressure there, transposed by the
    /// symmetry of the operator in the inner product of the areas.
    pub(super) fn operator_row(&self, weights: &Weights) -> Values {
        let mut unit = [[0.0; WIDTH]; WIDTH];
        unit[REACH as usize][REACH as usize] = 1.0;
        let a = self.second_difference(&unit, 0);
        let b = self.second_difference(&unit, 1);
        let mut out = combine(&[
            (f64::from(weights.linear), &a),
            (f64::from(weights.linear), &b),
            (f64::from(weights.linear), &self.bridged(&unit)),
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
            let unlike = 0.5 * (square - half);
            if unlike < 0.0 && square + half <= 0.0 {
                out = combine(&[(1.0, &out), (-unlike, &self.left_out(&a, &b))]);
            }
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
        let own = self.area[REACH as usize][REACH as usize];
        for (row, areas) in out.iter_mut().zip(&self.area) {
            for (weight, area) in row.iter_mut().zip(areas) {
                *weight *= area / own;
            }
        }
        out
    }
}

/// Sum of factors times values.
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
