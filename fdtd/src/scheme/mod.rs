//! Finite-difference schemes for the wave equation, written as polynomials in the two second differences.
//!
//! With `A` and `B` the (wall-masked) second differences along x and y, one step is
//! `p^{n+1} = 2 p^n - p^{n-1} + [a (A + B) + b (A^2 + B^2) + m (AB + BA)/2] p^n`.
//! Writing every scheme this way lets rigid walls close faces of `A` and `B` and keeps the operator symmetric, so that
//! no wall can make energy (see [`crate::walls::operator`]).

mod dispersion;

pub use dispersion::{group_velocity, phase_velocity};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which scheme advances the field.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// Standard leapfrog, 5 points, second order: the papers' scheme.
    Slf,
    /// 13-point modified equation, fourth order in space and time.
    M13,
}

/// Weights that one Courant number gives a scheme, exact in `f32`.
///
/// The three coefficients are rounded to multiples of 2^-22, so that every stencil weight and every sum of weights, at
/// walls too, is exact: the rows of the operator sum to exactly zero, as the wave equation between rigid walls asks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Coefficient of `A + B`.
    pub linear: f32,
    /// Coefficient of `A^2 + B^2`.
    pub square: f32,
    /// Coefficient of `(AB + BA)/2`.
    pub mixed: f32,
    /// Weight of the cell itself, including the 2 of the time difference and the restoring quantum.
    pub centre: f32,
    /// Weight of the four edge neighbours.
    pub edge: f32,
    /// Weight of the four diagonal neighbours.
    pub corner: f32,
    /// Weight of the four neighbours at distance two.
    pub far: f32,
}

impl Weights {
    /// What the absorbing layer takes the second difference of: weights of the cell, of its two neighbours along the
    /// absorbed axis and of the two across it. Writing the scheme as `A(a + b A + m B/2) + B(a + b B + m A/2)`, they are the
    /// brackets over `a`.
    pub fn layer(&self) -> [f32; 3] {
        let [linear, square, mixed] = [self.linear, self.square, self.mixed].map(f64::from);
        let (along, across) = (square / linear, mixed / (2.0 * linear));
        [1.0 - 2.0 * (along + across), along, across].map(|weight| weight as f32)
    }
}

/// What is taken from the centre weight against drift: a stiffness that turns the constant mode into an oscillation of
/// about 7 Hz at the papers' step. Without it the rounding errors of an `f32` leapfrog are summed twice and the mean
/// pressure between rigid walls wanders off over millions of steps; with it they stay bounded. At 2 kHz it changes the
/// speed of sound by less than 1e-5.
pub const RESTORING_QUANTUM: f32 = 1.0 / (1u32 << 23) as f32;

impl Scheme {
    /// All schemes, in the order of their cost.
    pub const ALL: [Self; 2] = [Self::Slf, Self::M13];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Slf => "slf",
            Self::M13 => "m13",
        }
    }

    /// How many cells the stencil reaches.
    pub fn radius(self) -> usize {
        match self {
            Self::Slf => 1,
            Self::M13 => 2,
        }
    }

    /// Coefficients of `A + B`, `A^2 + B^2` and `(AB + BA)/2` at Courant number `courant`.
    pub fn coefficients(self, courant: f64) -> [f64; 3] {
        let chi2 = courant * courant;
        match self {
            Self::Slf => [chi2, 0.0, 0.0],
            Self::M13 => {
                let k = (1.0 - chi2) / 12.0;
                [chi2, -chi2 * k, chi2 * (1.0 / 6.0 - 2.0 * k)]
            }
        }
    }

    /// Symbol of minus the scaled Laplacian, `4 sin^2(omega dt / 2)` of a plane wave with `a = 4 sin^2(kx dx / 2)` and
    /// `b = 4 sin^2(ky dx / 2)`.
    pub fn symbol(self, courant: f64, a: f64, b: f64) -> f64 {
        let [linear, square, mixed] = self.coefficients(courant);
        linear * (a + b) - square * (a * a + b * b) - mixed * a * b
    }

    /// Largest stable Courant number, with or without rigid walls.
    ///
    /// The bound holds for the wall operator too: it uses the norm of each symmetrised term, not only the symbol on
    /// the free lattice.
    pub fn max_courant(self) -> f64 {
        match self {
            // Symbol 8 chi^2 <= 4.
            Self::Slf => std::f64::consts::FRAC_1_SQRT_2,
            // 8 chi^2 + 32 |square| + 16 |mixed| <= 4, solved once by bisection.
            Self::M13 => {
                let norm = |chi: f64| {
                    let [linear, square, mixed] = self.coefficients(chi);
                    8.0 * linear + 32.0 * square.abs() + 16.0 * mixed.abs()
                };
                let (mut low, mut high) = (0.1, 1.0);
                for _ in 0..60 {
                    let mid = 0.5 * (low + high);
                    if norm(mid) <= 4.0 {
                        low = mid
                    } else {
                        high = mid
                    }
                }
                low
            }
        }
    }

    /// The `f32` weights at Courant number `courant`.
    pub fn weights(self, courant: f64) -> Weights {
        let quantum = f64::from(1u32 << 22);
        // `mixed` is split in two halves at walls, hence twice the quantum.
        let round = |value: f64, per: f64| (value * per).round() / per;
        let [linear, square, mixed] = self.coefficients(courant);
        let linear = round(linear, quantum);
        let square = round(square, quantum);
        let mixed = round(mixed, quantum / 2.0);
        let exact = |value: f64| {
            let narrow = value as f32;
            debug_assert_eq!(f64::from(narrow), value);
            narrow
        };
        Weights {
            linear: exact(linear),
            square: exact(square),
            mixed: exact(mixed),
            centre: exact(
                2.0 - 4.0 * linear + 12.0 * square + 4.0 * mixed - f64::from(RESTORING_QUANTUM),
            ),
            edge: exact(linear - 4.0 * square - 2.0 * mixed),
            corner: exact(mixed),
            far: exact(square),
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
            .ok_or_else(|| format!("unknown scheme '{text}'; accepted are slf and m13"))
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
                let sum = f64::from(w.centre) - 2.0
                    + 4.0 * (f64::from(w.edge) + f64::from(w.corner) + f64::from(w.far));
                assert_eq!(sum, -f64::from(RESTORING_QUANTUM), "{scheme} at {courant}");
            }
        }
    }

    #[test]
    fn the_symbol_stays_within_zero_and_four_up_to_the_limit() {
        for scheme in Scheme::ALL {
            let courant = scheme.max_courant();
            for i in 0..=40 {
                for j in 0..=40 {
                    let s = scheme.symbol(courant, f64::from(i) * 0.1, f64::from(j) * 0.1);
                    assert!((-1e-12..=4.0 + 1e-12).contains(&s), "{scheme}: {s}");
                }
            }
        }
    }
}
