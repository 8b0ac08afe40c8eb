//! The wave operator near rigid walls, as sparse corrections to the plain stencil.
//!
//! A rigid wall closes faces of the second differences `A` and `B` or parts of them (no flow through the wall): `A` is
//! `-V^-1 D' a D` with the open areas `V` of the cells and the weights `a` of the faces. The scheme's polynomial in the masked `A` and
//! `B` is symmetric and negative semidefinite in the inner product weighted with `V`, whatever the walls' shape; here its rows near walls
//! are worked out once and stored as differences to the plain stencil. Solid cells hold zero pressure, so the plain
//! stencil sees nothing beyond the wall; next to whole cells few entries per row differ.

use super::inertance::Row;
use super::surface::{Surface, surfaces};
use super::{Opening, SolidMask, WallCells};
use crate::scheme::{Polynomial, Weights};
use std::collections::BTreeMap;

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
    /// Surfaces that are not rigid by row of the cells that they take their flow from.
    pub surfaces: Vec<Vec<Surface>>,
}

type Values = [[f64; WIDTH]; WIDTH];

/// A small piece of grid around a cell, and what walls leave of it.
struct Patch {
    area: Values,
    west: Values,
    south: Values,
    /// How much of the square of A - B slanted walls leave out ([`super::slant`]).
    slanted: Values,
    /// Pairs of cells `[x, y]` with a way between them, and its weight.
    bridges: Vec<([[usize; 2]; 2], f64)>,
}

impl Patch {
    /// Without walls.
    fn open() -> Self {
        let full = [[1.0; WIDTH]; WIDTH];
        Self {
            area: full,
            west: full,
            south: full,
            slanted: [[0.0; WIDTH]; WIDTH],
            bridges: Vec::new(),
        }
    }

    /// Around a cell; what lies outside the grid is open, as the plain stencil has it.
    fn around(walls: &WallCells, [ix, iy]: [usize; 2], spare: f64) -> Self {
        let mut patch = Self::open();
        let mut small = Vec::new();
        for y in 0..WIDTH {
            for x in 0..WIDTH {
                let at = |i: usize, centre: usize| centre as isize + i as isize - REACH;
                let opening = walls.opening(at(x, ix), at(y, iy)).unwrap_or(Opening {
                    area: 0.0,
                    west: 0.0,
                    south: 0.0,
                });
                patch.area[y][x] = opening.area;
                patch.west[y][x] = opening.west;
                patch.south[y][x] = opening.south;
                if let Some(slant) = walls.slant(at(x, ix), at(y, iy)) {
                    patch.slanted[y][x] = slant.share;
                    small.extend(slant.bridge.map(|bridge| ([x, y], bridge)));
                }
            }
        }
        for (place, bridge) in small {
            let ends = bridge.ends(place.map(|at| at as isize));
            // Those that reach beyond the patch are too far away for the row.
            let inside = |at: isize| (0..WIDTH as isize).contains(&at);
            if ends.iter().flatten().all(|&at| inside(at)) {
                let ends = ends.map(|end| end.map(|at| at as usize));
                let weight = bridge.borne(spare, ends.map(|[x, y]| patch.area[y][x]));
                patch.bridges.push((ends, weight));
            }
        }
        patch
    }

    /// What the bridges add to `A u + B u`.
    fn bridged(&self, u: &Values) -> Values {
        let mut out = [[0.0; WIDTH]; WIDTH];
        for &([[x, y], [to_x, to_y]], weight) in &self.bridges {
            let flow = weight * (u[to_y][to_x] - u[y][x]);
            out[y][x] += flow / self.area[y][x];
            out[to_y][to_x] -= flow / self.area[to_y][to_x];
        }
        out
    }

    /// `(A - B) (1 - Q) (A - B) u` with 1 - Q the shares of [`super::slant`], from `a = A u` and `b = B u`.
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

    /// Row of the operator at the patch's centre: what a unit pressure there does, turned around by the symmetry of
    /// the operator in the inner product of the areas.
    fn operator_row(&self, weights: &Weights) -> Values {
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
    /// Works out the rows near `walls` for a scheme with `weights`, the rounded ones of `polynomial`, and stencil `radius` (1 to 3).
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
            surfaces: vec![Vec::new(); ny],
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

    /// With the surfaces of `walls` that are not rigid, for a scheme with `weights` and stencil `radius`, the Courant number of `polynomial`, steps of `dt_s` and the characteristic
    /// impedance `rho c` of the air in Pa s/m.
    #[must_use]
    pub fn with_surfaces(
        mut self,
        walls: &WallCells,
        weights: &Weights,
        polynomial: &Polynomial,
        radius: usize,
        dt_s: f64,
        characteristic_pasm: f64,
    ) -> Self {
        let surfaces = surfaces(
            walls,
            &self.rows(walls, weights, polynomial, radius),
            polynomial,
            radius,
            dt_s,
            characteristic_pasm,
        );
        self.surfaces = surfaces;
        self
    }

    /// Rows of the operator over the Courant number squared, of cells that hold air.
    fn rows<'a>(
        &'a self,
        walls: &'a WallCells,
        weights: &Weights,
        polynomial: &Polynomial,
        radius: usize,
    ) -> impl Fn([usize; 2]) -> Row + 'a {
        let plain = Patch::open().operator_row(weights);
        let (reach, linear) = (radius as isize, polynomial.linear);
        move |[ix, iy]| {
            let [x, y] = [ix as isize, iy as isize];
            let mut row: BTreeMap<[isize; 2], f64> = BTreeMap::new();
            for dy in -reach..=reach {
                for dx in -reach..=reach {
                    let [i, j] = [dx, dy].map(|offset| (offset + REACH) as usize);
                    if plain[j][i] != 0.0 && walls.opening(x + dx, y + dy).is_some() {
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

    /// How many numbers the field keeps of surfaces.
    pub fn surface_count(&self) -> usize {
        let surfaces = self.surfaces.iter().flatten();
        surfaces.map(Surface::memory_count).sum()
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
/// They are rounded to the weights' quantum, and the cell's own entry makes the row sum to exactly zero: what the areas and faces of
/// cut cells are must not make a constant pressure move.
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

/// Cells whose stencil can feel a cell that is not whole.
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
