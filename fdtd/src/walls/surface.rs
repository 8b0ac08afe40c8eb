//! Walls of an impedance: what their surfaces do to the field.
//!
//! A piece of surface of length l and impedance Z has one velocity v into it, half a step before and after the pressure. With a mass m of
//! air before it, `z = Z/(rho c)`, and the pressure at the surface as a mean with weights f of cells before it ([`super::aperture`]),
//!
//! `(m/chi)(v+ - v-) + z (v+ + v-)/2 = f.p`, and every cell's pressure loses `chi l f_i/V_i (v+ - v-)`.
//!
//! *Passive for every Z.* Let a mode grow, with `zeta^n`, |zeta| > 1, and take `t = (zeta - 1)/(zeta + 1)`, whose real part is then positive. The field's
//! equation times the mode's conjugate, in the inner product of the areas V, with s > 0 of the operator and `k = chi l |f.p|^2`, `M = m/chi` for each surface
//! (`<p, p> = 1`), is
//!
//! `t (4 - s - sum k/M) + s/t + sum k [z/(2 M^2) + (2 - z^2/(2 M^2))/(2 M t + z)] = 0`.
//!
//! The brackets have positive real parts, as `|2 M t + z| > z`. So has all of the rest while `s + sum k/M <= 4`: then no mode grows. What the operator leaves of 4
//! is [`Polynomial::spare`] (times `chi^2`), in every cell in proportion to its area. Each cell shares it out among the surfaces that it takes part in by `l |f|`, and by
//! Cauchy's inequality a mass of at least `sum |f_i| L_i/(spare V_i)`, `L_i` being the sum of `l |f_i|` over the surfaces, keeps within it, whatever the walls'
//! shape: slanted, at corners and ends, face to face.

use super::WallCells;
use super::aperture::{Aperture, Apertures};
use super::openings::Load;
use crate::scheme::Polynomial;
use std::collections::BTreeMap;

/// A surface that is not rigid, as one row of the grid sees it: who writes a row keeps a velocity of its own for each surface that the row takes part in, the
/// same in all of them, so that no row waits for another.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// `(dy, ix, weight)`: row offset and column of cells, and what their pressure gives to the velocity (times `rho c`, in Pa).
    pub taps: Vec<(isize, usize, f32)>,
    /// `(ix, gain)`: cells of this row, and what the velocity's change takes from their pressure.
    pub gains: Vec<(usize, f32)>,
    /// What is left of the velocity from step to step.
    pub decay: f32,
    /// Place of the velocity in the field's memory.
    pub memory: usize,
}

/// Cells beside a surface need so much of the air of the first cell to take part along it: small ones would ask for more mass than is there.
const LEAST_BESIDE: f64 = 0.5;

/// The surfaces of `walls` by row for a stencil of a radius, for the Courant number of `polynomial` and the characteristic impedance `rho c` of the air in Pa s/m.
pub(super) fn surfaces(
    walls: &WallCells,
    polynomial: &Polynomial,
    radius: usize,
    characteristic_pasm: f64,
) -> Vec<Vec<Surface>> {
    let mut rows = vec![Vec::new(); walls.size()[1]];
    if walls.loads().is_empty() {
        return rows;
    }
    let apertures = Apertures::new(polynomial);
    let courant = polynomial.courant;
    let spare = polynomial.spare().max(1e-6);
    let reaches: Vec<(Reach, f64)> = walls
        .loads()
        .iter()
        .map(|load| {
            let aperture = apertures.at(load.open, load.slope);
            (reach(walls, load, &aperture), aperture.mass)
        })
        .collect();
    let mut shared: BTreeMap<[usize; 2], f64> = BTreeMap::new();
    for (load, (reach, _)) in walls.loads().iter().zip(&reaches) {
        for (&cell, weight) in reach {
            *shared.entry(cell).or_default() += load.length * weight.abs();
        }
    }
    let area = |[ix, iy]: [usize; 2]| {
        let opening = walls.opening(ix as isize, iy as isize);
        opening.map_or(1.0, |opening| opening.area)
    };
    let mut memory = 0;
    for (load, (reach, usual)) in walls.loads().iter().zip(&reaches) {
        let asked = |(cell, weight): (&[usize; 2], &f64)| {
            weight.abs() * shared[cell] / (spare * area(*cell))
        };
        let mass = usual.max(reach.iter().map(asked).sum()) / courant;
        let half = 0.5 * load.impedance_pasm / characteristic_pasm;
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
                (dy, ix, (weight / (mass + half)) as f32)
            };
            rows[iy].push(Surface {
                taps: reach.iter().map(tap).collect(),
                gains,
                decay: ((mass - half) / (mass + half)) as f32,
                memory,
            });
            memory += 1;
        }
    }
    rows
}

/// Weights of cells by column and row.
type Reach = BTreeMap<[usize; 2], f64>;

/// The cells that a surface samples and takes its flow from. Where another wall comes between, fewer.
fn reach(walls: &WallCells, load: &Load, aperture: &Aperture) -> Reach {
    let mut cells = vec![load.cell];
    while let Some(next) = (cells.len() < 3)
        .then(|| beside(walls, cells[cells.len() - 1], load.axis, load.inward))
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
        if let Some(cell) = beside(walls, load.cell, 1 - load.axis, side)
            && area(cell) >= LEAST_BESIDE * area(load.cell)
        {
            *reach.entry(load.cell).or_default() -= aperture.along;
            *reach.entry(cell).or_default() += aperture.along;
        }
    }
    reach.retain(|_, weight| *weight != 0.0);
    reach
}

/// The cell beside another along an axis, when the face between them is open.
fn beside(walls: &WallCells, [ix, iy]: [usize; 2], axis: usize, side: isize) -> Option<[usize; 2]> {
    let [nx, ny] = walls.size();
    let mut place = [ix as isize, iy as isize];
    place[axis] += side;
    let [x, y] = place;
    let inside = x >= 0 && y >= 0 && (x as usize) < nx && (y as usize) < ny;
    let there = walls.opening(x, y).filter(|_| inside)?;
    let upper = if side > 0 {
        there
    } else {
        walls.opening(ix as isize, iy as isize)?
    };
    let face = if axis == 0 { upper.west } else { upper.south };
    (face > 0.0).then_some([x as usize, y as usize])
}
