//! Walls of an impedance: what their surfaces do to the field.
//!
//! A piece of surface of length l and impedance Z has one velocity v into it, half a step before and after the pressure. With a mass m of
//! air before it, `z = Z/(rho c)`, and the pressure at the surface as a mean with weights f of cells before it ([`super::aperture`] before walls along the
//! axes, [`super::footprint`] before others),
//!
//! `(m/chi)(v+ - v-) + z (v+ + v-)/2 = f.p`, and every cell's pressure loses `chi l f_i/V_i (v+ - v-)`.
//!
//! Where z is made of branches ([`super::branches`]) it stands for a function of `t = (zeta - 1)/(zeta + 1)` for what goes with `zeta^n`:
//! `r + 2 l t + sigma/(2 t)` of each, in parallel. `i omega dt` is `2 t`, nearly.
//!
//! *Passive for every Z.* Let a mode grow, |zeta| > 1: the real part of t is then positive, and so is, or is 0, that of z and of 1/z. The field's
//! equation times the mode's conjugate, in the inner product of the areas V, with s > 0 of the operator and `k = chi l |f.p|^2`, `M = m/chi` for each surface
//! (`<p, p> = 1`), is
//!
//! `t (4 - s - sum k/M) + s/t + sum k [1/(2 M^2/z + M/t) + 2/(2 M t + z)] = 0`.
//!
//! The brackets are sums of inverses of what has positive real parts, and have them too. So has all of the rest while `s + sum k/M <= 4`: then no
//! mode grows. Branches ask for no other mass than a real impedance does. What the operator leaves of 4 is known as a form whatever the walls' shape
//! ([`Polynomial::slack`]), and [`super::spring`] gives each surface the mass that keeps the sum within it: slanted, at corners and ends, face to
//! face.

use super::WallCells;
use super::aperture::{Aperture, Apertures};
use super::branches::Branches;
use super::commensurate::{self, RowsOf};
use super::fit::{Reduced, Remainder, reduce};
use super::footprint::{ADVANCE, Footprints};
use super::impedance::Impedance;
use super::inertance::slanted_masses;
use super::openings::Load;
use super::spring::{Piece, least_masses};
use crate::scheme::Polynomial;
use std::collections::BTreeMap;

/// A surface that is not rigid, as one row of the grid sees it: who writes a row keeps a velocity of its own for each surface that the row takes part in, the
/// same in all of them, so that no row waits for another.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// `(dy, ix, weight)`: row offset and column of cells, and what their pressure gives to the velocity (times `rho c`, in Pa), or to the pressure that
    /// branches feel.
    pub taps: Vec<(isize, usize, f32)>,
    /// `(ix, gain)`: cells of this row, and what the velocity's change takes from their pressure.
    pub gains: Vec<(usize, f32)>,
    /// What the velocity does.
    pub reaction: Reaction,
    /// Where its numbers begin in the field's memory.
    pub memory: usize,
}

/// What a surface's velocity does from step to step.
#[derive(Debug, Clone, PartialEq)]
pub enum Reaction {
    /// So much is left of it, beside what the taps give: resistance and mass.
    Decay(f32),
    /// It is that of several branches, or of one with a compliance; the taps give the pressure.
    Branches(Branches),
}

impl Surface {
    /// How many numbers of the field's memory are its own.
    pub fn memory_count(&self) -> usize {
        match &self.reaction {
            Reaction::Decay(_) => 1,
            Reaction::Branches(branches) => branches.memory(),
        }
    }
}

/// Cells beside a surface need so much of the air of the first cell to take part along it: small ones would ask for more mass than is there.
const LEAST_BESIDE: f64 = 0.5;

/// Cosine of the angle between a wall's normal and the axis up to which columns of cells serve it; beyond 18 degrees boxes do.
pub(super) const LEAST_SLOPE: f64 = 0.95;

/// The surfaces of `walls` by row for a stencil of a radius, for the Courant number of `polynomial`, steps of `dt_s` and the characteristic impedance
/// `rho c` of the air in Pa s/m, on a field whose operator has the rows of `rows_of`.
pub(super) fn surfaces(
    walls: &WallCells,
    rows_of: RowsOf<'_>,
    polynomial: &Polynomial,
    radius: usize,
    dt_s: f64,
    characteristic_pasm: f64,
) -> Vec<Vec<Surface>> {
    let mut rows = vec![Vec::new(); walls.size()[1]];
    if walls.loads().is_empty() {
        return rows;
    }
    let apertures = Apertures::new(polynomial);
    let footprints = Footprints::new(polynomial);
    let courant = polynomial.courant;
    let nothing = Remainder::none(apertures.edge());
    let mut pieces = Vec::with_capacity(walls.loads().len());
    // Mass before each piece, and what is left of its errors, by a number that tells it from others.
    let mut before = Vec::with_capacity(walls.loads().len());
    for load in walls.loads() {
        let reach = if load.nearest_axis().1 > LEAST_SLOPE {
            let column = Column::of(walls, load);
            let aperture = apertures.at(column.open, column.slope);
            let (place, remainder) = apertures.remainder(column.open);
            before.push((aperture.mass, (Some(place), remainder)));
            column.reach(walls, &aperture)
        } else {
            // Its mass is known when all have their cells.
            before.push((0.0, (None, &nothing)));
            footprints.at(walls, load, ADVANCE)
        };
        pieces.push(Piece {
            cell: load.cell,
            length: load.length,
            reach,
        });
    }
    let operator = rows_of(walls);
    for (index, mass) in slanted_masses(walls, &*operator, &pieces, |_| true) {
        before[index].0 = mass;
    }
    for better in commensurate::better(walls, rows_of, polynomial, &footprints) {
        before[better.index].0 = better.mass;
        pieces[better.index].reach = better.reach;
    }
    let least = least_masses(walls, polynomial, &pieces);
    let area = |[ix, iy]: [usize; 2]| {
        let opening = walls.opening(ix as isize, iy as isize);
        opening.map_or(1.0, |opening| opening.area)
    };
    // The pieces of a wall have one impedance.
    let mut known: Vec<(Fitted<'_>, Vec<Reduced>)> = Vec::new();
    let mut memory = 0;
    for (index, load) in walls.loads().iter().enumerate() {
        let reach = &pieces[index].reach;
        let (usual, (place, remainder)) = before[index];
        let mass = usual.max(least[index]) / courant;
        let key = (&load.impedance, place);
        let at = known.iter().position(|(of, _)| *of == key);
        let at = at.unwrap_or_else(|| {
            let branches = load.impedance.branches();
            let reduced = reduce(&branches, characteristic_pasm, dt_s, remainder);
            known.push((key, reduced));
            known.len() - 1
        });
        let branches = &known[at].1;
        let (divisor, reaction) = match branches[..] {
            // An inertance is more of the mass.
            [branch] if branch.spring == 0.0 => {
                let (mass, half) = (mass + branch.inertia, 0.5 * branch.resistance);
                let decay = (mass - half) / (mass + half);
                (mass + half, Reaction::Decay(decay as f32))
            }
            _ => (1.0, Reaction::Branches(Branches::new(mass, branches))),
        };
        let mut gains: BTreeMap<usize, Vec<(usize, f32)>> = BTreeMap::new();
        for (&[ix, iy], weight) in reach {
            let gain = courant * load.length * weight / area([ix, iy]);
            gains.entry(iy).or_default().push((ix, gain as f32));
        }
        for (iy, gains) in gains {
            let tap = |(&[ix, y], weight): (&[usize; 2], &f64)| {
                let dy = y as isize - iy as isize;
                // The fast engine has no other rows at hand.
                assert!(dy.unsigned_abs() <= radius, "a surface beyond the stencil");
                (dy, ix, (weight / divisor) as f32)
            };
            let surface = Surface {
                taps: reach.iter().map(tap).collect(),
                gains,
                reaction: reaction.clone(),
                memory,
            };
            memory += surface.memory_count();
            rows[iy].push(surface);
        }
    }
    rows
}

/// What branches are fitted to: the impedance, and the place of the wall where columns of cells serve it.
type Fitted<'a> = (&'a Impedance, Option<usize>);

/// Weights of cells by column and row.
pub(super) type Reach = BTreeMap<[usize; 2], f64>;

/// The cells before a surface along the axis nearest to its normal.
struct Column {
    /// First cell that holds air.
    first: [usize; 2],
    axis: usize,
    /// Way from the wall into the air along the axis, 1 or -1.
    inward: isize,
    /// Cosine of the angle between axis and normal.
    slope: f64,
    /// Open part of the first cell, along the axis through its middle.
    open: f64,
}

impl Column {
    fn of(walls: &WallCells, load: &Load) -> Self {
        let (axis, slope) = load.nearest_axis();
        let inward = if load.normal[axis] > 0.0 { 1 } else { -1 };
        let [nx, ny] = walls.size();
        let air = |[x, y]: [isize; 2]| {
            let inside = x >= 0 && y >= 0 && (x as usize) < nx && (y as usize) < ny;
            inside && walls.opening(x, y).is_some()
        };
        let own = load.cell.map(|at| at as isize);
        let mut place = own;
        let mut open = 0.5 + load.distance / slope;
        // The cell that holds the wall where the line through the cells' middles meets it.
        if open > 1.0 {
            let mut outward = place;
            outward[axis] -= inward;
            if air(outward) {
                (place, open) = (outward, open - 1.0);
            }
        }
        if open <= 0.0 {
            place[axis] += inward;
            open += 1.0;
        }
        let place = if air(place) { place } else { own };
        Self {
            first: place.map(|at| at as usize),
            axis,
            inward,
            slope,
            open: open.clamp(0.0, 1.0),
        }
    }

    /// The cells that the surface samples and takes its flow from. Where another wall comes between, fewer.
    fn reach(&self, walls: &WallCells, aperture: &Aperture) -> Reach {
        let mut cells = vec![self.first];
        while let Some(next) = (cells.len() < 3)
            .then(|| walls.beside(cells[cells.len() - 1], self.axis, self.inward))
            .flatten()
        {
            cells.push(next);
        }
        let mut weights = aperture.weights;
        // What cells that are not there should have done is left to the last one that is.
        for missing in (cells.len()..3).rev() {
            weights[missing - 1] += weights[missing];
        }
        let mut reach: Reach = cells.iter().copied().zip(weights).collect();
        let area = |[ix, iy]: [usize; 2]| {
            let opening = walls.opening(ix as isize, iy as isize);
            opening.map_or(0.0, |opening| opening.area)
        };
        for side in [-1, 1] {
            if let Some(cell) = walls.beside(self.first, 1 - self.axis, side)
                && area(cell) >= LEAST_BESIDE * area(self.first)
            {
                *reach.entry(self.first).or_default() -= aperture.along;
                *reach.entry(cell).or_default() += aperture.along;
            }
        }
        reach.retain(|_, weight| *weight != 0.0);
        reach
    }
}
