//! The direct method: a moving source spread onto the grid, a moving receiver interpolated from it (Tsuchiya and Kanamori
//! 2021; Tsuchiya, Teshima and Hiryu 2022).
//!
//! The source of strength `q` (m^2/s) adds `rho c^2 dt / (2 dx^2) [(w q)^{n+1} - (w q)^{n-1}]` to the pressure at step
//! `n + 1`, with `w` the spreading weights at the place where the source is at each of the two times. The difference
//! over two steps has the transfer `sin(omega dt)/(omega dt)`, the inverse of the leapfrog's own gain, so that no
//! frequency-dependent gain in time remains; being a difference, it leaves no constant pressure behind.

use super::Domain;
use crate::field::{Injection, StepForcing};
use crate::spread::{Spread, Stencil};

/// Source strength in m^2/s for a waveform of amplitude one: about 1 Pa at 1 m and 10 kHz.
pub const SOURCE_STRENGTH_M2PS: f64 = 1e-3;

/// A function of time in seconds.
type OfTime<T> = Box<dyn Fn(f64) -> T + Send + Sync>;

/// A moving source, a moving receiver and what the source emits.
pub struct Drive {
    spread: Spread,
    dx_m: f64,
    dt_s: f64,
    /// `rho c^2 dt / (2 dx^2)`.
    gain: f64,
    source_m: OfTime<[f64; 2]>,
    receiver_m: OfTime<[f64; 2]>,
    strength_m2ps: OfTime<f64>,
    coincident: bool,
    /// Contributions at steps `n - 1` and `n`, from the calls before.
    recent: Option<(u64, [Injection; 2])>,
}

impl Drive {
    /// `source_m` and `receiver_m` give the places (metres, in the domain) and `strength_m2ps` the source strength at a time
    /// in seconds; up to and at time 0 the source is silent. `coincident` says that both places are the same.
    pub fn new(
        domain: &Domain,
        source_m: OfTime<[f64; 2]>,
        receiver_m: OfTime<[f64; 2]>,
        strength_m2ps: OfTime<f64>,
        coincident: bool,
    ) -> Self {
        let (grid, medium) = (&domain.grid, &domain.medium);
        let stiffness = medium.rho_kgpm3 * medium.c_mps * medium.c_mps;
        Self {
            spread: domain.spread,
            dx_m: grid.dx_m,
            dt_s: grid.dt_s,
            gain: stiffness * grid.dt_s / (2.0 * grid.dx_m * grid.dx_m),
            source_m,
            receiver_m,
            strength_m2ps,
            coincident,
            recent: None,
        }
    }

    fn stencil(&self, point_m: [f64; 2]) -> Stencil {
        self.spread.stencil(point_m.map(|x| x / self.dx_m - 0.5))
    }

    /// `w q` at step `n`, scaled to pressure.
    fn contribution(&self, step: i64) -> Injection {
        let t = step as f64 * self.dt_s;
        // Silent at time 0 too: the field starts at rest, and a contribution that entered it without its counterpart two
        // steps earlier would leave a constant pressure behind.
        let strength = if step <= 0 {
            0.0
        } else {
            (self.strength_m2ps)(t)
        };
        Injection {
            stencil: self.stencil((self.source_m)(t.max(0.0))),
            amplitude: (self.gain * strength) as f32,
        }
    }

    /// What happens in the step from level `step` to `step + 1`.
    pub fn forcing(&mut self, step: u64) -> StepForcing {
        let n = step as i64;
        let [before, now] = match self.recent {
            Some((last, pair)) if last == step => pair,
            _ => [self.contribution(n - 1), self.contribution(n)],
        };
        let after = self.contribution(n + 1);
        self.recent = Some((step + 1, [now, after]));
        let receiver = if self.coincident {
            after.stencil
        } else {
            self.stencil((self.receiver_m)((n + 1) as f64 * self.dt_s))
        };
        StepForcing {
            injections: [
                after,
                Injection {
                    amplitude: -before.amplitude,
                    ..before
                },
            ],
            receiver,
        }
    }

    /// Places and strength at a time in seconds: source x and y, receiver x and y, strength.
    pub fn sample(&self, t_s: f64) -> [f64; 5] {
        let (source, receiver) = ((self.source_m)(t_s), (self.receiver_m)(t_s));
        [
            source[0],
            source[1],
            receiver[0],
            receiver[1],
            (self.strength_m2ps)(t_s),
        ]
    }
}
