//! Waveforms in the plane: the far field of a line source is the half derivative of its strength.
//!
//! With q in m^2/s and tau = r/c the pressure of a source at rest is `p = (omega rho Q / 4) H0^(2)(omega tau)`, and for
//! large `omega tau`
//! ```text
//! H0^(2)(z) = sqrt(2 / (pi z)) e^(-i (z - pi/4)) (1 - 1/(8 i z) + 9/(128 (i z)^2) - ...)
//! p(t) = rho / (2 sqrt(2 pi tau)) [ D^(1/2) q - 1/(8 tau) D^(-1/2) q + ... ](t - tau)
//! ```
//! where `D^(1/2)` multiplies the spectrum by `sqrt(i omega)`. Two terms leave 9/128 (kr)^-2 of the amplitude: 1e-3 at
//! `kr = 8`.

use fdtd::waveform::PeriodicWaveform;
use rustfft::{FftPlanner, num_complex::Complex};
use std::f64::consts::TAU;

/// A periodic source strength prepared for cylindrical spreading: its half derivative and half integral at any time.
#[derive(Debug, Clone)]
pub struct CylindricalWaveform {
    period_s: f64,
    /// (half derivative, half integral) at evenly spaced times of one period.
    table: Vec<[f64; 2]>,
}

impl CylindricalWaveform {
    /// Prepares the strength in m^2/s given by evenly spaced samples of one period, the first at time 0.
    ///
    /// Values between the samples are interpolated by a polynomial of degree 5, so the samples should be fine: with 30
    /// per period of the highest frequency it errs by 4e-7. The mean is left out, as a steady strength makes no
    /// pressure.
    pub fn new(one_period: &[f64], period_s: f64) -> Self {
        let points = one_period.len();
        let mut spectrum: Vec<Complex<f64>> = one_period
            .iter()
            .map(|&value| Complex::new(value, 0.0))
            .collect();
        let mut planner = FftPlanner::new();
        planner.plan_fft_forward(points).process(&mut spectrum);
        let inverse = planner.plan_fft_inverse(points);
        let powered = |exponent: f64| -> Vec<f64> {
            let mut line = spectrum.clone();
            for (k, value) in line.iter_mut().enumerate() {
                let harmonic = if 2 * k <= points {
                    k as f64
                } else {
                    k as f64 - points as f64
                };
                *value *= if k == 0 || 2 * k == points {
                    Complex::ZERO
                } else {
                    Complex::new(0.0, TAU * harmonic / period_s).powf(exponent) / points as f64
                };
            }
            inverse.process(&mut line);
            line.into_iter().map(|value| value.re).collect()
        };
        let (derivative, integral) = (powered(0.5), powered(-0.5));
        Self {
            period_s,
            table: derivative
                .into_iter()
                .zip(integral)
                .map(|(d, i)| [d, i])
                .collect(),
        }
    }

    /// As [`CylindricalWaveform::new`] from a loudspeaker's waveform times a strength in m^2/s.
    pub fn of(waveform: &PeriodicWaveform, strength_m2ps: f64) -> Self {
        let one_period: Vec<f64> = waveform
            .one_period()
            .iter()
            .map(|value| strength_m2ps * value)
            .collect();
        Self::new(&one_period, waveform.period_s())
    }

    /// Half derivative (m^2 s^-3/2) and half integral (m^2 s^-1/2) of the strength at `t_s`.
    pub fn at(&self, t_s: f64) -> [f64; 2] {
        let points = self.table.len();
        if points == 0 {
            return [0.0; 2];
        }
        let position = (t_s / self.period_s).rem_euclid(1.0) * points as f64;
        let whole = position.floor();
        let weights = lagrange6(position - whole);
        // `rem_euclid` may round up to 1, so the index is taken modulo the table too.
        let first = whole as usize + (points * 2 - 2);
        let mut sum = [0.0; 2];
        for (k, weight) in weights.iter().enumerate() {
            let [derivative, integral] = self.table[(first + k) % points];
            sum[0] += weight * derivative;
            sum[1] += weight * integral;
        }
        sum
    }
}

/// Weights of the six points at -2..=3 for the value at `u` in 0..1.
fn lagrange6(u: f64) -> [f64; 6] {
    let [a, b, c, d, e, f] = [u + 2.0, u + 1.0, u, u - 1.0, u - 2.0, u - 3.0];
    [
        -b * c * d * e * f / 120.0,
        a * c * d * e * f / 24.0,
        -a * b * d * e * f / 12.0,
        a * b * c * e * f / 12.0,
        -a * b * c * d * f / 24.0,
        a * b * c * d * e / 120.0,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tone_turns_by_an_eighth_and_the_mean_goes() {
        let (period_s, line) = (0.01, 37.0);
        let omega = TAU * line / period_s;
        let samples: Vec<f64> = (0..1500)
            .map(|k| (TAU * line * k as f64 / 1500.0).cos() + 3.0)
            .collect();
        let waveform = CylindricalWaveform::new(&samples, period_s);
        for step in 0..200 {
            let t_s = step as f64 * 1.234e-4 - 0.01;
            let [derivative, integral] = waveform.at(t_s);
            let eighth = TAU / 8.0;
            assert!((derivative / omega.sqrt() - (omega * t_s + eighth).cos()).abs() < 1e-7);
            assert!((integral * omega.sqrt() - (omega * t_s - eighth).cos()).abs() < 1e-7);
        }
    }

    #[test]
    fn few_or_no_samples_do_no_harm() {
        assert_eq!(CylindricalWaveform::new(&[], 1.0).at(0.3), [0.0; 2]);
        assert_eq!(CylindricalWaveform::new(&[2.0], 1.0).at(0.3), [0.0; 2]);
    }
}
