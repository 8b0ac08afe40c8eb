//! Coefficients of the 25-point scheme: the smallest largest error of the phase velocity over a band.
//!
//! The scheme keeps `linear = courant^2`, so that long waves travel at the speed of sound, and has four coefficients to
//! spare. To first order the relative error of the phase velocity of a wave number `k` (radians per cell) in a
//! direction is `(symbol(k) - T) / (2 lambda k sin(lambda k))` with `T = 4 sin^2(lambda k / 2)`, which is linear in
//! them. Its largest magnitude over all directions and all `k` up to the band's edge is made least by Lawson's
//! iteration: least squares, each point's weight multiplied by its error, again and again. Nothing in it is random, and
//! the result depends on the Courant number alone.
//!
//! The band ends at 18 kHz on the papers' grid (5 mm, 340 m/s), that is at 3.78 cells per wavelength, on every grid.
//!
//! The 13-point scheme has two coefficients to spare. They are found in the same way, but for the group velocity, by
//! which an echo appears at its place, and up to 13 kHz (5.23 cells per wavelength). The group velocity's error is the
//! derivative of `k` times that of the phase velocity, so it is linear in the coefficients too.

use std::f64::consts::{FRAC_PI_4, TAU};

/// Wave number at the band's edge in radians per cell.
pub(super) const BAND_EDGE: f64 = TAU * 18e3 / 340.0 * 0.005;

/// The same for the 13-point scheme.
pub(super) const NARROW_BAND_EDGE: f64 = TAU * 13e3 / 340.0 * 0.005;

const WAVE_NUMBERS: usize = 40;
/// From an axis to a diagonal; the other directions are their mirror images.
const DIRECTIONS: usize = 9;
const ITERATIONS: usize = 100;
/// Weights sum to one.
const LEAST_WEIGHT: f64 = 1e-30;

/// Error at one point of the band: `constant` plus the coefficients' parts.
struct BandPoint<const N: usize> {
    constant: f64,
    parts: [f64; N],
}

impl BandPoint<4> {
    fn phase(courant: f64, k: f64, angle_rad: f64) -> Self {
        let (sin, cos) = angle_rad.sin_cos();
        let a = 4.0 * (0.5 * k * cos).sin().powi(2);
        let b = 4.0 * (0.5 * k * sin).sin().powi(2);
        let phase = courant * k;
        let per = 1.0 / (2.0 * phase * phase.sin());
        let target = 4.0 * (0.5 * phase).sin().powi(2);
        Self {
            constant: (courant * courant * (a + b) - target) * per,
            parts: [
                -(a * a + b * b) * per,
                -a * b * per,
                (a * a * a + b * b * b) * per,
                a * b * (a + b) * per,
            ],
        }
    }
}

impl BandPoint<2> {
    /// Error of the group velocity of the scheme without third powers, between two wave numbers of the phase
    /// velocity's.
    fn group(courant: f64, k: [f64; 2], angle_rad: f64) -> Self {
        let [low, high] = k.map(|k| (k, BandPoint::phase(courant, k, angle_rad)));
        let slope = |of: &dyn Fn(&BandPoint<4>) -> f64| {
            (high.0 * of(&high.1) - low.0 * of(&low.1)) / (high.0 - low.0)
        };
        Self {
            constant: slope(&|point| point.constant),
            parts: [
                slope(&|point| point.parts[0]),
                slope(&|point| point.parts[1]),
            ],
        }
    }
}

impl<const N: usize> BandPoint<N> {
    fn error(&self, coefficients: &[f64; N]) -> f64 {
        let parts = self.parts.iter().zip(coefficients);
        self.constant + parts.map(|(part, x)| part * x).sum::<f64>()
    }
}

/// Coefficients of `A^2 + B^2`, `AB`, `A^3 + B^3` and `A^2 B + A B^2` at Courant number `courant`.
pub(super) fn coefficients(courant: f64) -> [f64; 4] {
    least_largest(&points(BAND_EDGE, |k, angle_rad| {
        BandPoint::phase(courant, k, angle_rad)
    }))
}

/// Coefficients of `A^2 + B^2` and `AB` at Courant number `courant`, without any others.
pub(super) fn narrow_coefficients(courant: f64) -> [f64; 2] {
    let half = 0.5 * NARROW_BAND_EDGE / WAVE_NUMBERS as f64;
    least_largest(&points(NARROW_BAND_EDGE - half, |k, angle_rad| {
        BandPoint::group(courant, [k - half, k + half], angle_rad)
    }))
}

/// Points of a band from its edge downwards, in all directions.
fn points<const N: usize>(
    edge: f64,
    point: impl Fn(f64, f64) -> BandPoint<N>,
) -> Vec<BandPoint<N>> {
    (1..=WAVE_NUMBERS)
        .flat_map(|i| (0..DIRECTIONS).map(move |j| (i, j)))
        .map(|(i, j)| {
            let k = edge * i as f64 / WAVE_NUMBERS as f64;
            let angle_rad = FRAC_PI_4 * j as f64 / (DIRECTIONS - 1) as f64;
            point(k, angle_rad)
        })
        .collect()
}

/// Coefficients that make the largest error over the points least.
fn least_largest<const N: usize>(points: &[BandPoint<N>]) -> [f64; N] {
    let mut weights = vec![1.0 / points.len() as f64; points.len()];
    let mut best = ([0.0; N], f64::INFINITY);
    for _ in 0..ITERATIONS {
        let found = least_squares(points, &weights);
        let errors: Vec<f64> = points
            .iter()
            .map(|point| point.error(&found).abs())
            .collect();
        let largest = errors.iter().copied().fold(0.0, f64::max);
        if largest < best.1 {
            best = (found, largest);
        }
        let sum: f64 = weights.iter().zip(&errors).map(|(w, e)| w * e).sum();
        for (weight, error) in weights.iter_mut().zip(&errors) {
            // Points that do not count must not reach the slow subnormal numbers.
            *weight = (*weight * error / sum).max(LEAST_WEIGHT);
        }
    }
    best.0
}

/// Minimum of the weighted sum of squared errors, by the normal equations and Gauss-Jordan elimination. They are
/// positive definite, the parts being independent functions: no pivot is zero.
fn least_squares<const N: usize>(points: &[BandPoint<N>], weights: &[f64]) -> [f64; N] {
    let mut rows = [[0.0; N]; N];
    let mut right = [0.0; N];
    for (point, weight) in points.iter().zip(weights) {
        for ((row, sum), part) in rows.iter_mut().zip(&mut right).zip(point.parts) {
            for (entry, other) in row.iter_mut().zip(point.parts) {
                *entry += weight * part * other;
            }
            *sum -= weight * part * point.constant;
        }
    }
    for i in 0..N {
        let (pivot, pivot_right) = (rows[i], right[i]);
        for k in (0..N).filter(|&k| k != i) {
            let factor = rows[k][i] / pivot[i];
            for (value, from) in rows[k].iter_mut().zip(pivot) {
                *value -= factor * from;
            }
            right[k] -= factor * pivot_right;
        }
    }
    std::array::from_fn(|i| right[i] / rows[i][i])
}
