//! Weights before slanted walls: the slanted kernel.
//!
//! A surface element samples the pressure in the cells of a box of three by three before its middle, and takes its
//! flow from the same cells with the same weights, as before walls along the axes ([`super::axis_kernel`]). Before a
//! rigid wall a plane wave is `cos(k d) exp(i h t)`, with the distance d from the wall, the place t along it, and the
//! wave numbers k and h on the grid. The weights turn this, by least squares over waves of all angles up to
//! [`BAND_EDGE`], into the value at the middle of the surface for which the reflection factor is exact:
//!
//! `c sqrt(v/(chi cos(angle)))`, `c = cos(omega dt/2)`, v the group velocity on the grid along the normal in cells
//! per step.
//!
//! The factor c is for the velocity, a mean of two half steps; the root is for a flow that travels on the grid with
//! another velocity than in air. A penalty that grows with distance ([`Fit`]) keeps the weights small and near the
//! wall, so that the mass of air before the surface depends little on frequency and angle ([`super::added_mass`]).
//! Its parameters minimise the error of the reflection factor over angle and impedance (law
//! `tilted_impedance`).

use super::band::{BAND_EDGE, COSINES};
use super::linear::solve;
use super::surface_element::Reach;
use crate::scheme::Polynomial;
use crate::walls::{Load, WallCells};

/// Parameters of the fit.
struct Fit {
    /// Square root of the penalty at the wall for a cell of full area; it is inversely proportional to area.
    ridge: f64,
    /// Distance in cell widths at which the penalty has doubled; it grows with the fourth power of distance.
    depth: f64,
    /// Sum of the weights.
    sum: f64,
    /// Change of the target per square of the wave number (radians per cell) along the normal and along the wall.
    change: [f64; 2],
}

const FIT: Fit = Fit {
    ridge: 0.0116,
    depth: 0.6,
    sum: 1.01,
    change: [-0.05, 0.04],
};

/// Distance of the middle of the box from the wall, in cell widths.
const ADVANCE: f64 = 0.5;

/// Cells of the box along an axis.
const CELLS: usize = 3;

/// Largest sum of the magnitudes of the weights: where other walls leave few cells, larger weights would need too
/// much mass.
const MOST_WEIGHT: f64 = 3.0;

/// A plane wave and its mirror image before a rigid wall.
struct Wave {
    /// Wave numbers along the normal and along the wall in radians per cell.
    numbers: [f64; 2],
    /// Target of the weighted sum of its pressure.
    target: f64,
}

/// A cell of the box: distance from the wall, place along the wall from the middle of the surface (cell widths), open
/// area.
struct BoxCell {
    cell: [usize; 2],
    distance: f64,
    along: f64,
    area: f64,
}

/// Weights before slanted walls for one scheme at one Courant number.
pub(super) struct SlantedKernel {
    polynomial: Polynomial,
    /// Whether the stencil reaches adjacent rows only.
    narrow: bool,
}

impl SlantedKernel {
    /// For a scheme.
    pub(super) fn new(polynomial: &Polynomial) -> Self {
        Self {
            polynomial: *polynomial,
            narrow: polynomial.square == 0.0,
        }
    }

    /// Weights of the cells before a surface element. With the weights of a `column`, all of its cells and no other
    /// rows take part.
    pub(super) fn at(&self, walls: &WallCells, load: &Load, column: Option<&Reach>) -> Reach {
        let places = self.box_cells(walls, load, column);
        let waves = self.waves(load.normal);
        let mut ridge = FIT.ridge;
        loop {
            let weights = fit(&places, &waves, ridge);
            let most: f64 = weights.iter().map(|weight| weight.abs()).sum();
            if most <= MOST_WEIGHT || ridge > 1e3 {
                let cells = places.iter().map(|place| place.cell);
                return cells.zip(weights).collect();
            }
            ridge *= 4.0;
        }
    }

    /// The cells of the box that are connected with the surface through open faces.
    fn box_cells(&self, walls: &WallCells, load: &Load, column: Option<&Reach>) -> Vec<BoxCell> {
        let size = [CELLS, if self.narrow { 2 } else { CELLS }];
        let [nx, ny] = load.normal;
        let tangent = [ny, -nx];
        let middle = middle(load);
        // From the centre of the surface's cell to the middle of the surface.
        let foot: [f64; 2] =
            [0, 1].map(|axis| middle * tangent[axis] - load.distance * load.normal[axis]);
        let rows = column.map_or([0, 0], |column| {
            let rows = column
                .keys()
                .map(|[_, y]| *y as isize - load.cell[1] as isize);
            [rows.clone().min(), rows.max()].map(Option::unwrap_or_default)
        });
        let first: [isize; 2] = [0, 1].map(|axis| {
            let at = 0.5 + foot[axis] + ADVANCE * load.normal[axis];
            let cells = size[axis];
            let first = (at - 0.5 * (cells as f64 - 1.0) + 1e-9).floor() as isize;
            // The box always holds the surface's own cell, or all rows of the column.
            let [low, high] = if axis == 1 { rows } else { [0, 0] };
            first.clamp(low.min(high + 1 - cells as isize), low)
        });
        let within = |cell: [usize; 2]| {
            [0, 1].into_iter().all(|axis| {
                let offset = cell[axis] as isize - load.cell[axis] as isize - first[axis];
                (0..size[axis] as isize).contains(&offset)
            })
        };
        let mut cells: Vec<[usize; 2]> = match column {
            Some(column) => column.keys().copied().collect(),
            None => vec![load.cell],
        };
        let mut next = 0;
        while next < cells.len() {
            for (axis, side) in [(0, -1), (0, 1), (1, -1), (1, 1)] {
                let beside = walls.beside(cells[next], axis, side);
                if let Some(cell) = beside.filter(|cell| within(*cell) && !cells.contains(cell)) {
                    cells.push(cell);
                }
            }
            next += 1;
        }
        let place = |cell: [usize; 2]| {
            let offset = [0, 1].map(|axis| cell[axis] as f64 - load.cell[axis] as f64);
            let dot = |to: [f64; 2]| offset[0] * to[0] + offset[1] * to[1];
            let cut = walls.cut_cell(cell[0] as isize, cell[1] as isize);
            BoxCell {
                cell,
                distance: load.distance + dot(load.normal),
                along: dot(tangent) - middle,
                area: cut.map_or(1.0, |cut| cut.area),
            }
        };
        cells.into_iter().map(place).collect()
    }

    /// The waves of the fit, before a wall of the given normal.
    fn waves(&self, [nx, ny]: [f64; 2]) -> Vec<Wave> {
        let p = &self.polynomial;
        let edge = BAND_EDGE * if self.narrow { 0.5 } else { 1.0 };
        let mut waves = Vec::new();
        for k in (1..=4).map(|i| edge * f64::from(i) / 4.0) {
            let half = 0.5 * p.courant * k;
            let (sin, cos) = half.sin_cos();
            for cosine in COSINES {
                let sine = (1.0 - cosine * cosine).sqrt();
                for side in [1.0, -1.0]
                    .into_iter()
                    .take(if sine == 0.0 { 1 } else { 2 })
                {
                    let along = side * k * sine;
                    let mut across = k * cosine;
                    let mut slope = 1.0;
                    for _ in 0..8 {
                        let number = [across * nx + along * ny, across * ny - along * nx];
                        let [a, b] = number.map(|k| 4.0 * (0.5 * k).sin().powi(2));
                        let [by_a, by_b] = p.symbol_slopes(a, b);
                        slope = 2.0 * (by_a * number[0].sin() * nx + by_b * number[1].sin() * ny);
                        across -= (p.symbol(a, b) - 4.0 * sin * sin) / slope;
                    }
                    // The derivative of the symbol is `4 sin cos` times the group velocity.
                    let transported = slope / (4.0 * sin * cos * p.courant * cosine);
                    let squares = [across, along].map(|k| k * k);
                    let change = FIT.change[0] * squares[0] + FIT.change[1] * squares[1];
                    waves.push(Wave {
                        numbers: [across, along],
                        target: cos * transported.max(0.0).sqrt() * (FIT.sum + change),
                    });
                }
            }
        }
        waves
    }
}

/// Place of the middle of a surface element along it, from the foot of the perpendicular through the centre of its
/// cell.
fn middle(load: &Load) -> f64 {
    let [nx, ny] = load.normal;
    let mut range = [f64::NEG_INFINITY, f64::INFINITY];
    for (tangent, normal) in [(ny, nx), (-nx, ny)] {
        if tangent != 0.0 {
            let ends = [-0.5, 0.5].map(|rim| (rim + load.distance * normal) / tangent);
            range = [
                range[0].max(ends[0].min(ends[1])),
                range[1].min(ends[0].max(ends[1])),
            ];
        }
    }
    if range[0] < range[1] {
        0.5 * (range[0] + range[1])
    } else {
        0.0
    }
}

/// Weights of places with the sum of the fit and the least squares over waves, with `ridge` as in [`Fit`].
fn fit(places: &[BoxCell], waves: &[Wave], ridge: f64) -> Vec<f64> {
    let n = places.len();
    // Normal equations, with the sum as a constraint.
    let mut rows = vec![vec![0.0; n + 2]; n + 1];
    let per = 1.0
        / waves
            .iter()
            .map(|wave| if wave.numbers[1] > 0.0 { 2.0 } else { 1.0 })
            .sum::<f64>();
    for wave in waves {
        let [across, along] = wave.numbers;
        let mut add = |parts: Vec<f64>, target: f64| {
            for (row, part) in rows.iter_mut().zip(&parts) {
                for (value, other) in row.iter_mut().zip(&parts) {
                    *value += per * part * other;
                }
                row[n + 1] += per * part * target;
            }
        };
        let even = |place: &BoxCell| (across * place.distance).cos() * (along * place.along).cos();
        add(places.iter().map(even).collect(), wave.target);
        if along > 0.0 {
            let odd =
                |place: &BoxCell| (across * place.distance).cos() * (along * place.along).sin();
            add(places.iter().map(odd).collect(), 0.0);
        }
    }
    for (i, place) in places.iter().enumerate() {
        let far = (place.distance.max(0.0) / FIT.depth).powi(4);
        rows[i][i] += ridge * ridge * (1.0 + far) / place.area;
        rows[i][n] = 1.0;
        rows[n][i] = 1.0;
    }
    rows[n][n + 1] = FIT.sum;
    let mut weights = solve(rows);
    weights.truncate(n);
    weights
}
