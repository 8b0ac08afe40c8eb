//! Which inertances and stiffnesses make the walls of branches that are asked for.
//!
//! *The step* has a tangent in place of its phase ([`super::branches`]), which makes l too large and sigma too small by a third of `(omega dt/2)^2`,
//! 2.3 % at 10 kHz on the papers' grid: by Foster's theorem no passive reactance in its place follows omega itself. *The surface* has a conductance y
//! and a reactance X that are nearly 1 and 0 ([`super::aperture`]); where a wall is a reactance itself, what is left of both adds to the step's error
//! instead of standing across it. So l and sigma of all branches are changed by a few percent. The reflection factor is then off, in first order, by
//!
//! `2 [cos sum_k (z/z_k)^2 dz_k + i X - z cos (y - 1)]/(z cos + 1)^2`
//!
//! with the changes `dz_k` of the branches: linear in what is looked for. The sum of its eighth powers is made least, as the surface's own weights
//! are found, over angles and octaves of frequency up to the edge of the aperture's band: nearly the largest error, so that at finer steps, where a
//! branch matters at small
//! `omega dt` only, all factors go to 1.

use super::aperture::COSINES;
use super::impedance::Branch;
use super::linear::solve;
use rustfft::num_complex::Complex;

/// A branch over the air's impedance and the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reduced {
    /// r.
    pub(super) resistance: f64,
    /// l.
    pub(super) inertia: f64,
    /// sigma.
    pub(super) spring: f64,
}

impl Reduced {
    fn new(branch: &Branch, characteristic_pasm: f64, dt_s: f64) -> Self {
        Self {
            resistance: branch.resistance_pasm / characteristic_pasm,
            inertia: branch.inertance_kgpm2 / (characteristic_pasm * dt_s),
            spring: branch.stiffness_papm * dt_s / characteristic_pasm,
        }
    }

    /// Impedance over that of the air at half a step's phase, or, in steps, at its tangent.
    fn at(&self, x: f64) -> Complex<f64> {
        let reactance = 2.0 * x * self.inertia - self.spring / (2.0 * x);
        Complex::new(self.resistance, reactance)
    }
}

/// What surfaces leave of their errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Remainder {
    /// Half a step's phase at the edge of the band.
    pub(super) edge: f64,
    /// By how much y falls short of 1, and X, at the quarters of the band (rows) and the cosines of [`COSINES`].
    pub(super) left: [[[f64; 2]; 4]; 4],
}

impl Remainder {
    /// Nothing, in a band up to half a step's phase `edge`.
    pub(super) fn none(edge: f64) -> Self {
        Self {
            edge,
            left: [[[0.0; 2]; 4]; 4],
        }
    }

    /// At half a step's phase and one of the cosines, between its entries and nothing at 0.
    fn at(&self, phase: f64, cosine: usize) -> [f64; 2] {
        let quarters = (4.0 * phase / self.edge).clamp(0.0, 4.0);
        let high = (quarters.ceil() as usize).max(1);
        let entry = |quarter: usize| match quarter.checked_sub(1) {
            Some(row) => self.left[row][cosine],
            None => [0.0; 2],
        };
        let part = quarters - (high - 1) as f64;
        [0, 1].map(|i| (1.0 - part) * entry(high - 1)[i] + part * entry(high)[i])
    }
}

/// What l and sigma may be changed to: a resonance anywhere in the band asks for 0.93 and 0.97, a compliance alone for 1.03.
const LEAST: f64 = 0.9;
const MOST: f64 = 1.07;

/// Frequencies of the fit, in octaves below the band's edge.
const OCTAVES: i32 = 8;
const PER_OCTAVE: i32 = 5;

/// Rounds of Newton's method, each of which leaves six sevenths of the way.
const ROUNDS: usize = 30;

/// What keeps factors at 1 that nothing depends on.
const RIDGE: f64 = 1e-6;

/// The branches for steps of `dt_s` in air of `rho c` in Pa s/m, before surfaces that leave `remainder`.
pub(super) fn reduce(
    branches: &[Branch],
    characteristic_pasm: f64,
    dt_s: f64,
    remainder: &Remainder,
) -> Vec<Reduced> {
    let mut reduced: Vec<Reduced> = branches
        .iter()
        .map(|branch| Reduced::new(branch, characteristic_pasm, dt_s))
        .collect();
    let changes = least(&errors(&reduced, remainder), 2 * reduced.len());
    for (branch, change) in reduced.iter_mut().zip(changes.chunks_exact(2)) {
        branch.inertia *= (1.0 + change[0]).clamp(LEAST, MOST);
        branch.spring *= (1.0 + change[1]).clamp(LEAST, MOST);
    }
    reduced
}

/// Half the error of the reflection factor at one frequency and angle, and what changes of l and sigma of each branch, as parts of them, add to it.
struct Line {
    error: Complex<f64>,
    by: Vec<Complex<f64>>,
}

impl Line {
    fn with(&self, changes: &[f64]) -> Complex<f64> {
        let added = self.by.iter().zip(changes).map(|(by, change)| by * change);
        self.error + added.sum::<Complex<f64>>()
    }
}

fn errors(branches: &[Reduced], remainder: &Remainder) -> Vec<Line> {
    let edge = remainder.edge;
    let octaves = (0..=OCTAVES * PER_OCTAVE).map(|i| -f64::from(i) / f64::from(PER_OCTAVE));
    let mut phases: Vec<f64> = octaves.map(|octave| edge * octave.exp2()).collect();
    // A resonance may lie between, and be all that there is.
    let resonances = branches
        .iter()
        .map(|branch| 0.5 * (branch.spring / branch.inertia).sqrt());
    phases.extend(resonances.filter(|&phase| phase > 0.0 && phase < edge));
    let mut lines = Vec::new();
    for phase in phases {
        let tangent = phase.tan();
        // Far beyond all that tells, and finite where a branch resonates without loss.
        let admittances: Vec<Complex<f64>> = branches
            .iter()
            .map(|branch| (branch.at(phase) + 1e-9).inv())
            .collect();
        let admittance: Complex<f64> = admittances.iter().sum();
        for (i, cosine) in COSINES.into_iter().enumerate() {
            let [short, reactance] = remainder.at(phase, i);
            let below = (admittance + cosine).powi(2);
            let surface = Complex::i() * reactance * admittance + cosine * short;
            let mut line = Line {
                error: surface * admittance / below,
                by: Vec::new(),
            };
            for (branch, own) in branches.iter().zip(&admittances) {
                let gain = Complex::i() * cosine * own * own / below;
                line.error += gain * (branch.at(tangent).im - branch.at(phase).im);
                line.by.push(gain * 2.0 * tangent * branch.inertia);
                line.by.push(-gain * branch.spring / (2.0 * tangent));
            }
            lines.push(line);
        }
    }
    lines
}

/// The changes, so many, with the least sum of the errors' eighth powers: least squares with weights of the sixth powers, again and again.
fn least(lines: &[Line], count: usize) -> Vec<f64> {
    let mut changes = vec![0.0; count];
    for round in 0..ROUNDS {
        let squares: Vec<f64> = lines
            .iter()
            .map(|line| line.with(&changes).norm_sqr())
            .collect();
        let largest = squares.iter().copied().fold(0.0, f64::max);
        if largest == 0.0 {
            break;
        }
        let weight = |square: f64| match round {
            0 => 1.0,
            _ => (square / largest).powi(3),
        };
        let mut rows = vec![vec![0.0; count + 1]; count];
        let mut total = 0.0;
        for (line, &square) in lines.iter().zip(&squares) {
            let weight = weight(square);
            total += weight;
            for (row, one) in rows.iter_mut().zip(&line.by) {
                for (value, other) in row.iter_mut().zip(&line.by) {
                    *value += weight * (one.conj() * other).re;
                }
                row[count] -= weight * (one.conj() * line.error).re;
            }
        }
        for (i, row) in rows.iter_mut().enumerate() {
            row[i] += RIDGE * total;
        }
        let step = if round == 0 { 1.0 } else { 1.0 / 7.0 };
        for (change, found) in changes.iter_mut().zip(solve(rows)) {
            *change += step * (found - *change);
        }
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::Scheme;
    use crate::validation::branches::walls;
    use crate::walls::Impedance;
    use crate::walls::aperture::{Apertures, BAND_EDGE};
    use crate::walls::half_line::Place;
    use std::f64::consts::PI;

    const COURANT: f64 = 340.0 / 120_000.0 / 0.005;
    const AIR_PASM: f64 = 1.293 * 340.0;
    const DT_S: f64 = 1.0 / 120_000.0;

    /// Error of the reflection factor at a frequency and a cosine of the angle before a surface that leaves `[1 - y, X]`, by the formula of
    /// [`crate::walls::aperture`].
    fn error(wall: &Impedance, reduced: &[Reduced], hz: f64, cos: f64, off: [f64; 2]) -> f64 {
        let taken: Complex<f64> = reduced
            .iter()
            .map(|branch| branch.at((PI * hz * DT_S).tan()).inv())
            .sum();
        let [z, wanted] = [taken.inv(), wall.at(hz) / AIR_PASM].map(|z| z * cos);
        let (y, x) = (1.0 - off[0], Complex::new(0.0, off[1]));
        ((z - y + x) / (z + y + x) - (wanted - 1.0) / (wanted + 1.0)).norm()
    }

    /// Largest from 1 to 10 kHz and to 73 degrees; `surface` gives what is left for a wave number (radians per cell) and a cosine.
    fn largest(
        wall: &Impedance,
        reduced: &[Reduced],
        surface: impl Fn(f64, f64) -> [f64; 2],
    ) -> f64 {
        let mut most = 0.0_f64;
        for khz in 1..=10 {
            let hz = 1e3 * f64::from(khz);
            for cos in [1.0, 0.87, 0.6, 0.29] {
                let off = surface(2.0 * PI * hz / 340.0 * 0.005, cos);
                most = most.max(error(wall, reduced, hz, cos, off));
            }
        }
        most
    }

    fn none() -> Remainder {
        Remainder::none(0.5 * COURANT * BAND_EDGE)
    }

    #[test]
    fn the_fit_leaves_little_of_the_tangent() {
        for (name, wall) in walls().into_iter().skip(1) {
            let branches = wall.branches();
            let plain: Vec<Reduced> = branches
                .iter()
                .map(|branch| Reduced::new(branch, AIR_PASM, DT_S))
                .collect();
            let [found, plain] = [reduce(&branches, AIR_PASM, DT_S, &none()), plain]
                .map(|reduced| largest(&wall, &reduced, |_, _| [0.0; 2]));
            println!("{name}: {found:.4}, without the fit {plain:.4}");
            assert!(
                found < 0.014 && plain > 1.4 * found,
                "{name}: {found}, {plain}"
            );
        }
    }

    #[test]
    fn before_surfaces_all_walls_reflect_within_a_fiftieth() {
        for scheme in [Scheme::M13, Scheme::O13, Scheme::D25] {
            let polynomial = scheme.polynomial(COURANT);
            let apertures = Apertures::new(&polynomial);
            for open in [1.0, 0.6, 0.2] {
                let surface = |k: f64, cos: f64| {
                    Place::new(&polynomial, open, k, cos).off(COURANT, &apertures.at(open, 1.0))
                };
                for (name, wall) in walls() {
                    let [found, apart] = [*apertures.remainder(open).1, none()].map(|remainder| {
                        let reduced = reduce(&wall.branches(), AIR_PASM, DT_S, &remainder);
                        largest(&wall, &reduced, surface)
                    });
                    println!(
                        "{scheme}, {open}, {name}: {found:.4}, fitted without the surface {apart:.4}"
                    );
                    assert!(found < 0.02, "{scheme}, {open}, {name}: {found}");
                }
            }
        }
    }

    #[test]
    fn finer_steps_leave_inertance_and_stiffness_as_they_are() {
        let panel = [Branch::resonance(4e3, 0.2 * AIR_PASM, AIR_PASM)];
        let changes = [1.0, 4.0, 16.0].map(|parts| {
            let dt_s = DT_S / parts;
            let reduced = reduce(&panel, AIR_PASM, dt_s, &none())[0];
            1.0 - reduced.inertia / Reduced::new(&panel[0], AIR_PASM, dt_s).inertia
        });
        println!("{changes:?}");
        assert!(changes[0] < 0.03, "{changes:?}");
        assert!(changes[1] < changes[0] / 2.0 && changes[2] < changes[1] / 2.0);
    }
}
