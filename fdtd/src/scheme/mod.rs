//! Finite-difference schemes for the wave equation, written as polynomials in the two second differences.
//!
//! With `A` and `B` the (wall-masked) second differences along x and y, one step is
//! `p^{n+1} = 2 p^n - p^{n-1} + [a (A + B) + b (A^2 + B^2) + m (AB + BA)/2 + c (A^3 + B^3) + t (ABA + BAB)] p^n`.
//! Writing every scheme this way lets rigid walls close faces of `A` and `B` and keeps the operator symmetric, so that
//! no wall can make energy (see [`crate::walls::operator`]).

mod dispersion;
mod optimum;
mod polynomial;
mod stability;

use std::sync::OnceLock;

pub use polynomial::Polynomial;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which scheme advances the field.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// Standard leapfrog, 5 points, second order.
    Slf,
    /// 13-point modified equation, fourth order in space and time.
    M13,
    /// 13 points, optimised for a small error of the group velocity up to 5.2 cells per wavelength (13 kHz on the
    /// papers' grid).
    O13,
    /// 25 points, optimised for a small error of the phase velocity up to 3.8 cells per wavelength (18 kHz on the
    /// papers' grid).
    D25,
    /// 9 points, second order: `A + B + AB/4`, the interpolated wide-band scheme of the compact explicit family that
    /// the 2024 paper's reference [38] names (van Walstijn and Kowalczyk 2008). It is made for Courant numbers near 1;
    /// on the papers' grid it is as dispersive as the leapfrog along the axes, and more so across them.
    Iwb,
}

/// Weights that one Courant number gives a scheme, exact in `f32`.
///
/// The coefficients are rounded to multiples of 2^-22, so that every stencil weight and every sum of weights, at
/// walls too, is exact: the rows of the operator sum to exactly zero, as for the wave equation between rigid walls.
///
/// ```
/// use fdtd::scheme::Scheme;
///
/// let weights = Scheme::Slf.weights(0.5);
/// assert_eq!([weights.edge, weights.corner, weights.far], [0.25, 0.0, 0.0]);
/// // Sound on the grid is slower than in air, and less so with a wider stencil.
/// let error = |scheme: Scheme| 1.0 - scheme.polynomial(0.5).phase_velocity(0.5, 0.0).unwrap();
/// assert!(error(Scheme::Slf) > 3.0 * error(Scheme::M13).abs());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Coefficient of `A + B`.
    pub linear: f32,
    /// Coefficient of `A^2 + B^2`.
    pub square: f32,
    /// Coefficient of `(AB + BA)/2`.
    pub mixed: f32,
    /// Coefficient of `A^3 + B^3`.
    pub cube: f32,
    /// Coefficient of `ABA + BAB`.
    pub cross: f32,
    /// Weight of the cell itself, including the 2 of the time difference and the restoring quantum.
    pub centre: f32,
    /// Weight of the four edge neighbours.
    pub edge: f32,
    /// Weight of the four diagonal neighbours.
    pub corner: f32,
    /// Weight of the four neighbours at distance two.
    pub far: f32,
    /// Weight of the eight neighbours a knight's move away.
    pub knight: f32,
    /// Weight of the four neighbours at distance three.
    pub outer: f32,
}

impl Weights {
    /// Quantity whose second difference the absorbing layer takes: weights of the cell, of its two neighbours along the
    /// absorbed axis and of the two across it, of the two at distance two along it, and of the four diagonal ones.
    /// Writing the scheme as `A(a + b A + m B/2 + c A^2 + t BA) + B(a + b B + m A/2 + c B^2 + t AB)`, they are the
    /// brackets over `a`.
    pub fn layer(&self) -> [f32; 5] {
        let [linear, square, mixed, cube, cross] =
            [self.linear, self.square, self.mixed, self.cube, self.cross].map(f64::from);
        let (along, across) = (square / linear, mixed / (2.0 * linear));
        let (far, corner) = (cube / linear, cross / linear);
        [
            1.0 - 2.0 * (along + across) + (6.0 * far + 4.0 * corner),
            along - (4.0 * far + 2.0 * corner),
            across - 2.0 * corner,
            far,
            corner,
        ]
        .map(|weight| weight as f32)
    }
}

/// Reduction of the centre weight against drift: a stiffness that turns the constant mode into an oscillation of
/// about 7 Hz at the papers' step. Without it the rounding errors of an `f32` leapfrog are summed twice and the mean
/// pressure between rigid walls wanders off over millions of steps; with it they stay bounded. At 2 kHz it changes the
/// speed of sound by less than 1e-5.
pub const RESTORING_QUANTUM: f32 = 1.0 / (1u32 << 23) as f32;

impl Scheme {
    /// All schemes: those to choose from in the order of their cost, and the one to compare with.
    pub const ALL: [Self; 5] = [Self::Slf, Self::M13, Self::O13, Self::D25, Self::Iwb];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Slf => "slf",
            Self::Iwb => "iwb",
            Self::M13 => "m13",
            Self::O13 => "o13",
            Self::D25 => "d25",
        }
    }

    /// How many cells the stencil reaches. The 9-point one is computed as 13 points whose outermost weigh nothing.
    pub fn radius(self) -> usize {
        match self {
            Self::Slf => 1,
            Self::Iwb | Self::M13 | Self::O13 => 2,
            Self::D25 => 3,
        }
    }

    /// The scheme at Courant number `courant`.
    pub fn polynomial(self, courant: f64) -> Polynomial {
        let chi2 = courant * courant;
        let plain = Polynomial {
            courant,
            linear: chi2,
            square: 0.0,
            mixed: 0.0,
            cube: 0.0,
            cross: 0.0,
        };
        match self {
            Self::Slf => plain,
            Self::Iwb => Polynomial {
                mixed: chi2 / 4.0,
                ..plain
            },
            Self::M13 => {
                let k = (1.0 - chi2) / 12.0;
                Polynomial {
                    square: -chi2 * k,
                    mixed: chi2 * (1.0 / 6.0 - 2.0 * k),
                    ..plain
                }
            }
            Self::O13 => {
                let [square, mixed] = optimum::narrow_coefficients(courant);
                Polynomial {
                    square,
                    mixed,
                    ..plain
                }
            }
            Self::D25 => {
                let [square, mixed, cube, cross] = optimum::coefficients(courant);
                Polynomial {
                    square,
                    mixed,
                    cube,
                    cross,
                    ..plain
                }
            }
        }
    }

    /// Largest stable Courant number, with or without rigid walls ([`Polynomial::is_stable`]).
    pub fn max_courant(self) -> f64 {
        static LIMITS: [OnceLock<f64>; 3] = [const { OnceLock::new() }; 3];
        let limit = match self {
            // Symbol 8 chi^2 <= 4, and a weight that rounding cannot move over it. The interpolated scheme would allow
            // more, but no law is measured there.
            Self::Slf | Self::Iwb => return std::f64::consts::FRAC_1_SQRT_2,
            Self::M13 => &LIMITS[0],
            Self::O13 => &LIMITS[1],
            Self::D25 => &LIMITS[2],
        };
        *limit.get_or_init(|| {
            let [mut low, mut high] = [0.1, std::f64::consts::FRAC_1_SQRT_2];
            for _ in 0..60 {
                let mid = 0.5 * (low + high);
                if self.polynomial(mid).is_stable() {
                    low = mid;
                } else {
                    high = mid;
                }
            }
            low
        })
    }

    /// The `f32` weights at Courant number `courant`.
    pub fn weights(self, courant: f64) -> Weights {
        let quantum = f64::from(1u32 << 22);
        // `mixed` is split in two halves at walls, hence twice the quantum.
        let round = |value: f64, per: f64| (value * per).round() / per;
        let exact_form = self.polynomial(courant);
        let linear = round(exact_form.linear, quantum);
        let square = round(exact_form.square, quantum);
        let mixed = round(exact_form.mixed, quantum / 2.0);
        let cube = round(exact_form.cube, quantum);
        let cross = round(exact_form.cross, quantum);
        let exact = |value: f64| {
            let narrow = value as f32;
            debug_assert_eq!(f64::from(narrow), value);
            narrow
        };
        Weights {
            linear: exact(linear),
            square: exact(square),
            mixed: exact(mixed),
            cube: exact(cube),
            cross: exact(cross),
            centre: exact(
                2.0 - 4.0 * linear + 12.0 * square + 4.0 * mixed
                    - 40.0 * cube
                    - 24.0 * cross
                    - f64::from(RESTORING_QUANTUM),
            ),
            edge: exact(linear - 4.0 * square - 2.0 * mixed + 15.0 * cube + 14.0 * cross),
            corner: exact(mixed - 8.0 * cross),
            far: exact(square - 6.0 * cube - 2.0 * cross),
            knight: exact(cross),
            outer: exact(cube),
        }
    }
}

impl std::fmt::Display for Scheme {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

impl std::str::FromStr for Scheme {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|scheme| scheme.name() == text)
            .ok_or_else(|| {
                format!("unknown scheme '{text}'; accepted are slf, m13, o13, d25 and iwb")
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_sum_to_the_restoring_quantum_exactly() {
        for scheme in Scheme::ALL {
            for courant in [0.3, 0.5, 0.56667, 0.65] {
                let w = scheme.weights(courant);
                let around = 4.0
                    * (f64::from(w.edge)
                        + f64::from(w.corner)
                        + f64::from(w.far)
                        + f64::from(w.outer));
                let sum = f64::from(w.centre) - 2.0 + around + 8.0 * f64::from(w.knight);
                assert_eq!(sum, -f64::from(RESTORING_QUANTUM), "{scheme} at {courant}");
            }
        }
    }

    #[test]
    fn the_symbol_stays_within_zero_and_four_up_to_the_limit() {
        for scheme in Scheme::ALL {
            for part in 1..=10 {
                let courant = scheme.max_courant() * f64::from(part) / 10.0;
                let polynomial = scheme.polynomial(courant);
                for i in 0..=40 {
                    for j in 0..=40 {
                        let s = polynomial.symbol(f64::from(i) * 0.1, f64::from(j) * 0.1);
                        assert!((-1e-12..=4.0 + 1e-12).contains(&s), "{scheme}: {s}");
                    }
                }
            }
        }
    }

    /// The bound that holds with walls, over all Courant numbers in use.
    #[test]
    fn the_wide_scheme_is_stable_below_its_limit_and_accurate_in_its_band() {
        let limit = Scheme::D25.max_courant();
        assert!((0.69..0.70).contains(&limit), "{limit}");
        for part in 1..=40 {
            let courant = limit * f64::from(part) / 40.0;
            let polynomial = Scheme::D25.polynomial(courant);
            assert!(polynomial.is_stable(), "{courant}");
            for step in 1..=36 {
                let omega_dt = courant * optimum::BAND_EDGE * f64::from(step) / 36.0;
                for degrees in [0.0_f64, 10.0, 22.5, 35.0, 45.0] {
                    let velocity = polynomial.phase_velocity(omega_dt, degrees.to_radians());
                    let off = velocity.map(|v| (v - 1.0).abs());
                    assert!(off.is_some_and(|off| off < 1e-3), "{courant}, {off:?}");
                }
            }
        }
    }

    /// Waves along the axes have no error at a Courant number of 1: what the interpolated stencil is made for.
    #[test]
    fn the_interpolated_scheme_is_exact_along_the_axes_at_a_courant_number_of_one() {
        let grid = Scheme::Iwb.polynomial(1.0);
        for part in 1..=9 {
            let omega_dt = 0.3 * f64::from(part);
            let along = grid.phase_velocity(omega_dt, 0.0).unwrap();
            assert!((along - 1.0).abs() < 1e-9, "{omega_dt}: {along}");
        }
    }

    /// Two projections at an angle, the worst that walls can do, reach the bound and do not pass it.
    #[test]
    fn the_bound_is_reached_by_projections_at_an_angle() {
        for (scheme, courant) in [(Scheme::Iwb, 0.567), (Scheme::Iwb, 0.7), (Scheme::M13, 0.6)] {
            let polynomial = scheme.polynomial(courant);
            let (linear, mixed) = (polynomial.linear, polynomial.mixed);
            let of = |cosine: f64| {
                let (sum, product) = (1.0 + cosine, cosine * (1.0 + cosine));
                4.0 * (linear - 4.0 * polynomial.square) * sum - 8.0 * mixed * product
            };
            let cosines = (-1000..=1000).map(|part| 1e-3 * f64::from(part));
            let most = cosines.map(of).fold(0.0, f64::max);
            let bound = polynomial.bound().unwrap();
            assert!(
                most <= bound + 1e-12 && most > 0.9999 * bound,
                "{scheme}: {most} {bound}"
            );
        }
    }

    /// Published for the papers' grid alone; ours must come out there.
    #[test]
    fn the_optimum_on_the_papers_grid_is_the_known_one() {
        let w = Scheme::D25.weights(340.0 / 120_000.0 / 0.005);
        for (weight, known) in [
            (w.edge, 0.386109),
            (w.corner, 0.033760),
            (w.far, -0.036819),
            (w.knight, -0.002219),
            (w.outer, 0.004106),
        ] {
            assert!((f64::from(weight) - known).abs() < 2e-4, "{weight} {known}");
        }
    }
}
