//! Hankel functions of the second kind: orders 0 and 1 by their integral along the steepest descent, any whole order by
//! recurrence.

use rustfft::num_complex::Complex;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4};

/// Step and reach of the trapezoidal rule. Its error falls like `exp(-2 pi sqrt(z) / step)`, so from `z = 0.05` on it
/// is below 1e-12.
const STEP: f64 = 0.04;
const POINTS: usize = 160;

/// `H0^(2)(z) = J0(z) - i Y0(z)` for `z >= 0.05`.
///
/// ```text
/// H0^(2)(z) = sqrt(2 / (pi z)) e^(-i (z - pi/4)) (2 / sqrt(pi)) int_0^inf e^(-w^2) (1 - i w^2 / (2 z))^(-1/2) dw
/// ```
pub fn hankel0(z: f64) -> Complex<f64> {
    let integral = trapezoid(z, |_, bent| bent.sqrt().inv());
    wave(z, 0.0) * integral
}

/// `H1^(2)(z) = J1(z) - i Y1(z)` for `z >= 0.05`, minus the derivative of [`hankel0`].
pub fn hankel1(z: f64) -> Complex<f64> {
    let integral = trapezoid(z, |square, bent| bent.sqrt() * (2.0 * square));
    wave(z, 1.0) * integral
}

/// `H_n^(2)(z) = J_n(z) - i Y_n(z)` of any whole order.
pub fn hankel(n: i32, z: f64) -> Complex<f64> {
    Complex::new(libm::jn(n, z), -libm::yn(n, z))
}

/// `sqrt(2 / (pi z)) e^(-i (z - order pi/2 - pi/4)) 2 / sqrt(pi)`.
fn wave(z: f64, order: f64) -> Complex<f64> {
    let size = (FRAC_2_PI / z).sqrt() * std::f64::consts::FRAC_2_SQRT_PI;
    Complex::from_polar(size, -(z - order * FRAC_PI_2 - FRAC_PI_4))
}

/// Integral over w from 0 of `e^(-w^2) term(w^2, 1 - i w^2 / (2 z))`, even in w.
fn trapezoid(z: f64, term: impl Fn(f64, Complex<f64>) -> Complex<f64>) -> Complex<f64> {
    (0..POINTS)
        .map(|k| {
            let square = (k as f64 * STEP).powi(2);
            let share = if k == 0 { 0.5 * STEP } else { STEP };
            term(square, Complex::new(1.0, -square / (2.0 * z))) * (share * (-square).exp())
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabulated_values() {
        let close = |value: Complex<f64>, j: f64, y: f64| {
            assert!((value - Complex::new(j, -y)).norm() < 2e-12, "{value}")
        };
        close(
            hankel0(1.0),
            0.765_197_686_557_966_6,
            0.088_256_964_215_676_96,
        );
        close(
            hankel1(1.0),
            0.440_050_585_744_933_5,
            -0.781_212_821_300_288_7,
        );
        close(
            hankel0(10.0),
            -0.245_935_764_451_348_3,
            0.055_671_167_283_599_4,
        );
        close(hankel0(0.1), 0.997_501_562_066_04, -1.534_238_651_350_366_6);
    }

    #[test]
    fn the_integrals_are_those_of_the_recurrence() {
        for z in [0.3, 2.0, 17.0, 130.0] {
            assert!((hankel(0, z) - hankel0(z)).norm() < 1e-11 * hankel0(z).norm());
            assert!((hankel(1, z) - hankel1(z)).norm() < 1e-11 * hankel1(z).norm());
        }
    }

    #[test]
    fn the_wronskian_holds_at_every_argument() {
        // J1 Y0 - J0 Y1 = 2 / (pi z)
        for step in 1..400 {
            let z = 0.05 * 1.03f64.powi(step);
            let (zero, one) = (hankel0(z), hankel1(z));
            let wronskian = -one.re * zero.im + zero.re * one.im;
            assert!((wronskian * z / FRAC_2_PI - 1.0).abs() < 1e-11, "at {z}");
        }
    }
}
