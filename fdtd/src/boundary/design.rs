//! All surfaces of a grid, from the surface elements of its walls.
//!
//! A surface element of length l and impedance Z has one velocity v into it, half a step before and after the
//! pressure. With a mass m of air before it, `z = Z/(rho c)`, and the pressure at the surface as a weighted sum with
//! weights f of cells before it ([`super::axis_kernel`] before walls along the axes, [`super::slanted_kernel`] before
//! others),
//!
//! `(m/chi)(v+ - v-) + z (v+ + v-)/2 = f.p`, and the pressure of every cell decreases by `chi l f_i/V_i (v+ - v-)`.
//!
//! With branches ([`super::branches`]) z is a function of `t = (zeta - 1)/(zeta + 1)` for solutions proportional to
//! `zeta^n`: `r + 2 l t + sigma/(2 t)` of each, in parallel; `i omega dt` is nearly `2 t`.
//!
//! *Passive for every Z.* Let a mode grow, |zeta| > 1: then t has a positive real part, and z and 1/z a real part of
//! 0 or more. The equation of the field times the conjugate of the mode, in the inner product of the areas V, with
//! `<p, p> = 1`, s > 0 of the operator and `k = chi l |f.p|^2`, `M = m/chi` of each surface, is
//!
//! `t (4 - s - sum k/M) + s/t + sum k [1/(2 M^2/z + M/t) + 2/(2 M t + z)] = 0`.
//!
//! The brackets are sums of inverses of numbers with positive real parts, and have positive real parts too. So has
//! the rest while `s + sum k/M <= 4`: then no mode grows. Branches need no more mass than a real impedance. The
//! difference of the operator to 4 is known as a form for any shape of the walls ([`Polynomial::slack`]), and
//! [`super::passivity`] gives each surface the mass that keeps the sum within it: on slanted walls, at corners and
//! ends, face to face.

use super::added_mass::{column_mass, slanted_masses};
use super::axis_kernel::AxisKernel;
use super::branches::{Branches, Reduced};
use super::column::Column;
use super::passivity::least_masses;
use super::slanted_kernel::SlantedKernel;
use super::surface::{Reaction, Surface, Surfaces};
use super::surface_element::{Reach, SurfaceElement};
use crate::grid::{Grid, Medium};
use crate::scheme::Scheme;
use crate::walls::operator::WallOperator;
use crate::walls::slant::share;
use crate::walls::{Load, WallCells};
use std::collections::BTreeMap;

/// The surfaces of walls of an impedance, by row of `grid`, for a field in `medium` with `scheme` whose rigid
/// operator is `operator`. None, at no cost, when all walls are rigid.
pub fn surfaces(
    walls: &WallCells,
    operator: &WallOperator,
    grid: &Grid,
    medium: &Medium,
    scheme: Scheme,
) -> Surfaces {
    if walls.loads().is_empty() {
        return Surfaces::default();
    }
    let mut rows = vec![Vec::new(); walls.size()[1]];
    let courant = grid.courant(medium);
    let (polynomial, weights) = (&scheme.polynomial(courant), &scheme.weights(courant));
    let (radius, dt_s) = (scheme.radius(), grid.dt_s);
    let characteristic_pasm = medium.rho_kgpm3 * medium.c_mps;
    let (axis, slanted) = (AxisKernel::new(polynomial), SlantedKernel::new(polynomial));
    let (mut elements, mut masses) = (Vec::new(), Vec::new());
    for load in walls.loads() {
        let design = Design::of(walls, load, &axis, &slanted);
        masses.push(design.mass);
        elements.push(SurfaceElement {
            cell: load.cell,
            length: load.length,
            reach: design.reach,
        });
    }
    let operator_rows = operator.rows(walls, weights, polynomial, radius);
    for (index, mass) in slanted_masses(walls, &operator_rows, &elements) {
        let share = share(walls.loads()[index].nearest_axis().1);
        masses[index] += share * (mass - masses[index]);
    }
    let least = least_masses(walls, polynomial, &elements);
    let area = |[ix, iy]: [usize; 2]| {
        let cut = walls.cut_cell(ix as isize, iy as isize);
        cut.map_or(1.0, |cut| cut.area)
    };
    let mut memory = 0;
    for (index, load) in walls.loads().iter().enumerate() {
        let reach = &elements[index].reach;
        let mass = masses[index].max(least[index]) / courant;
        let branches = load.impedance.branches();
        let branches: Vec<Reduced> = (branches.iter())
            .map(|branch| Reduced::new(branch, characteristic_pasm, dt_s))
            .collect();
        let (divisor, reaction) = match branches[..] {
            // An inertance adds to the mass.
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
                // The fast engine reads no rows beyond the stencil.
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
    Surfaces::new(rows)
}

/// Weights of a surface element by the slope of its wall.
struct Design {
    reach: Reach,
    /// Mass in cell widths before a column of cells, if one takes part.
    mass: f64,
}

impl Design {
    fn of(walls: &WallCells, load: &Load, axis: &AxisKernel, slanted: &SlantedKernel) -> Self {
        let share = share(load.nearest_axis().1);
        if share == 1.0 {
            return Self {
                reach: slanted.at(walls, load, None),
                mass: 0.0,
            };
        }
        let column = Column::of(walls, load);
        let weights = axis.at(column.open, column.slope);
        let reach = column.reach(walls, &weights);
        if share == 0.0 {
            return Self {
                reach,
                mass: column_mass(load, weights.mass),
            };
        }
        // Blended, as the changes of the operator at slanted walls are.
        let mut mixed = slanted.at(walls, load, Some(&reach));
        mixed.values_mut().for_each(|weight| *weight *= share);
        for (cell, weight) in reach {
            *mixed.entry(cell).or_default() += (1.0 - share) * weight;
        }
        Self {
            reach: mixed,
            mass: column_mass(load, weights.mass),
        }
    }
}
