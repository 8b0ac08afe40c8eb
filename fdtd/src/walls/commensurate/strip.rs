//! One period of a wall that repeats along itself, and the plane waves before it.
//!
//! A wave along the wall changes by a phase from period to period, so the cells of one period are all the unknowns there are: those up to [`DEPTH`]
//! before the wall, and the reflection factor of the waves beyond, which are the lattice's own. Pieces of surface change this system in as many
//! columns as there are pieces, so it is solved once, rigid, for each frequency and angle; what any weights and masses of the pieces reflect follows
//! from a few numbers (Woodbury's formula).

use super::super::WallCells;
use super::super::inertance::Row;
use super::search::solve_complex;
use crate::scheme::Polynomial;
use rustfft::num_complex::Complex;
use std::collections::BTreeMap;

/// Distance from the wall in cell widths from which on there is nothing but the plane waves: what else a wall makes falls by four from cell to cell.
const DEPTH: f64 = 11.0;

/// The cells of one period.
pub(super) struct Strip {
    /// Unit vector from the wall into the air.
    normal: [f64; 2],
    /// Step along the wall in cells after which it repeats.
    period: [isize; 2],
    /// The cell from which periods are counted, and the distance of its middle from the wall.
    origin: [isize; 2],
    distance: f64,
    /// The unknown cells by place.
    cells: BTreeMap<[isize; 2], usize>,
    /// For each of them and for one beyond: rows of the operator over the Courant number squared.
    rows: Vec<([isize; 2], Row)>,
    polynomial: Polynomial,
}

/// A cell in which a piece of surface takes part: its number in [`Strip::near`], and how many periods away.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tap {
    pub(super) cell: usize,
    pub(super) periods: i32,
}

/// A plane wave that meets the wall, and what the rigid wall answers.
pub(super) struct Incidence {
    /// Cosine of the angle of incidence.
    pub(super) cosine: f64,
    /// `2 sin(omega dt/2)` and `cos(omega dt/2)`.
    sine: f64,
    mean: f64,
    /// Phase from period to period.
    phase: Complex<f64>,
    /// Pressure of the near cells before the rigid wall.
    free: Vec<Complex<f64>>,
    /// What a flow of one out of a near cell makes of the pressure in the others, and of the reflection factor.
    response: Vec<Vec<Complex<f64>>>,
    reflected: Vec<Complex<f64>>,
    /// Reflection factor of the rigid wall.
    rigid: Complex<f64>,
}

/// A piece of surface of one period, as the waves see it.
pub(super) struct Member<'a> {
    pub(super) taps: &'a [Tap],
    pub(super) weights: &'a [f64],
    /// `length / area` of the taps' cells.
    pub(super) gains: &'a [f64],
    /// Mass in cell widths.
    pub(super) mass: f64,
}

impl Strip {
    /// The period of a straight wall, on a field whose operator has `rows`, that begins with the cell `origin`: the wall by its normal and its
    /// distance from that cell's middle.
    pub(super) fn new(
        walls: &WallCells,
        rows: &dyn Fn([usize; 2]) -> Row,
        polynomial: &Polynomial,
        (normal, distance): ([f64; 2], f64),
        period: [isize; 2],
        origin: [isize; 2],
    ) -> Self {
        let mut strip = Self {
            normal,
            period,
            origin,
            distance,
            cells: BTreeMap::new(),
            rows: Vec::new(),
            polynomial: *polynomial,
        };
        let reach = DEPTH as isize + 6;
        let mut beyond: Option<[isize; 2]> = None;
        for x in origin[0] - reach..=origin[0] + reach {
            for y in origin[1] - reach..=origin[1] + reach {
                let cell = [x, y];
                if strip.home(cell) != (cell, 0) || walls.opening(x, y).is_none() {
                    continue;
                }
                if strip.depth(cell) <= DEPTH {
                    // In the order of the map, as the rows are.
                    let count = strip.cells.len();
                    strip.cells.insert(cell, count);
                } else if beyond.is_none_or(|other| strip.depth(cell) < strip.depth(other)) {
                    beyond = Some(cell);
                }
            }
        }
        let of = |cell: [isize; 2]| (cell, rows(cell.map(|at| at as usize)));
        strip.rows = strip.cells.keys().copied().chain(beyond).map(of).collect();
        strip
    }

    /// Step along the wall after which it repeats.
    pub(super) fn period(&self) -> [isize; 2] {
        self.period
    }

    /// The cell of the period that stands for another, and how many periods they are apart.
    pub(super) fn home(&self, cell: [isize; 2]) -> ([isize; 2], i32) {
        let dot = |to: [isize; 2]| to[0] * self.period[0] + to[1] * self.period[1];
        let offset = [0, 1].map(|axis| cell[axis] - self.origin[axis]);
        let periods = dot(offset).div_euclid(dot(self.period));
        let home = [0, 1].map(|axis| cell[axis] - periods * self.period[axis]);
        (home, periods as i32)
    }

    /// Distance of a cell's middle from the wall.
    fn depth(&self, cell: [isize; 2]) -> f64 {
        let part = |axis: usize| (cell[axis] - self.origin[axis]) as f64 * self.normal[axis];
        self.distance + part(0) + part(1)
    }

    /// Place of a cell's middle along the wall.
    fn along(&self, cell: [isize; 2]) -> f64 {
        let [nx, ny] = self.normal;
        let [x, y] = [0, 1].map(|axis| (cell[axis] - self.origin[axis]) as f64);
        x * ny - y * nx
    }

    /// Wave number along the normal of the lattice's wave with the wave number `along` the wall, near `guess`.
    fn across(&self, along: f64, sine: f64, guess: f64) -> f64 {
        let ([nx, ny], p) = (self.normal, &self.polynomial);
        let mut across = guess;
        for _ in 0..12 {
            let number = [across * nx + along * ny, across * ny - along * nx];
            let [a, b] = number.map(|k| 4.0 * (0.5 * k).sin().powi(2));
            let [by_a, by_b] = p.symbol_slopes(a, b);
            let slope = 2.0 * (by_a * number[0].sin() * nx + by_b * number[1].sin() * ny);
            across -= (p.symbol(a, b) - sine * sine) / slope;
        }
        across
    }

    /// The wave of the wave number k in radians per cell that comes in at an angle from one `side` (1 or -1), before the rigid wall. `near` are the
    /// cells in which surfaces take part.
    pub(super) fn incidence(
        &self,
        near: &[[isize; 2]],
        k: f64,
        cosine: f64,
        side: f64,
    ) -> Incidence {
        let half = 0.5 * self.polynomial.courant * k;
        let sine = 2.0 * half.sin();
        let along = side * k * (1.0 - cosine * cosine).sqrt();
        let outward = self.across(along, sine, k * cosine);
        let inward = self.across(along, sine, -k * cosine);
        let turned = |angle: f64| Complex::from_polar(1.0, -angle);
        let wave = |cell: [isize; 2], across: f64| {
            turned(across * self.depth(cell) + along * self.along(cell))
        };
        let phase =
            turned(along * self.along([0, 1].map(|axis| self.origin[axis] + self.period[axis])));
        let n = self.cells.len();
        let zero = Complex::new(0.0, 0.0);
        // Unknowns: the cells and the reflection factor. Right sides: the incoming wave, and a flow out of each near cell.
        let mut system = vec![vec![zero; n + 2 + near.len()]; n + 1];
        for (equation, (cell, row)) in system.iter_mut().zip(&self.rows) {
            for &([dx, dy], weight) in row {
                let other = [cell[0] + dx, cell[1] + dy];
                let weight = weight * self.polynomial.linear;
                let (home, periods) = self.home(other);
                match self.cells.get(&home) {
                    Some(&at) => equation[at] += phase.powi(periods) * weight,
                    None => {
                        equation[n] += wave(other, outward) * weight;
                        equation[n + 1] -= wave(other, inward) * weight;
                    }
                }
            }
            match self.cells.get(cell) {
                Some(&at) => equation[at] += sine * sine,
                None => {
                    equation[n] += wave(*cell, outward) * (sine * sine);
                    equation[n + 1] -= wave(*cell, inward) * (sine * sine);
                }
            }
        }
        for (column, cell) in near.iter().enumerate() {
            if let Some(&at) = self.cells.get(cell) {
                system[at][n + 2 + column] = Complex::new(1.0, 0.0);
            }
        }
        let solved = solve_complex(system);
        let places: Vec<usize> = near.iter().map(|cell| self.cells[cell]).collect();
        Incidence {
            cosine,
            sine,
            mean: half.cos(),
            phase,
            free: places.iter().map(|&at| solved[at][0]).collect(),
            response: places.iter().map(|&at| solved[at][1..].to_vec()).collect(),
            reflected: solved[n][1..].to_vec(),
            rigid: solved[n][0],
        }
    }
}

impl Incidence {
    /// By how much the reflection factor over that of the rigid wall misses `(z cos - 1)/(z cos + 1)`, for each of `ratios` z.
    pub(super) fn errors(
        &self,
        courant: f64,
        members: &[Member<'_>],
        ratios: &[f64],
        mut told: impl FnMut(Complex<f64>),
    ) {
        let i = Complex::new(0.0, 1.0);
        let n = members.len();
        let phases = |member: &Member<'_>| -> Vec<Complex<f64>> {
            let taps = member.taps.iter().zip(member.weights);
            taps.map(|(tap, weight)| self.phase.powi(tap.periods) * weight)
                .collect()
        };
        let sampled: Vec<Vec<Complex<f64>>> = members.iter().map(phases).collect();
        // What the velocity of one piece does to the samples of another and to the reflection factor.
        let mut coupled = vec![vec![Complex::new(0.0, 0.0); n + 1]; n];
        let mut reflected = vec![Complex::new(0.0, 0.0); n];
        for (column, member) in members.iter().enumerate() {
            let factor = i * self.sine * courant;
            for ((tap, sample), gain) in member.taps.iter().zip(&sampled[column]).zip(member.gains)
            {
                let flow = sample.conj() * factor * gain;
                reflected[column] += self.reflected[tap.cell] * flow;
                for (row, (other, samples)) in members.iter().zip(&sampled).enumerate() {
                    let felt: Complex<f64> = (other.taps.iter().zip(samples))
                        .map(|(to, sample)| sample * self.response[to.cell][tap.cell])
                        .sum();
                    coupled[row][column] += felt * flow;
                }
            }
        }
        for (row, (member, samples)) in members.iter().zip(&sampled).enumerate() {
            let taps = member.taps.iter().zip(samples);
            coupled[row][n] = taps.map(|(tap, sample)| sample * self.free[tap.cell]).sum();
        }
        for z in ratios {
            let mut system = coupled.clone();
            for (row, (values, member)) in system.iter_mut().zip(members).enumerate() {
                for value in &mut values[..n] {
                    *value = -*value;
                }
                values[row] += i * (member.mass / courant * self.sine) + z * self.mean;
            }
            let velocities = solve_complex(system);
            let change: Complex<f64> = (reflected.iter().zip(&velocities))
                .map(|(reflected, velocity)| reflected * velocity[0])
                .sum();
            let exact = (z * self.cosine - 1.0) / (z * self.cosine + 1.0);
            told((self.rigid + change) / self.rigid - exact);
        }
    }
}
