//! Impedances by branches of resistance, inertance and compliance, in steps.
//!
//! A branch k has a velocity u (times `rho c`, in Pa) half a step before and after the pressure P at the surface, and a displacement `Q+ = Q + u+` (in steps)
//! at the times of P. With `r = R/(rho c)`, `l = L/(rho c dt)`, `sigma = s dt/(rho c)` and the mean of three displacements, `(Q+ + 2 Q + Q-)/4 = Q + (u+ - u-)/4`,
//!
//! `(l + sigma/4)(u+ - u-) + r (u+ + u-)/2 + sigma Q = P`, or, with `beta = 1/(l + sigma/4 + r/2)`, `u+ - u- = beta (P - r u- - sigma Q)`.
//!
//! That is the branch's impedance with `(2/dt) tan(omega dt/2)` in place of omega, times `cos(omega dt/2)`, which the weights before the surface make up
//! for ([`super::aperture`]): positive for every r, l and sigma of 0 or more, so that the surface is passive with the mass of air that it has anyway
//! ([`super::surface`]). All branches share this mass M, `P = T - M sum (u+ - u-)` with the sampled pressure T, and what they take together is known before each by itself:
//!
//! `u+ - u- = beta/(1 + M sum beta) (T + M sum e) - e`, with `e = beta (r u- + sigma Q)` of each branch.
//!
//! No coefficient is more than 4 or 1/M, whatever the branches are: rounding stays small where they differ by many decades. `beta sigma Q` is kept
//! in place of Q, which keeps still when there is no compliance; with one it is what restores, and cannot drift. Finite volumes
//! with such walls: Bilbao, Hamilton, Botts and Savioja 2016.
//!
//! *Tangent and frequency.* The tangent makes l too large and sigma too small by a third of `(omega dt/2)^2`, 2.3 % at 10 kHz on the papers' grid: by Foster's
//! theorem no passive reactance in its place follows omega itself. So l and sigma are changed by a few percent such that the reflection factor
//! at normal incidence has the least squared error up to the edge of the aperture's band. In first order it is changed by `2 dz |y/(1 + y_all)|^2` for the
//! change dz of one branch: a linear fit for each, of two numbers. It looks where the branch matters, which at finer steps is at small `omega dt`: there
//! both numbers go to 1.

use super::impedance::Branch;
use rustfft::num_complex::Complex;

/// Branches of a surface as steps take them.
#[derive(Debug, Clone, PartialEq)]
pub struct Branches {
    /// Mass M of air before the surface.
    mass: f32,
    parts: Vec<Part>,
}

/// Coefficients of a branch.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Part {
    /// `beta r`, 0 to 2.
    damping: f32,
    /// `beta sigma`, 0 to 4.
    spring: f32,
    /// `beta/(1 + M sum beta)`, at most `1/M`.
    flow: f32,
}

impl Branches {
    /// For a mass M of air before the surface.
    pub(super) fn new(mass: f64, branches: &[Reduced]) -> Self {
        let yields: Vec<f64> = branches
            .iter()
            .map(|branch| 1.0 / (branch.inertia + 0.25 * branch.spring + 0.5 * branch.resistance))
            .collect();
        let all = 1.0 + mass * yields.iter().sum::<f64>();
        let part = |(branch, beta): (&Reduced, &f64)| Part {
            damping: (beta * branch.resistance) as f32,
            spring: (beta * branch.spring) as f32,
            flow: (beta / all) as f32,
        };
        Self {
            mass: mass as f32,
            parts: branches.iter().zip(&yields).map(part).collect(),
        }
    }

    /// Numbers that the field keeps: velocity and spring, `e` without its resistance, of each branch, in Pa.
    pub(crate) fn memory(&self) -> usize {
        2 * self.parts.len()
    }

    /// One step with the pressure `sampled` before the surface in Pa: the velocity before it less that after it, of all branches.
    // Inlined: as a function of its own it would be compiled without fused multiply-adds.
    #[inline(always)]
    pub(crate) fn step(&self, sampled: f32, memory: &mut [f32]) -> f32 {
        let mut drive = sampled;
        for (part, state) in self.parts.iter().zip(memory.chunks_exact(2)) {
            drive = self
                .mass
                .mul_add(part.damping.mul_add(state[0], state[1]), drive);
        }
        let mut change = 0.0;
        for (part, state) in self.parts.iter().zip(memory.chunks_exact_mut(2)) {
            let back = part.damping.mul_add(state[0], state[1]);
            let gain = part.flow.mul_add(drive, -back);
            state[0] += gain;
            state[1] = part.spring.mul_add(state[0], state[1]);
            change -= gain;
        }
        change
    }
}

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

/// What l and sigma may be changed by: a resonance anywhere in the band asks for 0.92 and 0.97, a compliance alone for 1.03.
const LEAST: f64 = 0.9;
const MOST: f64 = 1.05;

/// Frequencies of the fit, in octaves below the band's edge.
const OCTAVES: f64 = 8.0;
const PER_OCTAVE: usize = 5;

/// The branches for steps of `dt_s` in air of `rho c` in Pa s/m, fitted to theirs up to `edge`, half a step's phase.
pub(super) fn reduce(
    branches: &[Branch],
    characteristic_pasm: f64,
    dt_s: f64,
    edge: f64,
) -> Vec<Reduced> {
    let plain: Vec<Reduced> = branches
        .iter()
        .map(|branch| Reduced::new(branch, characteristic_pasm, dt_s))
        .collect();
    (0..plain.len())
        .map(|own| fitted(&plain, own, edge))
        .collect()
}

impl Reduced {
    fn new(branch: &Branch, characteristic_pasm: f64, dt_s: f64) -> Self {
        Self {
            resistance: branch.resistance_pasm / characteristic_pasm,
            inertia: branch.inertance_kgpm2 / (characteristic_pasm * dt_s),
            spring: branch.stiffness_papm * dt_s / characteristic_pasm,
        }
    }

    /// Impedance over that of the air at half a step's phase x.
    fn at(&self, x: f64) -> Complex<f64> {
        let reactance = 2.0 * x * self.inertia - self.spring / (2.0 * x);
        Complex::new(self.resistance, reactance)
    }
}

/// A branch with l and sigma changed for the tangent.
fn fitted(branches: &[Reduced], own: usize, edge: f64) -> Reduced {
    let branch = branches[own];
    let steps = (OCTAVES * PER_OCTAVE as f64) as usize;
    let mut phases: Vec<f64> = (0..=steps)
        .map(|i| edge * (-(i as f64) / PER_OCTAVE as f64).exp2())
        .collect();
    // A resonance may lie between, and be all that there is.
    let resonance = 0.5 * (branch.spring / branch.inertia).sqrt();
    if resonance > 0.0 && resonance < edge {
        phases.push(resonance);
    }
    let mut fit = Fit::default();
    for x in phases {
        let others = branches.iter().enumerate().filter(|&(k, _)| k != own);
        // Far beyond all that tells, and finite where another branch resonates without loss.
        let taken: Complex<f64> = others.map(|(_, other)| (other.at(x) + 1e-9).inv()).sum();
        // The root is for octaves, in which the upper half of the band is one of eight.
        let weight = (x / edge).sqrt() / (branch.at(x) * (1.0 + taken) + 1.0).norm_sqr();
        fit.add(
            weight * 2.0 * x.tan() * branch.inertia,
            -weight * branch.spring / (2.0 * x.tan()),
            weight * branch.at(x).im,
        );
    }
    let [inertia, spring] = fit.factors();
    Reduced {
        inertia: inertia * branch.inertia,
        spring: spring * branch.spring,
        ..branch
    }
}

/// Least squares of `a A + b B - D` over frequencies: sums of products.
#[derive(Default)]
struct Fit {
    aa: f64,
    bb: f64,
    ab: f64,
    ad: f64,
    bd: f64,
}

impl Fit {
    fn add(&mut self, a: f64, b: f64, d: f64) {
        self.aa += a * a;
        self.bb += b * b;
        self.ab += a * b;
        self.ad += a * d;
        self.bd += b * d;
    }

    /// a and b, both from [`LEAST`] to [`MOST`]; 1 for what is not there.
    fn factors(&self) -> [f64; 2] {
        let over = |sum: f64, by: f64| {
            if by > 0.0 {
                (sum / by).clamp(LEAST, MOST)
            } else {
                1.0
            }
        };
        // For each end of a the best b, and the other way round; the best of all unless it lies outside.
        let mut tried: Vec<[f64; 2]> = [LEAST, MOST]
            .into_iter()
            .flat_map(|end| {
                [
                    [end, over(self.bd - self.ab * end, self.bb)],
                    [over(self.ad - self.ab * end, self.aa), end],
                ]
            })
            .collect();
        let det = self.aa * self.bb - self.ab * self.ab;
        if det > 1e-10 * self.aa * self.bb {
            let free = [
                (self.bb * self.ad - self.ab * self.bd) / det,
                (self.aa * self.bd - self.ab * self.ad) / det,
            ];
            if free.iter().all(|factor| (LEAST..=MOST).contains(factor)) {
                tried = vec![free];
            }
        }
        let loss = |&[a, b]: &[f64; 2]| {
            a * a * self.aa + b * b * self.bb + 2.0 * (a * b * self.ab - a * self.ad - b * self.bd)
        };
        tried
            .into_iter()
            .min_by(|one, other| loss(one).total_cmp(&loss(other)))
            .unwrap_or([1.0; 2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AIR_PASM: f64 = 440.0;
    const DT_S: f64 = 1.0 / 120_000.0;
    const EDGE: f64 = 0.288;

    /// Largest error of the reflection factor at normal incidence by the tangent alone, from 2 to 10 kHz.
    fn error(branches: &[Branch], reduced: &[Reduced]) -> f64 {
        let factor = |taken: Complex<f64>| (1.0 - taken) / (1.0 + taken);
        let errors = (0..=80).map(|i| {
            let hz = 2e3 + 100.0 * f64::from(i);
            let tangent = (std::f64::consts::PI * hz * DT_S).tan();
            let wanted = branches
                .iter()
                .map(|branch| (branch.at(hz) / AIR_PASM).inv());
            let found = reduced.iter().map(|branch| branch.at(tangent).inv());
            (factor(found.sum()) - factor(wanted.sum())).norm()
        });
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn the_fit_leaves_little_of_the_tangent() {
        let resonance = |hz: f64, r: f64, x: f64| Branch::resonance(hz, r * AIR_PASM, x * AIR_PASM);
        let inertance = Branch {
            stiffness_papm: 0.0,
            ..resonance(4e3, 0.2, 1.0)
        };
        for (branches, allowed) in [
            (vec![resonance(4e3, 0.2, 1.0)], 0.012),
            (
                vec![resonance(4e3, 0.2, 1.0), resonance(9e3, 0.3, 1.0)],
                0.008,
            ),
            (vec![inertance], 0.018),
        ] {
            let reduced = reduce(&branches, AIR_PASM, DT_S, EDGE);
            let plain: Vec<Reduced> = branches
                .iter()
                .map(|branch| Reduced::new(branch, AIR_PASM, DT_S))
                .collect();
            let [found, plain] = [reduced, plain].map(|reduced| error(&branches, &reduced));
            println!("{branches:?}: {found:.4}, without the fit {plain:.4}");
            assert!(found < allowed && plain > 1.2 * found, "{found}, {plain}");
        }
    }

    #[test]
    fn finer_steps_leave_inertance_and_stiffness_as_they_are() {
        let panel = [Branch::resonance(4e3, 0.2 * AIR_PASM, AIR_PASM)];
        let changes = [1.0, 4.0, 16.0].map(|parts| {
            let dt_s = DT_S / parts;
            let reduced = reduce(&panel, AIR_PASM, dt_s, EDGE)[0];
            1.0 - reduced.inertia / Reduced::new(&panel[0], AIR_PASM, dt_s).inertia
        });
        assert!(changes[0] < 0.03, "{changes:?}");
        assert!(changes[1] < changes[0] / 3.0 && changes[2] < changes[1] / 3.0);
    }
}
