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
use super::aperture::Apertures;
use super::branches::{Branches, Reduced};
use super::column::Column;
use super::footprint::Footprints;
use super::inertance::{Row, column_mass, slanted_masses};
use super::openings::Load;
use super::slant::share;
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

/// Cosine of the angle between a wall's normal and the axis up to which nothing but columns of cells serve it; beyond 18 degrees boxes come in.
pub(super) const LEAST_SLOPE: f64 = 0.95;

/// The surfaces of `walls` by row for a stencil of a radius, for the Courant number of `polynomial`, steps of `dt_s` and the characteristic impedance
/// `rho c` of the air in Pa s/m, on a field whose operator has these rows.
pub(super) fn surfaces(
    walls: &WallCells,
    operator_rows: &dyn Fn([usize; 2]) -> Row,
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
    let (mut pieces, mut before) = (Vec::new(), Vec::new());
    for load in walls.loads() {
        let usual = Usual::of(walls, load, &apertures, &footprints);
        before.push(usual.mass);
        pieces.push(Piece {
            cell: load.cell,
            length: load.length,
            reach: usual.reach,
        });
    }
    for (index, mass) in slanted_masses(walls, operator_rows, &pieces) {
        let share = share(walls.loads()[index].nearest_axis().1);
        before[index] += share * (mass - before[index]);
    }
    let least = least_masses(walls, polynomial, &pieces);
    let area = |[ix, iy]: [usize; 2]| {
        let opening = walls.opening(ix as isize, iy as isize);
        opening.map_or(1.0, |opening| opening.area)
    };
    let mut memory = 0;
    for (index, load) in walls.loads().iter().enumerate() {
        let reach = &pieces[index].reach;
        let mass = before[index].max(least[index]) / courant;
        let branches = load.impedance.branches();
        let branches: Vec<Reduced> = (branches.iter())
            .map(|branch| Reduced::new(branch, characteristic_pasm, dt_s))
            .collect();
        let (divisor, reaction) = match branches[..] {
            // An inertance is more of the mass.
            [branch] if branch.spring == 0.0 => {
                let (mass, half) = (mass + branch.inertia, 0.5 * branch.resistance);
                let decay = (mass - half) / (mass + half);
                (mass + half, Reaction::Decay(decay as f32))
            }
            _ => (1.0, Reaction::Branches(Branches::new(mass, &branches))),
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

/// A piece of surface as walls of its slope have it.
struct Usual {
    reach: Reach,
    /// Mass as before a column of cells, if one takes part.
    mass: f64,
}

impl Usual {
    fn of(walls: &WallCells, load: &Load, apertures: &Apertures, footprints: &Footprints) -> Self {
        let share = share(load.nearest_axis().1);
        if share == 1.0 {
            return Self {
                reach: footprints.at(walls, load, None),
                mass: 0.0,
            };
        }
        let column = Column::of(walls, load);
        let aperture = apertures.at(column.open, column.slope);
        let reach = column.reach(walls, &aperture);
        if share == 0.0 {
            return Self {
                reach,
                mass: column_mass(load, aperture.mass),
            };
        }
        // A part of both, as the operator has a part of what slanted walls ask for.
        let mut mixed = footprints.at(walls, load, Some(&reach));
        mixed.values_mut().for_each(|weight| *weight *= share);
        for (cell, weight) in reach {
            *mixed.entry(cell).or_default() += (1.0 - share) * weight;
        }
        Self {
            reach: mixed,
            mass: column_mass(load, aperture.mass),
        }
    }
}

/// Weights of cells by column and row.
pub(super) type Reach = BTreeMap<[usize; 2], f64>;
