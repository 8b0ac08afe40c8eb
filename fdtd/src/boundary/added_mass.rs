//! Added mass: the mass of air before an element of slanted surface.
//!
//! For a flow that is uniform along the whole wall, the surface must add no reactance of its own to that of the air.
//! Let the pressure rise by one per cell width from the wall on, as before a soft wall at low frequencies. A surface
//! takes the velocity that this slope gives the air at its place if its mass in cell widths equals its sample of that
//! pressure, `f.p`. The pressure in the cells deviates from the slope, for the surfaces take their flow from cells at
//! some distance. It is computed in a window around each element with the operator of the field: all elements in the
//! window take their share of the flow, and on its rim, far from the surface (deviations fall to a quarter from cell
//! to cell), the pressure is the distance from the wall.
//!
//! Corrections for frequency and angle are in [`OF_BOXES`]; before columns of cells the mass is that of a wall along
//! the axes plus [`OF_COLUMNS`].

use super::linear::conjugate_gradients;
use super::surface_element::SurfaceElement;
use crate::walls::operator::Row;
use crate::walls::slant::LEAST_SLOPE;
use crate::walls::{Load, WallCells};
use std::collections::BTreeMap;

/// Half width of the part of the window in which the pressure is computed.
const REACH: isize = 6;
/// Width of the rim around it, the reach of the widest stencil.
const RIM: isize = 3;
const HALF: isize = REACH + RIM;
const WIDTH: usize = 2 * HALF as usize + 1;
/// Rounds of conjugate gradients.
const ROUNDS: usize = 40;

/// Correction of the mass in cell widths at two angles between normal and axis in degrees, interpolated between them
/// and constant beyond. Chosen for small errors of the reflection factor at 10 kHz (law
/// `tilted_impedance`).
type Changes = [(f64, f64); 2];

/// Correction before boxes of cells.
const OF_BOXES: Changes = [(20.0, 0.020), (45.0, -0.0095)];

/// Correction before columns of cells: a compromise between 10 kHz, where more would be better, and d25 at 5 kHz.
const OF_COLUMNS: Changes = [(10.0, 0.0), (18.0, 0.002)];

/// Range of masses in cell widths. Those of plane walls lie well within; near other walls the pressure may be
/// undetermined (in a pocket without connection to the rim), and the mass is clamped.
const RANGE: [f64; 2] = [0.1, 0.8];

/// Mass in cell widths of a surface before which a column of cells takes part, from that of an `upright` wall.
pub(super) fn column_mass(load: &Load, upright: f64) -> f64 {
    upright + change(load, OF_COLUMNS)
}

/// The correction for a surface.
fn change(load: &Load, [(first, from), (last, to)]: Changes) -> f64 {
    let angle_deg = load.nearest_axis().1.min(1.0).acos().to_degrees();
    from + ((angle_deg - first) / (last - first)).clamp(0.0, 1.0) * (to - from)
}

/// Masses in cell widths of those of the `elements` of surface before which boxes of cells take part, with their places
/// in the list, on the field whose operator has `rows`.
pub(super) fn slanted_masses(
    walls: &WallCells,
    rows: &dyn Fn([usize; 2]) -> Row,
    elements: &[SurfaceElement],
) -> Vec<(usize, f64)> {
    // Flow that surfaces take from cells, for a uniform flow of one.
    let mut taken: BTreeMap<[usize; 2], f64> = BTreeMap::new();
    for element in elements {
        let sum: f64 = element.reach.values().sum();
        for (&cell, weight) in &element.reach {
            *taken.entry(cell).or_default() += element.length * weight / sum;
        }
    }
    let mass = |(index, (load, element)): (usize, (&Load, &SurfaceElement))| {
        let pressure = Neighbourhood::new(walls, load, rows, &taken).pressure();
        let sampled = element.reach.iter().map(|(&cell, weight)| {
            let [x, y] = [0, 1].map(|axis| (cell[axis] + HALF as usize) - load.cell[axis]);
            weight * pressure[y * WIDTH + x]
        });
        let mass: f64 = sampled.sum();
        let [least, most] = RANGE;
        (index, mass.max(least).min(most) + change(load, OF_BOXES))
    };
    let slanted = walls.loads().iter().zip(elements).enumerate();
    slanted
        .filter(|(_, (load, _))| load.nearest_axis().1 <= LEAST_SLOPE)
        .map(mass)
        .collect()
}

/// A cell whose pressure is computed.
struct Free {
    /// Its place in the window.
    at: usize,
    /// Row of the operator times area: places in the window and weights.
    row: Vec<(usize, f64)>,
    /// Flow that surfaces take from it.
    taken: f64,
}

/// The cells around a surface element.
struct Neighbourhood {
    free: Vec<Free>,
    /// Pressure, initially the distance from the wall.
    pressure: Vec<f64>,
}

impl Neighbourhood {
    /// Around the cell of a surface element.
    fn new(
        walls: &WallCells,
        load: &Load,
        rows: &dyn Fn([usize; 2]) -> Row,
        taken: &BTreeMap<[usize; 2], f64>,
    ) -> Self {
        let [ix, iy] = load.cell.map(|at| at as isize);
        let mut window = Self {
            free: Vec::new(),
            pressure: vec![0.0; WIDTH * WIDTH],
        };
        let [nx, ny] = walls.size().map(|n| n as isize);
        for dy in -HALF..=HALF {
            for dx in -HALF..=HALF {
                let place = [ix + dx, iy + dy];
                let at = |[x, y]: [isize; 2]| ((y + HALF) as usize) * WIDTH + (x + HALF) as usize;
                let Some(cut) = walls.cut_cell(place[0], place[1]) else {
                    continue;
                };
                window.pressure[at([dx, dy])] =
                    load.distance + dx as f64 * load.normal[0] + dy as f64 * load.normal[1];
                let inside = (0..nx).contains(&place[0]) && (0..ny).contains(&place[1]);
                if inside && dx.abs().max(dy.abs()) <= REACH {
                    let cell = place.map(|at| at as usize);
                    let row = rows(cell).into_iter();
                    let row = row.map(|([x, y], weight)| (at([dx + x, dy + y]), weight * cut.area));
                    window.free.push(Free {
                        at: at([dx, dy]),
                        row: row.collect(),
                        taken: taken.get(&cell).copied().unwrap_or(0.0),
                    });
                }
            }
        }
        window
    }

    /// Flow out of each free cell.
    fn outflow(&self, pressure: &[f64]) -> Vec<f64> {
        let flow = |free: &Free| -> f64 {
            let parts = free.row.iter().map(|&(at, weight)| weight * pressure[at]);
            -parts.sum::<f64>()
        };
        self.free.iter().map(flow).collect()
    }

    /// The pressure at which the flow into every free cell is the flow taken from it.
    fn pressure(mut self) -> Vec<f64> {
        let flows = self.outflow(&self.pressure);
        let load: Vec<f64> = (flows.iter().zip(&self.free))
            .map(|(flow, free)| -flow - free.taken)
            .collect();
        let own = |free: &Free| -> f64 {
            let own = free.row.iter().filter(|(at, _)| *at == free.at);
            -own.map(|(_, weight)| weight).sum::<f64>()
        };
        let own: Vec<f64> = self.free.iter().map(own).collect();
        let form = |u: &[f64]| {
            let mut pressure = vec![0.0; WIDTH * WIDTH];
            for (free, u) in self.free.iter().zip(u) {
                pressure[free.at] = *u;
            }
            self.outflow(&pressure)
        };
        let change = conjugate_gradients(form, &own, &load, ROUNDS);
        for (free, change) in self.free.iter().zip(change) {
            self.pressure[free.at] += change;
        }
        self.pressure
    }
}
