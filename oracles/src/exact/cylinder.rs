//! A rigid circular cylinder: scattering of a line source outside, and the standing waves within.
//!
//! Outside, for a tone `e^(i omega t)` with the source at `(r0, 0)` and the microphone at `(r, phi)` from the axis,
//! both beyond the radius a (Bowman, Senior and Uslenghi 1969, sec. 2.4),
//! ```text
//! H0(k R) - sum_n e_n J_n'(k a) / H_n'(k a) H_n(k r0) H_n(k r) cos(n phi),    e_0 = 1, e_n = 2
//! ```
//! with Hankel functions of the second kind, in units of `omega rho Q / 4` ([`super::tone`]). Within, a standing wave
//! is `J_m(kappa r) cos(m phi)` with `J_m'(kappa a) = 0`.

use super::hankel::hankel;
use libm::jn;
use rustfft::num_complex::Complex;

/// Orders beyond `k a` at the least; from there on the terms fall faster than exponentially down to `(a^2 / (r r0))^n`.
const ORDERS_BEYOND: f64 = 60.0;

/// `J_n'(z)`.
fn jn_slope(n: i32, z: f64) -> f64 {
    if n == 0 {
        -jn(1, z)
    } else {
        0.5 * (jn(n - 1, z) - jn(n + 1, z))
    }
}

/// `H_n^(2)'(z)`.
fn hankel_slope(n: i32, z: f64) -> Complex<f64> {
    if n == 0 {
        -hankel(1, z)
    } else {
        (hankel(n - 1, z) - hankel(n + 1, z)) * 0.5
    }
}

/// Scattered field of a line source at a rigid cylinder, in units of `omega rho Q / 4`: all lengths times the wave
/// number, `ka` the radius, `kr0` and `kr` source and microphone from the axis, both larger, `phi` the angle between
/// them.
pub fn scattered(ka: f64, [kr0, kr]: [f64; 2], phi: f64) -> Complex<f64> {
    let orders = (ka + ORDERS_BEYOND) as i32;
    (0..=orders)
        .map(|n| {
            let twice = if n == 0 { 1.0 } else { 2.0 };
            let factor = hankel(n, kr0) / hankel_slope(n, ka) * hankel(n, kr);
            -factor * (twice * jn_slope(n, ka) * (f64::from(n) * phi).cos())
        })
        .sum()
}

/// Zero number `which` (from 1) of `J_m'` beyond 0: `kappa a` of a standing wave in a rigid round room.
///
/// # Panics
/// When `which` is 0.
pub fn mode(m: i32, which: usize) -> f64 {
    assert!(which > 0, "zeros are counted from 1");
    // Zeros of J_m' lie beyond m and at least 2 apart, so that steps of 0.1 meet each once; far below m J_m is too
    // small for f64.
    let mut z = f64::from(m).max(0.1);
    let mut left = which;
    loop {
        let (here, there) = (jn_slope(m, z), jn_slope(m, z + 0.1));
        if here * there <= 0.0 {
            left -= 1;
            if left == 0 {
                return zero(m, [z, z + 0.1]);
            }
        }
        z += 0.1;
    }
}

/// The zero of `J_m'` in an interval, by bisection.
fn zero(m: i32, [mut low, mut high]: [f64; 2]) -> f64 {
    let rising = jn_slope(m, high) > 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (jn_slope(m, middle) > 0.0) == rising {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

/// A standing wave in a rigid round room at a distance from its axis times `kappa`, and an angle.
pub fn standing(m: i32, kappa_r: f64, phi: f64) -> f64 {
    jn(m, kappa_r) * (f64::from(m) * phi).cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::hankel::hankel0;

    /// Graf's addition theorem: the incident wave is the same sum with `J_n(k a)` in the place of the factor, so the
    /// sum of both has no slope across the surface.
    #[test]
    fn no_air_flows_through_the_surface() {
        let (ka, kr0) = (40.0, 70.0);
        for phi in [0.0, 0.4, 1.3, 2.5] {
            let total = |kr: f64| {
                let apart = (kr0 * kr0 + kr * kr - 2.0 * kr0 * kr * f64::cos(phi)).sqrt();
                hankel0(apart) + scattered(ka, [kr0, kr], phi)
            };
            // Second order at a surface: the slope of a parabola through three points beyond it.
            let d = 1e-3;
            let slope = (total(ka) * -3.0 + total(ka + d) * 4.0 - total(ka + 2.0 * d)) / (2.0 * d);
            assert!(
                slope.norm() < 1e-5 * (1.0 + total(ka).norm()),
                "{phi}: {slope}"
            );
        }
    }

    #[test]
    fn zeros_of_the_slope_are_those_of_the_tables() {
        // Abramowitz and Stegun, table 9.5.
        for (m, which, expected) in [
            (0, 1, 3.831_705_970_2),
            (1, 1, 1.841_183_781_3),
            (1, 2, 5.331_442_773_5),
            (4, 2, 9.282_396_285_2),
        ] {
            assert!((mode(m, which) - expected).abs() < 1e-9, "{m} {which}");
        }
    }
}
