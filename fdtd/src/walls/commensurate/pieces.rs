//! The pieces of surface of one period, and the search for their weights and masses.
//!
//! It makes the sum of the errors' eighth powers small: nearly the largest of them, but smooth.

use super::super::WallCells;
use super::super::aperture::BAND_EDGE;
use super::super::spring::{MARGIN, Piece, yielding};
use super::search::least_squares;
use super::strip::{Incidence, Member, Strip, Tap};
use crate::scheme::Polynomial;
use std::ops::Range;

/// Wave numbers over that of the band's edge, cosines of the angles (0 to 70 degrees), and impedances over that of air of the search.
const BAND: [f64; 3] = [5.0 / 11.0, 10.0 / 11.0, 1.0];
const COSINES: [f64; 6] = [1.0, 0.966, 0.866, 0.707, 0.5, 0.342];
const RATIOS: [f64; 5] = [0.05, 0.2, 1.0, 5.0, 20.0];

/// Error of the reflection factor that counts for one.
const ERROR: f64 = 0.02;

/// Change of a weight that counts for one: it keeps weights that hardly matter where they were.
const CHANGE: f64 = 2.0;

/// Periods to each side whose pieces a piece shares air with.
const SHARING: isize = 6;

/// Cells by their offset from the piece's, with their weights, and the mass in cell widths.
pub(super) type Taps = (Vec<([isize; 2], f64)>, f64);

/// One period's pieces, as functions of their weights, piece by piece, and then of their masses.
pub(super) struct Pieces {
    courant: f64,
    taps: Vec<Vec<Tap>>,
    /// The taps' cells by their offset from the pieces'.
    offsets: Vec<Vec<[isize; 2]>>,
    /// Length over the area of the taps' cells.
    gains: Vec<Vec<f64>>,
    /// Places of the pieces' weights among the variables.
    ranges: Vec<Range<usize>>,
    /// For each piece: others that share its air, their lengths, and what the air yields between the taps of both.
    springs: Vec<Vec<Spring>>,
    incidences: Vec<Incidence>,
    /// Weights and masses at the start, and as found.
    start: Vec<f64>,
    found: Vec<f64>,
}

/// The air between two pieces.
struct Spring {
    other: usize,
    length: f64,
    /// `[own tap, other's tap]`.
    yields: Vec<Vec<f64>>,
}

impl Pieces {
    /// Pieces with their masses, from which the search starts.
    pub(super) fn new(
        walls: &WallCells,
        strip: &Strip,
        polynomial: &Polynomial,
        start: &[(&Piece, f64)],
    ) -> Self {
        let mut near: Vec<[isize; 2]> = Vec::new();
        let mut pieces = Self {
            courant: polynomial.courant,
            taps: Vec::new(),
            offsets: Vec::new(),
            gains: Vec::new(),
            ranges: Vec::new(),
            springs: Vec::new(),
            incidences: Vec::new(),
            start: Vec::new(),
            found: Vec::new(),
        };
        for (piece, _) in start {
            let tap = |cell: &[usize; 2]| {
                let (home, periods) = strip.home(cell.map(|at| at as isize));
                let known = near.iter().position(|cell| *cell == home);
                let cell = known.unwrap_or_else(|| {
                    near.push(home);
                    near.len() - 1
                });
                Tap { cell, periods }
            };
            pieces.taps.push(piece.reach.keys().map(tap).collect());
            let offset = |cell: &[usize; 2]| {
                [0, 1].map(|axis| cell[axis] as isize - piece.cell[axis] as isize)
            };
            pieces
                .offsets
                .push(piece.reach.keys().map(offset).collect());
            let gain = |[ix, iy]: &[usize; 2]| {
                let opening = walls.opening(*ix as isize, *iy as isize);
                piece.length / opening.map_or(1.0, |opening| opening.area)
            };
            pieces.gains.push(piece.reach.keys().map(gain).collect());
            let first = pieces.start.len();
            pieces.start.extend(piece.reach.values());
            pieces.ranges.push(first..pieces.start.len());
        }
        pieces.start.extend(start.iter().map(|(_, mass)| mass));
        pieces.found.clone_from(&pieces.start);
        pieces.springs = start
            .iter()
            .map(|(piece, _)| springs(walls, strip, polynomial, piece, start))
            .collect();
        let edge = BAND_EDGE * if polynomial.square == 0.0 { 0.5 } else { 1.0 };
        for (part, cosine) in BAND
            .into_iter()
            .flat_map(|part| COSINES.map(|cosine| (part, cosine)))
        {
            for side in [1.0, -1.0]
                .into_iter()
                .take(if cosine < 1.0 { 2 } else { 1 })
            {
                pieces
                    .incidences
                    .push(strip.incidence(&near, part * edge, cosine, side));
            }
        }
        pieces
    }

    /// Whether the pieces take part in the same cells.
    pub(super) fn has_cells_of(&self, other: &Self) -> bool {
        self.offsets == other.offsets
    }

    /// Weights and masses with small errors, after some rounds of search from where the last ones ended.
    pub(super) fn search(&mut self, rounds: usize) {
        self.found = least_squares(self.found.clone(), rounds, |x| self.residuals(x));
    }

    /// What is left of what the search makes small.
    pub(super) fn loss(&self) -> f64 {
        let residuals = self.residuals(&self.found);
        residuals.iter().map(|value| value * value).sum()
    }

    /// The largest error.
    #[cfg(test)]
    pub(super) fn worst(&self) -> f64 {
        let errors = self.residuals(&self.found).split_off(self.found.len());
        ERROR * errors.into_iter().fold(0.0, f64::max).powf(0.25)
    }

    /// What was found: each piece's cells by their offset from its own, with their weights, and its mass in cell widths.
    pub(super) fn found(&self) -> Vec<Taps> {
        let piece = |(index, range): (usize, &Range<usize>)| {
            let taps = self.offsets[index].iter().copied();
            let weights = self.found[range.clone()].iter().copied();
            (taps.zip(weights).collect(), self.mass(index, &self.found))
        };
        self.ranges.iter().enumerate().map(piece).collect()
    }

    /// Mass of a piece: its variable, or what passivity asks for where that is more ([`super::super::spring`]).
    fn mass(&self, index: usize, x: &[f64]) -> f64 {
        let weights = &x[self.ranges[index].clone()];
        let shared = |spring: &Spring| {
            let others = &x[self.ranges[spring.other].clone()];
            let rows = weights.iter().zip(&spring.yields);
            let with: f64 = rows
                .map(|(weight, row)| {
                    let felt: f64 = row.iter().zip(others).map(|(a, b)| a * b).sum();
                    weight * felt
                })
                .sum();
            spring.length * with.abs()
        };
        let least: f64 = self.springs[index].iter().map(shared).sum();
        let own = x[x.len() - self.ranges.len() + index];
        own.max(MARGIN * MARGIN * least)
    }

    /// What the search makes small: the changes of the variables, and the squares of all errors.
    fn residuals(&self, x: &[f64]) -> Vec<f64> {
        let member = |index: usize| Member {
            taps: &self.taps[index],
            weights: &x[self.ranges[index].clone()],
            gains: &self.gains[index],
            mass: self.mass(index, x),
        };
        let members: Vec<Member<'_>> = (0..self.ranges.len()).map(member).collect();
        let changes = x.iter().zip(&self.start);
        let mut values: Vec<f64> = changes.map(|(x, start)| (x - start) / CHANGE).collect();
        for incidence in &self.incidences {
            incidence.errors(self.courant, &members, &RATIOS, |error| {
                values.push((error.norm_sqr() / (ERROR * ERROR)).powi(2));
            });
        }
        values
    }
}

/// The air between a piece and all that are near it.
fn springs(
    walls: &WallCells,
    strip: &Strip,
    polynomial: &Polynomial,
    piece: &Piece,
    all: &[(&Piece, f64)],
) -> Vec<Spring> {
    let fields: Vec<_> = (piece.reach.keys())
        .map(|cell| yielding(walls, polynomial, *cell))
        .collect();
    let [px, py] = strip.period();
    let others = (-SHARING..=SHARING)
        .flat_map(|periods| all.iter().enumerate().map(move |all| (periods, all)));
    others
        .map(|(periods, (other, (piece, _)))| {
            let cell =
                |[x, y]: &[usize; 2]| [*x as isize + periods * px, *y as isize + periods * py];
            let row = |field: &dyn Fn([isize; 2]) -> f64| {
                piece.reach.keys().map(cell).map(field).collect()
            };
            Spring {
                other,
                length: piece.length,
                yields: fields.iter().map(|field| row(field)).collect(),
            }
        })
        .collect()
}
