//! A line source at rest beside a rigid half plane: Sommerfeld's problem, in time.
//!
//! With the half plane along the positive x axis, source and microphone at `(r0, phi0)` and `(r, phi)` from its edge,
//! angles in `0..2 pi`, MacDonald's form of the solution (Bowman, Senior and Uslenghi 1969, sec. 8.2) is, with its
//! integral over `cosh t` read as delays,
//! ```text
//! phi(t) = (1/4 pi) [S(R, phi - phi0) + S(R', phi + phi0)],    S(R, psi) = int_{-u}^inf q(t - (R/c) cosh v) dv
//! sinh(u/2) = sqrt(2 r r0 / ((r + r0 + R) R)) cos(psi/2),    R^2 = r^2 + r0^2 - 2 r r0 cos(psi)
//! ```
//! `S(R, psi) + S(R, psi + 2 pi)` is twice the free field: the two sides add up.

use super::burst::Burst;
use fdtd::grid::Medium;
use std::f64::consts::PI;

/// Points of Simpson's rule per period of the burst.
const POINTS_PER_PERIOD: f64 = 60.0;

/// A burst beside a rigid half plane.
#[derive(Debug, Clone, Copy)]
pub struct HalfPlane {
    /// The medium.
    pub medium: Medium,
    /// Source strength, peak 1 m^2/s.
    pub burst: Burst,
    /// Source from the edge in metres; the half plane is the positive x axis.
    pub source_m: [f64; 2],
}

/// Distance and angle in `0..2 pi`.
fn polar([x, y]: [f64; 2]) -> [f64; 2] {
    [x.hypot(y), y.atan2(x).rem_euclid(2.0 * PI)]
}

impl HalfPlane {
    /// Pressure in Pa at a point (from the edge, in metres) and a time.
    pub fn pressure(&self, x_m: [f64; 2], t_s: f64) -> f64 {
        let ([r_m, phi], [_, phi0]) = (polar(x_m), polar(self.source_m));
        self.part(r_m, phi - phi0, t_s) + self.part(r_m, phi + phi0, t_s)
    }

    /// One of the two parts: `rho / (4 pi)` times the time derivative of `S`.
    fn part(&self, r_m: f64, psi: f64, t_s: f64) -> f64 {
        let [r0_m, _] = polar(self.source_m);
        let c = self.medium.c_mps;
        let way_m = (r_m * r_m + r0_m * r0_m - 2.0 * r_m * r0_m * psi.cos()).sqrt();
        let half = (2.0 * r_m * r0_m / ((r_m + r0_m + way_m) * way_m)).sqrt() * (0.5 * psi).cos();
        let longest = (t_s - self.burst.support_s()[0]) * c / way_m;
        if longest <= 1.0 {
            return 0.0;
        }
        let end = longest.acosh();
        let begin = (-2.0 * half.asinh()).max(-end);
        if begin >= end {
            return 0.0;
        }
        let periods = way_m / c * end.cosh() * self.burst.frequency_hz;
        let pairs = (POINTS_PER_PERIOD * periods).ceil().max(50.0) as usize;
        let step = (end - begin) / (2 * pairs) as f64;
        let rate = |v: f64| {
            // Central difference of the strength: smooth, so that 1e-3 of a period is exact to 1e-6.
            let (sent_s, d) = (t_s - way_m / c * v.cosh(), 1e-3 / self.burst.frequency_hz);
            (self.burst.value(sent_s + d) - self.burst.value(sent_s - d)) / (2.0 * d)
        };
        let sum: f64 = (0..=2 * pairs)
            .map(|i| {
                let weight = match i {
                    0 => 1.0,
                    i if i == 2 * pairs => 1.0,
                    i if i % 2 == 1 => 4.0,
                    _ => 2.0,
                };
                weight * rate(begin + step * i as f64)
            })
            .sum();
        self.medium.rho_kgpm3 / (4.0 * PI) * sum * step / 3.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::monopole::burst_on_path;
    use crate::laws::conditions::CONDITIONS;

    #[test]
    fn what_one_side_loses_the_other_has() {
        let medium = CONDITIONS[7].medium;
        let burst = Burst::from_zero(3e3, 600.0);
        let half_plane = HalfPlane {
            medium,
            burst,
            source_m: [0.2, 0.35],
        };
        let (strength, place) = (|t_s: f64| burst.value(t_s), |_: f64| [0.2, 0.35]);
        let free = burst_on_path(medium, burst, &strength, &place);
        for (r_m, phi) in [(0.4, 0.3), (0.3, 2.8), (0.5, 5.0)] {
            let psi = phi - polar([0.2, 0.35])[1];
            for step in 0..12 {
                let t_s = 3e-3 + 2e-4 * f64::from(step);
                let both =
                    half_plane.part(r_m, psi, t_s) + half_plane.part(r_m, psi + 2.0 * PI, t_s);
                let alone = free.pressure([r_m * phi.cos(), r_m * phi.sin()], t_s);
                assert!((both - alone).abs() < 1.0, "{phi} {t_s}: {both} {alone}");
            }
        }
    }

    #[test]
    fn on_the_half_plane_the_pressure_is_doubled_and_behind_it_less() {
        let half_plane = HalfPlane {
            medium: CONDITIONS[3].medium,
            burst: Burst::from_zero(3e3, 600.0),
            source_m: [2.0, 0.1],
        };
        let peak = |x_m: [f64; 2]| {
            (0..400)
                .map(|n| half_plane.pressure(x_m, 1e-5 * f64::from(n)).abs())
                .fold(0.0, f64::max)
        };
        let (above, below) = (peak([2.0, 1e-6]), peak([2.0, -1e-6]));
        assert!(below < 0.3 * above, "{below} {above}");
    }
}
