//! The direct method: a moving source spread onto the grid, a moving receiver interpolated from it (Tsuchiya and
//! Kanamori 2021; Tsuchiya, Teshima and Hiryu 2022).
//!
//! The source of strength `q` (m^2/s) adds `rho c^2 dt / (2 dx^2) [(w q)^{n+1} - (w q)^{n-1}]` to the pressure at step
//! `n + 1`, with `w` the spreading weights at the place where the source is at each of the two times. The difference
//! over two steps has the transfer `sin(omega dt)/(omega dt)`, the inverse of the leapfrog's own gain, so that no
//! frequency-dependent gain in time remains; being a difference, it leaves no constant pressure behind.

use std::f64::consts::PI;

use super::domain::Domain;
use super::segments::Segment;
use crate::field::{Injection, StepForcing, flushes_subnormals};
use crate::scheme::Scheme;
use crate::spread::{Spread, Stencil};

/// Source strength in m^2/s for a waveform of amplitude one: about 1 Pa at 1 m and 10 kHz.
pub const SOURCE_STRENGTH_M2PS: f64 = 1e-3;

/// A function of time in seconds.
type OfTime<T> = Box<dyn Fn(f64) -> T + Send + Sync>;

/// A moving source, a moving receiver and the source's strength.
pub struct MovingPair {
    spread: Spread,
    scheme: Scheme,
    flushing: bool,
    dx_m: f64,
    dt_s: f64,
    /// `rho c^2 dt / (2 dx^2)`.
    gain: f64,
    source_m: OfTime<[f64; 2]>,
    receiver_m: OfTime<[f64; 2]>,
    strength_m2ps: OfTime<f64>,
    coincident: bool,
    /// Cells from the domain's first to the field's.
    first_cell: [f64; 2],
    /// First step of the field, and the steps over which the source rises after it.
    start: i64,
    ramp: i64,
    /// Contributions at steps `n - 1` and `n`, from the calls before.
    recent: Option<(u64, [Injection; 2])>,
}

impl MovingPair {
    /// `source_m` and `receiver_m` give the places (metres, in the domain) and `strength_m2ps` the source strength at a
    /// time in seconds; up to and at time 0 the source is silent. `coincident` says that both places are the same.
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
            scheme: domain.scheme,
            flushing: true,
            dx_m: grid.dx_m,
            dt_s: grid.dt_s,
            gain: stiffness * grid.dt_s / (2.0 * grid.dx_m * grid.dx_m),
            source_m,
            receiver_m,
            strength_m2ps,
            coincident,
            first_cell: [0.0; 2],
            start: 0,
            ramp: 0,
            recent: None,
        }
    }

    /// Goes on in a silent field that has a part of the domain and starts with this segment.
    pub(super) fn enter(&mut self, segment: &Segment) {
        self.first_cell = segment.window.first.map(|cells| cells as f64);
        self.start = segment.start as i64;
        self.ramp = segment.ramp as i64;
        self.recent = None;
    }

    /// Whether steps set small numbers to zero when [`flushes_subnormals`] says so; they do by default.
    pub(super) fn set_flushing(&mut self, flushing: bool) {
        self.flushing = flushing;
    }

    fn stencil(&self, point_m: [f64; 2]) -> Stencil {
        // Whole cells are taken away last: the place within a cell stays the same to the last bit.
        self.spread.stencil(std::array::from_fn(|axis| {
            point_m[axis] / self.dx_m - 0.5 - self.first_cell[axis]
        }))
    }

    /// `w q` at step `n`, scaled to pressure.
    fn contribution(&self, step: i64) -> Injection {
        let t = step as f64 * self.dt_s;
        // Silent at the first step too: the field starts at rest, and a contribution that entered it without its
        // counterpart two steps earlier would leave a constant pressure behind.
        let strength = if step <= self.start {
            0.0
        } else {
            self.rise(step - self.start) * (self.strength_m2ps)(t)
        };
        Injection {
            stencil: self.stencil((self.source_m)(t.max(0.0))),
            amplitude: (self.gain * strength) as f32,
        }
    }

    /// Gain of the source `steps` after the field's first: a raised cosine from zero to one.
    fn rise(&self, steps: i64) -> f64 {
        if steps >= self.ramp {
            return 1.0;
        }
        0.5 - 0.5 * (PI * steps as f64 / self.ramp as f64).cos()
    }

    /// Injections and receiver of the step from level `step` to `step + 1`.
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
            flush: self.flushing && flushes_subnormals(self.scheme, step),
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

    /// The most that the source has added to a cell in one of the first `steps` steps, Pa.
    pub(super) fn loudest(&self, steps: u64) -> f64 {
        let strengths = (1..=steps).map(|step| (self.strength_m2ps)(step as f64 * self.dt_s));
        self.gain * strengths.fold(0.0, |most, strength| strength.abs().max(most))
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
