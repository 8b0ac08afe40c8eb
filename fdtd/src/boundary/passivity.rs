//! Passivity: the least mass of a surface with which no wall makes energy.
//!
//! `chi^2 sum l (f.p)^2/m` over all surfaces must not exceed the difference between 4 and the rigid operator (see
//! [`super::design`]). That difference is at least the form `H = chi^2 [spare V + smooth (8 V - V P - V Q)]` of
//! [`Polynomial::slack`], less the bridges of [`crate::walls::slant`]: large for smooth fields, which the weights f
//! sample, and small for the checkerboard, which they do not. With `G = sum chi^2 f' H^-1 f` between two surfaces,
//! `m >= sum l |G|` for each surface, summed over all others and itself, is sufficient (Gershgorin's circles of the
//! matrix of G, scaled with the lengths). `y = H^-1 f` is computed by conjugate gradients in a window around the
//! surface: it falls to a quarter from cell to cell, so that the truncation is far below [`MARGIN`].

use super::linear::conjugate_gradients;
use super::surface_element::SurfaceElement;
use crate::scheme::Polynomial;
use crate::walls::WallCells;
use crate::walls::slant::place_in;
use std::collections::BTreeMap;

/// Half width of the window in cells.
const REACH: isize = 6;
/// Width of the window in cells.
const WIDTH: usize = 2 * REACH as usize + 1;
/// Rounds of conjugate gradients; each reduces the error to about a quarter.
const ROUNDS: usize = 8;
/// Factor on the masses that covers truncation.
const MARGIN: f64 = 1.01;

/// Numbers by cell of the window, `[y][x]`.
type Values = [[f64; WIDTH]; WIDTH];

/// Least masses in cell widths of all surface elements of a grid, for any impedance.
pub(super) fn least_masses(
    walls: &WallCells,
    polynomial: &Polynomial,
    elements: &[SurfaceElement],
) -> Vec<f64> {
    let mut parts: BTreeMap<[usize; 2], Vec<(usize, f64)>> = BTreeMap::new();
    for (index, element) in elements.iter().enumerate() {
        for (&cell, &weight) in &element.reach {
            parts.entry(cell).or_default().push((index, weight));
        }
    }
    let slack = slack(polynomial);
    let least = |element: &SurfaceElement| -> f64 {
        let window = Neighbourhood::around(walls, element.cell, slack);
        let mut load = [[0.0; WIDTH]; WIDTH];
        for (&cell, weight) in &element.reach {
            let [x, y] = [0, 1].map(|axis| window.place(cell, axis));
            load[y][x] = *weight;
        }
        let answer = window.solve(&load);
        let mut shared: BTreeMap<usize, f64> = BTreeMap::new();
        for (y, row) in answer.iter().enumerate() {
            for (x, answer) in row.iter().enumerate() {
                for &(other, weight) in window
                    .cell(x, y)
                    .and_then(|cell| parts.get(&cell))
                    .into_iter()
                    .flatten()
                {
                    *shared.entry(other).or_default() += answer * weight;
                }
            }
        }
        let terms = shared
            .iter()
            .map(|(&other, with)| elements[other].length * with.abs());
        MARGIN * terms.sum::<f64>()
    };
    elements.iter().map(least).collect()
}

/// The coefficients `[spare, smooth]` of the form H.
fn slack(polynomial: &Polynomial) -> [f64; 2] {
    let [spare, smooth] = polynomial.slack();
    [spare.max(1e-6), smooth]
}

/// The form H in a window of cells.
struct Neighbourhood {
    centre: [usize; 2],
    /// `smooth` times the weights of the faces at lower x; zero on the rim of the window, beyond which the field is
    /// zero.
    west: Values,
    /// The same at lower y.
    south: Values,
    /// Diagonal of the form; 0 where there is no air.
    own: Values,
    /// Bridges past small cells: the pairs of cells that they join, and weights.
    bridges: Vec<([[usize; 2]; 2], f64)>,
}

impl Neighbourhood {
    /// Around a cell, for the coefficients of H.
    fn around(walls: &WallCells, centre: [usize; 2], [spare, smooth]: [f64; 2]) -> Self {
        let mut window = Self {
            centre,
            west: [[0.0; WIDTH]; WIDTH],
            south: [[0.0; WIDTH]; WIDTH],
            own: [[0.0; WIDTH]; WIDTH],
            bridges: Vec::new(),
        };
        for y in 0..WIDTH {
            for x in 0..WIDTH {
                let at = |i: usize, axis: usize| centre[axis] as isize + i as isize - REACH;
                let Some(cut) = walls.cut_cell(at(x, 0), at(y, 1)) else {
                    continue;
                };
                window.own[y][x] += (spare + 8.0 * smooth) * cut.area;
                let (west, south) = (smooth * cut.west, smooth * cut.south);
                window.own[y][x] -= west + south;
                if x > 0 {
                    window.west[y][x] = west;
                    window.own[y][x - 1] -= west;
                }
                if y > 0 {
                    window.south[y][x] = south;
                    window.own[y - 1][x] -= south;
                }
            }
        }
        // Bridges are a part of the operator and reduce the form.
        let first = centre.map(|at| at as isize - REACH);
        for (ends, weight) in walls.bridges(first, WIDTH, spare) {
            let inside = ends.map(|end| place_in(end, WIDTH));
            for [x, y] in inside.into_iter().flatten() {
                window.own[y][x] -= weight;
            }
            if let [Some(end), Some(other)] = inside {
                window.bridges.push(([end, other], weight));
            }
        }
        window
    }

    /// Place in the window of a cell along an axis.
    fn place(&self, cell: [usize; 2], axis: usize) -> usize {
        (cell[axis] + REACH as usize) - self.centre[axis]
    }

    /// The cell at a place in the window; `None` at negative columns and rows.
    fn cell(&self, x: usize, y: usize) -> Option<[usize; 2]> {
        let at = |i: usize, axis: usize| (self.centre[axis] + i).checked_sub(REACH as usize);
        Some([at(x, 0)?, at(y, 1)?])
    }

    /// The form applied to a field.
    fn apply(&self, u: &Values) -> Values {
        let mut out = [[0.0; WIDTH]; WIDTH];
        for y in 0..WIDTH {
            for x in 0..WIDTH {
                out[y][x] += self.own[y][x] * u[y][x];
                if x > 0 {
                    out[y][x] += self.west[y][x] * u[y][x - 1];
                    out[y][x - 1] += self.west[y][x] * u[y][x];
                }
                if y > 0 {
                    out[y][x] += self.south[y][x] * u[y - 1][x];
                    out[y - 1][x] += self.south[y][x] * u[y][x];
                }
            }
        }
        for &([[x, y], [to_x, to_y]], weight) in &self.bridges {
            out[y][x] += weight * u[to_y][to_x];
            out[to_y][to_x] += weight * u[y][x];
        }
        out
    }

    /// The field to which the form gives `load`.
    fn solve(&self, load: &Values) -> Values {
        let form = |u: &[f64]| {
            let mut values = [[0.0; WIDTH]; WIDTH];
            values.as_flattened_mut().copy_from_slice(u);
            self.apply(&values).as_flattened().to_vec()
        };
        let (own, load) = (self.own.as_flattened(), load.as_flattened());
        let mut found = [[0.0; WIDTH]; WIDTH];
        let solution = conjugate_gradients(form, own, load, ROUNDS);
        found.as_flattened_mut().copy_from_slice(&solution);
        found
    }
}
