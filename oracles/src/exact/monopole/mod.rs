//! A line source of any strength on any path slower than sound.

use super::burst::Burst;
use fdtd::grid::Medium;
use std::f64::consts::PI;

/// Nodes and weights of the 8-point Gauss-Legendre rule on -1..1, the positive half.
const GAUSS: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_48],
    [0.960_289_856_497_536_3, 0.101_228_536_290_376_26],
];

/// A moving line source with a strength of finite length.
///
/// Its potential is the retarded integral over the whole past, because in the plane every signal has a tail:
/// ```text
/// phi(x, t) = (1/2 pi) int_0^inf q(t_r - s) / sqrt((t - t_r + s)^2 - R(t_r - s)^2 / c^2) ds,    R(t') = |x - x_s(t')|
/// ```
/// with `t_r` the retarded time, where the root vanishes. `s = u^2` takes the singularity away.
#[derive(Clone, Copy)]
pub struct Monopole<'a> {
    /// The medium.
    pub medium: Medium,
    /// Strength in m^2/s at a time in seconds.
    pub strength_at: &'a dyn Fn(f64) -> f64,
    /// First and last time in seconds with a strength.
    pub support_s: [f64; 2],
    /// Shortest period in the strength, in seconds.
    pub finest_s: f64,
    /// Position in metres at a time in seconds.
    pub position_at: &'a dyn Fn(f64) -> [f64; 2],
}

impl Monopole<'_> {
    /// Retarded time in seconds: when sound was emitted that arrives at a point at `t_s` along the straight path.
    pub fn sent_at_s(&self, x_m: [f64; 2], t_s: f64) -> f64 {
        let mut sent_s = t_s;
        for _ in 0..200 {
            let next_s = t_s - self.distance_m(x_m, sent_s) / self.medium.c_mps;
            let done = (next_s - sent_s).abs() < 1e-15;
            sent_s = next_s;
            if done {
                break;
            }
        }
        sent_s
    }

    /// Velocity potential in m^2/s at a point.
    pub fn potential(&self, x_m: [f64; 2], t_s: f64) -> f64 {
        let sent_s = self.sent_at_s(x_m, t_s);
        let from_s = (sent_s - self.support_s[1]).max(0.0);
        let to_s = sent_s - self.support_s[0];
        if to_s <= from_s {
            return 0.0;
        }
        // Panels of half the shortest period, in u.
        let panels = ((to_s - from_s) / (0.5 * self.finest_s)).ceil() as usize;
        let edge = |panel: usize| (from_s + (to_s - from_s) * panel as f64 / panels as f64).sqrt();
        let delay_s = t_s - sent_s;
        let integrand = |u: f64| {
            let s = u * u;
            let reach_s = self.distance_m(x_m, sent_s - s) / self.medium.c_mps;
            let elapsed_s = delay_s + s;
            2.0 * (self.strength_at)(sent_s - s) * u
                / ((elapsed_s - reach_s) * (elapsed_s + reach_s)).sqrt()
        };
        let sum: f64 = (0..panels)
            .map(|panel| {
                let (low, high) = (edge(panel), edge(panel + 1));
                let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
                let weighted = GAUSS.map(|[node, weight]| {
                    weight * (integrand(middle - half * node) + integrand(middle + half * node))
                });
                half * weighted.iter().sum::<f64>()
            })
            .sum();
        sum / (2.0 * PI)
    }

    /// Pressure in Pa at a fixed point: `rho` times the time derivative of the potential, by the six-point central
    /// difference.
    ///
    /// A moving microphone at `x_r(t)` receives the pressure where it is, `pressure(x_r(t), t)`, which is the same as
    /// `rho (d/dt - v_r . grad) phi` along its path.
    pub fn pressure(&self, x_m: [f64; 2], t_s: f64) -> f64 {
        let step_s = self.finest_s / 60.0;
        let rise = |steps: f64| {
            self.potential(x_m, t_s + steps * step_s) - self.potential(x_m, t_s - steps * step_s)
        };
        self.medium.rho_kgpm3 * (45.0 * rise(1.0) - 9.0 * rise(2.0) + rise(3.0)) / (60.0 * step_s)
    }

    fn distance_m(&self, x_m: [f64; 2], t_s: f64) -> f64 {
        let [x, y] = (self.position_at)(t_s);
        (x_m[0] - x).hypot(x_m[1] - y)
    }
}

/// A [`Burst`] of peak strength 1 m^2/s on a path, for [`Monopole`].
pub fn burst_on_path<'a>(
    medium: Medium,
    burst: Burst,
    strength_at: &'a dyn Fn(f64) -> f64,
    position_at: &'a dyn Fn(f64) -> [f64; 2],
) -> Monopole<'a> {
    Monopole {
        medium,
        strength_at,
        support_s: burst.support_s(),
        finest_s: 1.0 / (burst.frequency_hz + 3.0 / (std::f64::consts::TAU * burst.sigma_s)),
        position_at,
    }
}

#[cfg(test)]
mod tests;
