//! Steady tones of a line source at rest and in uniform motion, in closed form.

use super::hankel::{hankel0, hankel1};
use fdtd::grid::Medium;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Complex pressure in Pa of `q = Q cos(omega t)` at rest at distance `r_m`: `p(t) = Re[value e^(i omega t)]`, with
/// `value = (omega rho Q / 4) H0^(2)(omega r / c)`. For `omega r / c >= 0.05`.
pub fn at_rest(medium: &Medium, frequency_hz: f64, strength_m2ps: f64, r_m: f64) -> Complex<f64> {
    let omega = TAU * frequency_hz;
    hankel0(omega * r_m / medium.c_mps) * (0.25 * omega * medium.rho_kgpm3 * strength_m2ps)
}

/// Pressure in Pa at time `t_s` and point `x_m`, at rest, of `q = Q cos(omega t)` at `(v t, 0)` for ever, `|v| < c`.
///
/// With `X = x - v t`, `b^2 = 1 - M^2`, `d = sqrt(X^2 + b^2 y^2)`:
/// ```text
/// phi = Re[-(i Q / 4 b) H0^(2)(k d / b^2) e^(i omega t - i k M X / b^2)],    p = rho phi_t
/// ```
pub fn in_uniform_motion(
    medium: &Medium,
    frequency_hz: f64,
    strength_m2ps: f64,
    v_mps: f64,
    x_m: [f64; 2],
    t_s: f64,
) -> f64 {
    let omega = TAU * frequency_hz;
    let k = omega / medium.c_mps;
    let mach = v_mps / medium.c_mps;
    let squeeze = 1.0 - mach * mach;
    let ahead_m = x_m[0] - v_mps * t_s;
    let d_m = (ahead_m * ahead_m + squeeze * x_m[1] * x_m[1]).sqrt();
    let z = k * d_m / squeeze;
    let carrier = Complex::from_polar(1.0, omega * t_s - k * mach * ahead_m / squeeze);
    // phi_t at a fixed point: omega t, the phase of the bent wave, and the distance all change.
    let of_phase = Complex::new(0.0, omega + k * mach * v_mps / squeeze) * hankel0(z);
    let of_distance = hankel1(z) * (k / squeeze * v_mps * ahead_m / d_m);
    let factor = Complex::new(0.0, -0.25 * strength_m2ps / squeeze.sqrt());
    medium.rho_kgpm3 * (factor * carrier * (of_phase + of_distance)).re
}
