//! Media and grids that laws are measured on.
//!
//! A scheme may be accurate on the papers' grid and nowhere else. Each case of a law therefore draws its conditions
//! ([`super::setting`]). Laws give lengths, times and frequencies as they are on the papers' grid; here they
//! become those with as many cells, periods and cells per wavelength, so that a tolerance means the same everywhere but
//! for what depends on the Courant number. Frequencies in the names of cases are those on the papers' grid.

use crate::exact::burst::Burst;
use fdtd::grid::Medium;
use fdtd::scheme::Scheme;
use std::f64::consts::{FRAC_PI_4, TAU};

/// A medium, and the steps of a grid in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// The medium.
    pub medium: Medium,
    /// Cell width in metres.
    pub dx_m: f64,
    /// Time step in seconds.
    pub dt_s: f64,
}

/// The papers' grid first. Half humid air at 1013.25 hPa has these speeds between 2 and 30 degC, and there these
/// densities; the Courant numbers go from 0.36 to 0.65.
pub const CONDITIONS: [Conditions; 11] = [
    conditions(340.0, 1.293, 5.0, 120.0),
    conditions(333.0, 1.281, 5.0, 120.0),
    conditions(336.0, 1.258, 6.0, 110.0),
    conditions(338.0, 1.243, 4.0, 192.0),
    conditions(340.9, 1.222, 2.0, 300.0),
    conditions(342.0, 1.214, 6.0, 96.0),
    conditions(343.2, 1.205, 5.0, 120.0),
    conditions(344.0, 1.199, 4.0, 132.0),
    conditions(346.0, 1.185, 2.0, 280.0),
    conditions(348.0, 1.171, 5.0, 115.2),
    conditions(350.0, 1.158, 6.0, 160.0),
];

/// Those of a speed of sound in m/s, a density in kg/m^3, cells in mm and a rate of the field in kHz.
const fn conditions(c_mps: f64, rho_kgpm3: f64, dx_mm: f64, rate_khz: f64) -> Conditions {
    Conditions {
        medium: Medium { c_mps, rho_kgpm3 },
        dx_m: 1e-3 * dx_mm,
        dt_s: 1e-3 / rate_khz,
    }
}

impl Conditions {
    /// The papers' medium and grid.
    pub const PAPERS: Self = CONDITIONS[0];

    /// Courant number.
    pub fn courant(&self) -> f64 {
        self.medium.c_mps * self.dt_s / self.dx_m
    }

    /// Impedance of the air in Pa s/m.
    pub fn air_pasm(&self) -> f64 {
        self.medium.rho_kgpm3 * self.medium.c_mps
    }

    /// A length with as many cells as `metres` on the papers' grid.
    pub fn m(&self, metres: f64) -> f64 {
        metres * (self.dx_m / Self::PAPERS.dx_m)
    }

    /// A point with as many cells from the origin as one in metres on the papers' grid.
    pub fn point(&self, metres: [f64; 2]) -> [f64; 2] {
        metres.map(|x| self.m(x))
    }

    /// A speed of the same Mach number as `mps` in the papers' air.
    pub fn mps(&self, mps: f64) -> f64 {
        mps * (self.medium.c_mps / Self::PAPERS.medium.c_mps)
    }

    /// A time in which sound passes as many cells as in `seconds` on the papers' grid.
    pub fn s(&self, seconds: f64) -> f64 {
        self.m(seconds) / self.mps(1.0)
    }

    /// A frequency with as many cells per wavelength as `hertz` on the papers' grid.
    pub fn hz(&self, hertz: f64) -> f64 {
        hertz / self.s(1.0)
    }

    /// The steps in which sound passes as many cells as in so many on the papers' grid.
    pub fn steps(&self, papers: usize) -> usize {
        (papers as f64 * Self::PAPERS.courant() / self.courant()).ceil() as usize
    }

    /// A path that is `path` on the papers' grid.
    pub fn path(&self, path: impl Fn(f64) -> [f64; 2]) -> impl Fn(f64) -> [f64; 2] {
        let conditions = *self;
        move |t_s| conditions.point(path(t_s / conditions.s(1.0)))
    }

    /// [`Burst::from_zero`] of frequencies on the papers' grid.
    pub fn burst(&self, hertz: f64, spread_hertz: f64) -> Burst {
        Burst::from_zero(self.hz(hertz), self.hz(spread_hertz))
    }

    /// How many times as large the scheme's error of the phase velocity is, for waves that have `hertz` on the papers'
    /// grid, as there: by the dispersion relation, the larger one of those along the axis and the diagonal, and at
    /// least 1. A law's allowance for dispersion is multiplied by it.
    pub fn dispersion(&self, scheme: Scheme, hertz: f64) -> f64 {
        let error = |conditions: &Self| {
            let polynomial = scheme.polynomial(conditions.courant());
            let omega_dt = TAU * conditions.hz(hertz) * conditions.dt_s;
            let off = |angle_rad: f64| {
                let velocity = polynomial.phase_velocity(omega_dt, angle_rad);
                velocity.map_or(f64::INFINITY, |velocity| (velocity - 1.0).abs())
            };
            off(0.0).max(off(FRAC_PI_4))
        };
        (error(self) / error(&Self::PAPERS)).max(1.0)
    }

    /// Whether walls of an impedance reflect as they do on the papers' grid; [`super::impedance`] describes larger
    /// Courant numbers.
    pub fn has_accurate_impedances(&self) -> bool {
        self.courant() <= 0.58
    }

    /// Whether the scheme leaves enough for walls of an impedance.
    pub fn allows_impedance(&self, scheme: Scheme) -> bool {
        scheme.polynomial(self.courant()).allows_impedance()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fdtd::medium::{Air, STANDARD_PRESSURE_PA};

    #[test]
    fn every_density_is_that_of_air_with_the_speed() {
        for Conditions { medium, .. } in CONDITIONS.into_iter().skip(1) {
            let air = |temperature_degc: f64| {
                Air {
                    temperature_degc,
                    relative_humidity_percent: 50.0,
                    pressure_pa: STANDARD_PRESSURE_PA,
                }
                .medium()
            };
            let [mut low, mut high] = [0.0, 30.0];
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                *(if air(middle).c_mps < medium.c_mps {
                    &mut low
                } else {
                    &mut high
                }) = middle;
            }
            let Medium { c_mps, rho_kgpm3 } = air(low);
            assert!((c_mps - medium.c_mps).abs() < 1e-6, "{medium:?}");
            assert!((rho_kgpm3 - medium.rho_kgpm3).abs() < 1e-3, "{medium:?}");
        }
    }

    #[test]
    fn courant_numbers_are_spread_and_all_schemes_are_stable() {
        let mut courants = CONDITIONS.map(|conditions| conditions.courant());
        courants.sort_by(f64::total_cmp);
        assert!(courants[0] < 0.37 && courants[10] > 0.64, "{courants:?}");
        for pair in courants.windows(2) {
            assert!(pair[1] - pair[0] < 0.08, "{courants:?}");
        }
        for scheme in Scheme::ALL {
            assert!(courants[10] < scheme.max_courant(), "{scheme}");
            let allowed = CONDITIONS.map(|conditions| conditions.allows_impedance(scheme));
            println!("{scheme}: walls of an impedance {allowed:?}");
            assert!(allowed.into_iter().filter(|&allowed| allowed).count() >= 6);
        }
    }

    #[test]
    fn a_case_has_the_same_cells_per_wavelength_everywhere() {
        for conditions in CONDITIONS {
            let cells = conditions.medium.c_mps / conditions.hz(10e3) / conditions.dx_m;
            assert!((cells - 6.8).abs() < 1e-12);
            let periods = conditions.hz(10e3) * conditions.s(3e-3);
            assert!((periods - 30.0).abs() < 1e-12);
            let mach = conditions.mps(34.0) / conditions.medium.c_mps;
            assert!((mach - 0.1).abs() < 1e-12);
            let passed = conditions.steps(900) as f64 * conditions.courant();
            assert!((510.0 - 1e-9..511.0).contains(&passed), "{passed}");
            let path = conditions.path(|t_s| [1.0 + 34.0 * t_s, 2.0]);
            let [x, y] = path(conditions.s(0.01));
            assert!((x - conditions.m(1.34)).abs() < 1e-12 && y == conditions.m(2.0));
        }
        assert_eq!(Conditions::PAPERS.dispersion(Scheme::Slf, 4e3), 1.0);
    }
}
