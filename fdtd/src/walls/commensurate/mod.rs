//! Weights and masses before walls of a simple slope.
//!
//! A wall whose slope is a ratio of small whole numbers cuts the cells in the same few ways along its whole length. What it reflects is then known
//! exactly ([`strip`]), as it is before walls along the axes, and weights and masses can be searched for as there ([`super::aperture`]): all pieces of
//! a period together, so that the eighth powers of the errors are least, from what [`super::footprint`] and [`super::inertance`] give. Along other walls the
//! pieces differ from place to place, and those two have the last word; so they have at ends and corners.

mod pieces;
mod search;
mod strip;
#[cfg(test)]
mod tests;

use self::pieces::{Pieces, Taps};
use self::strip::Strip;
use super::footprint::{FRAME, Footprints, Frame};
use super::inertance::{Row, slanted_masses};
use super::openings::Load;
use super::spring::Piece;
use super::surface::{LEAST_SLOPE, Reach};
use super::{Impedance, Wall, WallCells, cut};
use crate::grid::Grid;
use crate::scheme::Polynomial;
use rayon::prelude::*;
use std::cell::OnceCell;
use std::sync::{Arc, Mutex, PoisonError};

/// Largest number in the ratio of a simple slope.
const MOST: isize = 3;

/// How far the slope of a wall may be off, in radians; and its place in the cells, in cell widths, which on a wall of some hundred cells that is less.
const SLOPE_OFF: f64 = 1e-4;
const PLACE_OFF: f64 = 5e-3;

/// Rounds of the search from each start, and more from the best of them.
const FIRST_ROUNDS: usize = 25;
const ROUNDS: usize = 40;

/// How far before the wall the boxes' middles may lie, in cell widths: the search has one minimum for each, and some are bad.
const ADVANCES: [f64; 6] = [0.2, 0.5, 0.8, 1.0, 1.2, 1.5];

/// What may be left of what is made small: one error of 0.027, or more and smaller ones.
const ENOUGH: f64 = 10.0;

/// Around so many cells to each side walls must be as those of the endless wall.
const ALIKE: isize = 3;

/// So deep in a wall, in cell widths, it may be otherwise.
const BEHIND: f64 = 1.5;

/// Cells to each side of the middle of the grid on which the endless wall is laid out.
const HALF: usize = 26;

/// What to put in place of a piece's reach and mass.
pub(super) struct Better {
    /// Number of the piece.
    pub(super) index: usize,
    pub(super) reach: Reach,
    /// Mass in cell widths.
    pub(super) mass: f64,
}

/// What makes the operator's rows of some walls, over the Courant number squared.
pub(super) type RowsOf<'a> = &'a dyn Fn(&WallCells) -> Box<dyn Fn([usize; 2]) -> Row>;

/// Better reaches and masses for those pieces of slanted surface that lie along a wall of a simple slope, away from its ends and from other walls.
pub(super) fn better(
    walls: &WallCells,
    rows_of: RowsOf<'_>,
    polynomial: &Polynomial,
    footprints: &Footprints,
) -> Vec<Better> {
    let mut known: Vec<Endless> = Vec::new();
    let mut found = Vec::new();
    for (index, load) in walls.loads().iter().enumerate() {
        let Some(period) = period(load.normal).filter(|_| load.nearest_axis().1 <= LEAST_SLOPE)
        else {
            continue;
        };
        let place = |wall: &Endless| {
            let place = wall.place(load);
            place.filter(|&place| wall.is_alike(walls, load, place))
        };
        let at = known.iter().position(|wall| place(wall).is_some());
        let at = at.unwrap_or_else(|| {
            known.push(Endless::new(load, period));
            known.len() - 1
        });
        let wall = &known[at];
        found.extend(place(wall).and_then(|place| {
            let solution = wall.solution(rows_of, polynomial, footprints);
            let (taps, mass) = solution.get(place)?;
            let cell = |axis: usize, offset: isize| load.cell[axis].checked_add_signed(offset);
            let reach = taps
                .iter()
                .map(|&([dx, dy], weight)| Some(([cell(0, dx)?, cell(1, dy)?], weight)));
            Some(Better {
                index,
                reach: reach.collect::<Option<Reach>>()?,
                mass: *mass,
            })
        }));
    }
    found
}

/// The step along a wall with a normal after which it repeats, if its slope is a simple one.
fn period([nx, ny]: [f64; 2]) -> Option<[isize; 2]> {
    let steps = (1..=MOST).flat_map(|x| (-MOST..=MOST).map(move |y| [x, y]));
    let off = |[x, y]: [isize; 2]| (x as f64 * nx + y as f64 * ny).abs();
    let steps = steps.filter(|&[x, y]| off([x, y]) < SLOPE_OFF * (x as f64).hypot(y as f64));
    steps.min_by_key(|[x, y]| x * x + y * y)
}

/// A wall without end, of one slope and one place in the cells.
struct Endless {
    walls: WallCells,
    normal: [f64; 2],
    period: [isize; 2],
    /// Distance of the middle cell's middle from the wall.
    distance: f64,
    /// Places of one period's pieces in the list of the wall's.
    pieces: Vec<usize>,
    /// Their cells by offset with weights, and their masses in cell widths, once they are asked for.
    solution: OnceCell<Arc<Vec<Taps>>>,
}

impl Endless {
    /// The wall to which a piece of surface would belong.
    fn new(load: &Load, period: [isize; 2]) -> Self {
        let walls = half_plane(load.normal, load.distance);
        let dot = |[x, y]: [isize; 2]| x * period[0] + y * period[1];
        let own = |load: &Load| {
            let offset = load.cell.map(|at| at as isize - HALF as isize);
            (0..dot(period)).contains(&dot(offset))
        };
        let pieces = walls.loads().iter().enumerate();
        Self {
            pieces: pieces
                .filter_map(|(index, load)| own(load).then_some(index))
                .collect(),
            normal: load.normal,
            period,
            distance: load.distance,
            walls,
            solution: OnceCell::new(),
        }
    }

    /// Which of the period's pieces another piece of surface is, if it is one.
    fn place(&self, load: &Load) -> Option<usize> {
        let off = |axis: usize| (self.normal[axis] - load.normal[axis]).abs();
        let mut pieces = self.pieces.iter();
        let own = |&index: &usize| (self.walls.loads()[index].distance - load.distance).abs();
        (off(0).max(off(1)) < SLOPE_OFF)
            .then(|| pieces.position(|index| own(index) < PLACE_OFF))
            .flatten()
    }

    /// Whether `walls` are, around a piece, as this wall is around the piece of that place.
    fn is_alike(&self, walls: &WallCells, load: &Load, place: usize) -> bool {
        let [nx, ny] = self.normal;
        let own = &self.walls.loads()[self.pieces[place]];
        let opening = |walls: &WallCells, [x, y]: [usize; 2], dx: isize, dy: isize| {
            walls.opening(x as isize + dx, y as isize + dy)
        };
        let alike = |dx: isize, dy: isize| {
            let here = opening(walls, load.cell, dx, dy);
            let there = opening(&self.walls, own.cell, dx, dy);
            match (here, there) {
                // What lies behind the wall does not matter.
                _ if own.distance + dx as f64 * nx + dy as f64 * ny < -BEHIND => true,
                (None, None) => true,
                (Some(here), Some(there)) => {
                    let off = (here.area - there.area).abs();
                    let faces = (here.west - there.west).abs() + (here.south - there.south).abs();
                    off + faces < 4.0 * PLACE_OFF
                }
                _ => false,
            }
        };
        let around = -ALIKE..=ALIKE;
        let mut rows = around.clone();
        rows.all(|dy| around.clone().all(|dx| alike(dx, dy)))
    }

    /// The period's pieces with weights and masses as other walls have them, but of other boxes.
    fn start(
        &self,
        rows: &dyn Fn([usize; 2]) -> Row,
        polynomial: &Polynomial,
        footprints: &Footprints,
        frame: Frame,
    ) -> Pieces {
        let walls = &self.walls;
        let wall = (self.normal, self.distance);
        let strip = Strip::new(
            walls,
            rows,
            polynomial,
            wall,
            self.period,
            [HALF as isize; 2],
        );
        let piece = |load: &Load| Piece {
            cell: load.cell,
            length: load.length,
            reach: footprints.at(walls, load, frame, None),
        };
        let all: Vec<Piece> = walls.loads().iter().map(piece).collect();
        let own = |index: usize| self.pieces.contains(&index);
        let masses = slanted_masses(walls, rows, &all, own);
        let start: Vec<(&Piece, f64)> = (masses.iter())
            .map(|&(index, mass)| (&all[index], mass))
            .collect();
        Pieces::new(walls, &strip, polynomial, &start)
    }

    /// Weights and masses of the period's pieces.
    fn solution(
        &self,
        rows_of: RowsOf<'_>,
        polynomial: &Polynomial,
        footprints: &Footprints,
    ) -> &[Taps] {
        self.solution.get_or_init(|| {
            let key = (*polynomial, self.normal, self.distance);
            if let Some(known) = recalled(&key) {
                return known;
            }
            let rows = rows_of(&self.walls);
            let search = |cells: usize| {
                let frames = ADVANCES.map(|advance| Frame { advance, cells });
                let start = |frame| self.start(&*rows, polynomial, footprints, frame);
                best(frames.map(start).into())
            };
            let mut found = search(FRAME.cells);
            // Rows of the widest stencil reach one cell more.
            if polynomial.cube != 0.0 && found.loss() > ENOUGH {
                let wider = search(FRAME.cells + 1);
                if wider.loss() < found.loss() {
                    found = wider;
                }
            }
            let found = Arc::new(found.found());
            remember(key, Arc::clone(&found));
            found
        })
    }
}

/// What a solution depends on: the scheme at its Courant number, and the wall's normal and place.
type Key = (Polynomial, [f64; 2], f64);

/// Solutions of this process: a sweep over impedances asks for the same ones again and again, and each takes as long as a small simulation.
static SOLUTIONS: Mutex<Vec<(Key, Arc<Vec<Taps>>)>> = Mutex::new(Vec::new());

/// How many solutions are kept.
const KEPT: usize = 1000;

/// The solution of a key, if it is known. Nobody waits for another who is at it: it may be the same thread, further up.
fn recalled(key: &Key) -> Option<Arc<Vec<Taps>>> {
    let known = SOLUTIONS.lock().unwrap_or_else(PoisonError::into_inner);
    let same = known.iter().find(|(other, _)| other == key);
    same.map(|(_, solution)| Arc::clone(solution))
}

/// Keeps a solution, and forgets all others when they are too many.
fn remember(key: Key, solution: Arc<Vec<Taps>>) {
    let mut known = SOLUTIONS.lock().unwrap_or_else(PoisonError::into_inner);
    if known.len() >= KEPT {
        known.clear();
    }
    known.push((key, solution));
}

/// What is found from the best of some starts.
fn best(mut starts: Vec<Pieces>) -> Pieces {
    starts.dedup_by(|one, other| one.has_cells_of(other));
    starts
        .par_iter_mut()
        .for_each(|pieces| pieces.search(FIRST_ROUNDS));
    starts.sort_by(|a, b| a.loss().total_cmp(&b.loss()));
    let mut best = starts.swap_remove(0);
    best.search(ROUNDS);
    best
}

/// The wall beyond a line whose normal points into the air, on a grid whose middle cell has its middle at `distance` from it.
fn half_plane([nx, ny]: [f64; 2], distance: f64) -> WallCells {
    let cells = 2 * HALF + 1;
    let grid = Grid {
        nx: cells,
        ny: cells,
        dx_m: 1.0,
        dt_s: 1.0,
    };
    let size = cells as f64;
    let middle = HALF as f64 + 0.5;
    let behind = distance + size;
    let end = |along: f64| {
        [
            middle - behind * nx + along * ny,
            middle - behind * ny - along * nx,
        ]
    };
    let wall = Wall {
        points_m: vec![end(-2.0 * size), end(2.0 * size)],
        thickness_m: 2.0 * size,
        // Whichever: it is not rigid.
        impedance: Some(Impedance::Real(1.0)),
    };
    cut(&grid, &[wall])
}
