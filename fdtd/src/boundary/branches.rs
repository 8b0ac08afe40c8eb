//! Time stepping of impedances by branches of resistance, inertance and compliance.
//!
//! A branch k has a velocity u (times `rho c`, in Pa) half a step before and after the pressure P at the surface, and
//! a displacement `Q+ = Q + u+` (in steps) at the times of P. With `r = R/(rho c)`, `l = L/(rho c dt)`,
//! `sigma = s dt/(rho c)` and the mean of three displacements, `(Q+ + 2 Q + Q-)/4 = Q + (u+ - u-)/4`,
//!
//! `(l + sigma/4)(u+ - u-) + r (u+ + u-)/2 + sigma Q = P`, or, with `beta = 1/(l + sigma/4 + r/2)`,
//! `u+ - u- = beta (P - r u- - sigma Q)`.
//!
//! This is the impedance of the branch with `(2/dt) tan(omega dt/2)` in place of omega (the bilinear transform),
//! times `cos(omega dt/2)`, which the weights before the surface compensate ([`super::axis_kernel`]). It is positive
//! real for all r, l and sigma of 0 or more, so that the surface is passive with the mass of air that it has anyway
//! ([`super::design`]). All branches share this mass M, `P = T - M sum (u+ - u-)` with the sampled pressure T, which
//! can be solved in advance:
//!
//! `u+ - u- = beta/(1 + M sum beta) (T + M sum e) - e`, with `e = beta (r u- + sigma Q)` of each branch.
//!
//! No coefficient exceeds 4 or 1/M, so that rounding errors stay small where branches differ by many decades. The
//! state is `beta sigma Q` in place of Q: without a compliance it stays zero; with one it is restoring, and cannot
//! drift. Finite volumes with such walls: Bilbao, Hamilton, Botts and Savioja 2016.

use crate::impedance::Branch;
use crate::number::Real;

/// A branch in units of the characteristic impedance of the air and of the time step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reduced {
    /// `r = R/(rho c)`.
    pub(super) resistance: f64,
    /// `l = L/(rho c dt)`.
    pub(super) inertia: f64,
    /// `sigma = s dt/(rho c)`.
    pub(super) spring: f64,
}

impl Reduced {
    /// For steps of `dt_s` in air of a characteristic impedance `rho c` in Pa s/m.
    pub(super) fn new(branch: &Branch, characteristic_pasm: f64, dt_s: f64) -> Self {
        Self {
            resistance: branch.resistance_pasm / characteristic_pasm,
            inertia: branch.inertance_kgpm2 / (characteristic_pasm * dt_s),
            spring: branch.stiffness_papm * dt_s / characteristic_pasm,
        }
    }
}

/// The branches of a surface, with the coefficients of their time stepping.
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
    /// For a mass M of air before the surface, in the unit of l.
    pub(super) fn new(mass: f64, branches: &[Reduced]) -> Self {
        let betas: Vec<f64> = branches
            .iter()
            .map(|branch| 1.0 / (branch.inertia + 0.25 * branch.spring + 0.5 * branch.resistance))
            .collect();
        let all = 1.0 + mass * betas.iter().sum::<f64>();
        let part = |(branch, beta): (&Reduced, &f64)| Part {
            damping: (beta * branch.resistance) as f32,
            spring: (beta * branch.spring) as f32,
            flow: (beta / all) as f32,
        };
        Self {
            mass: mass as f32,
            parts: branches.iter().zip(&betas).map(part).collect(),
        }
    }

    /// Length of its state: velocity u and `beta sigma Q` of each branch, in Pa.
    pub(crate) fn memory(&self) -> usize {
        2 * self.parts.len()
    }

    /// Takes one step with the pressure `sampled` before the surface in Pa, and returns the velocity before the step
    /// less that after it, summed over branches.
    // Inlined: as a separate function it would be compiled without fused multiply-adds.
    #[inline(always)]
    pub(crate) fn step<N: Real>(&self, sampled: N, memory: &mut [N]) -> N {
        let mut drive = sampled;
        for (part, state) in self.parts.iter().zip(memory.chunks_exact(2)) {
            let back = N::splat(part.damping).mul_add(state[0], state[1]);
            drive = N::splat(self.mass).mul_add(back, drive);
        }
        let mut change = N::default();
        for (part, state) in self.parts.iter().zip(memory.chunks_exact_mut(2)) {
            let back = N::splat(part.damping).mul_add(state[0], state[1]);
            let gain = N::splat(part.flow).mul_sub(drive, back);
            state[0] = state[0].add(gain);
            state[1] = N::splat(part.spring).mul_add(state[0], state[1]);
            change = change.sub(gain);
        }
        change
    }
}
