//! Time scaling of a block at many ratios by one windowed sinc, eq. (2).
//!
//! The value of a band-limited signal at the position `n + u`, `|u| <= 1/2`, is a sum of samples around n, weighted
//! by h(u - m). As a function of u each weight is smooth, and a polynomial of degree 7 approximates it: h(u - m) =
//! sum_p a_p(m) u^p (a Farrow structure). The filters a_p do not depend on the ratio. A block is therefore filtered
//! eight times (one forward FFT, four complex inverse ones), after which every ratio costs eight multiplications a
//! sample, however long the sinc is. The sinc is long enough for an error below -60 dB up to 0.475 of the sample
//! rate.

use std::f64::consts::PI;
use std::sync::Arc;

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use super::spectrum::{fast_length, multiply};
use crate::simd::vectorized;

/// Polynomial coefficients in the fraction of a sample.
const BRANCHES: usize = 8;

/// Samples that the sinc reaches to each side.
pub const HALF_WIDTH: usize = 64;

/// Shape of the Kaiser window: side lobes below -80 dB.
const KAISER_BETA: f64 = 8.0;

/// Outputs kept beyond the ends of the block, where the tapering sinc is not yet zero.
const MARGIN: usize = 64;

/// Windowed-sinc weight at a distance of `x` samples.
pub fn kernel(x: f64) -> f64 {
    let ratio = x / (HALF_WIDTH as f64 + 0.5);
    if ratio.abs() >= 1.0 {
        return 0.0;
    }
    let sinc = if x.abs() < 1e-12 {
        1.0
    } else {
        (PI * x).sin() / (PI * x)
    };
    sinc * bessel_i0(KAISER_BETA * (1.0 - ratio * ratio).sqrt()) / bessel_i0(KAISER_BETA)
}

/// Modified Bessel function of the first kind and order zero, by its power series.
fn bessel_i0(x: f64) -> f64 {
    let quarter = 0.25 * x * x;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..64 {
        term *= quarter / f64::from(k * k);
        sum += term;
    }
    sum
}

/// A plan of the filters for one block length.
pub struct TimeScaler {
    block_length: usize,
    transform_length: usize,
    forward: Arc<dyn Fft<f32>>,
    inverse: Arc<dyn Fft<f32>>,
    /// Spectra a_p + i a_(p+1) of two filters each: one complex inverse transform gives two real signals.
    pairs: Vec<Vec<Complex<f32>>>,
}

/// A filtered block: written by [`TimeScaler::prepare`], read by [`TimeScaler::fold`]. Owned by the caller and
/// reused.
pub struct Branches {
    spectrum: Vec<Complex<f32>>,
    product: Vec<Complex<f32>>,
    work: Vec<Complex<f32>>,
    signals: Vec<Vec<f32>>,
}

impl TimeScaler {
    /// Plans the filters for blocks of `block_length` samples.
    pub fn new(block_length: usize) -> Self {
        let transform_length = fast_length(block_length + 2 * (MARGIN + HALF_WIDTH));
        let mut planner = FftPlanner::<f32>::new();
        let mut exact = FftPlanner::<f64>::new();
        let forward_f64 = exact.plan_fft_forward(transform_length);
        let coefficients = branch_coefficients();
        let pairs = (0..BRANCHES / 2)
            .map(|pair| {
                let mut taps = vec![Complex::new(0.0_f64, 0.0); transform_length];
                for (tap, polynomial) in coefficients.iter().enumerate() {
                    // The sample at offset m contributes a_p(m); as a convolution the tap sits at -m.
                    let offset = tap as isize - HALF_WIDTH as isize;
                    let place = (-offset).rem_euclid(transform_length as isize) as usize;
                    let scale = 1.0 / transform_length as f64;
                    taps[place] =
                        Complex::new(polynomial[2 * pair], polynomial[2 * pair + 1]) * scale;
                }
                forward_f64.process(&mut taps);
                taps.iter()
                    .map(|value| Complex::new(value.re as f32, value.im as f32))
                    .collect()
            })
            .collect();
        Self {
            block_length,
            transform_length,
            forward: planner.plan_fft_forward(transform_length),
            inverse: planner.plan_fft_inverse(transform_length),
            pairs,
        }
    }

    /// Buffers for one filtered block.
    pub fn branches(&self) -> Branches {
        let zero = Complex::new(0.0, 0.0);
        let work = self
            .forward
            .get_inplace_scratch_len()
            .max(self.inverse.get_inplace_scratch_len());
        Branches {
            spectrum: vec![zero; self.transform_length],
            product: vec![zero; self.transform_length],
            work: vec![zero; work],
            signals: vec![vec![0.0; self.block_length + 2 * MARGIN]; BRANCHES],
        }
    }

    /// Filters a block, zero beyond its ends, for [`Self::fold`]. Missing samples count as zero, surplus ones are
    /// ignored.
    pub fn prepare(&self, block: &[f32], branches: &mut Branches) {
        let zero = Complex::new(0.0, 0.0);
        branches.spectrum.fill(zero);
        for (place, &sample) in branches
            .spectrum
            .iter_mut()
            .zip(block.iter().take(self.block_length))
        {
            place.re = sample;
        }
        self.forward
            .process_with_scratch(&mut branches.spectrum, &mut branches.work);
        for (pair, filter) in self.pairs.iter().enumerate() {
            multiply(&branches.spectrum, filter, &mut branches.product);
            self.inverse
                .process_with_scratch(&mut branches.product, &mut branches.work);
            // Signals start MARGIN samples before the block: the end of the circular transform.
            let (body, tail) = (
                &branches.product[..self.block_length + MARGIN],
                self.transform_length - MARGIN,
            );
            let head = &branches.product[tail..];
            if let [real, imaginary] = &mut branches.signals[2 * pair..2 * pair + 2] {
                separate(head, &mut real[..MARGIN], &mut imaginary[..MARGIN]);
                separate(body, &mut real[MARGIN..], &mut imaginary[MARGIN..]);
            }
        }
    }

    /// Resamples the prepared block at the ratio `1 + excess` about the position `origin` (in samples), eq. (2), and
    /// adds up its periods: `folded[k]` becomes the sum over the periods j of the block at `origin + (1 + excess) (j
    /// L_s + k - origin)`.
    ///
    /// Positions beyond the block read zero.
    pub fn fold(&self, branches: &Branches, origin: f64, excess: f64, folded: &mut [f32]) {
        let period = folded.len();
        folded.fill(0.0);
        let mut start = 0;
        while start < self.block_length {
            let lag = excess * (start as f64 - origin);
            let shift = lag.round();
            let place = start % period;
            let mut end = (start + period - place).min(self.block_length);
            if excess != 0.0 {
                // The whole part of the lag stays the same until the lag passes the next half sample.
                let edge = origin + (shift + 0.5_f64.copysign(excess)) / excess;
                end = end.min((edge.ceil().max(0.0) as usize).max(start + 1));
            }
            let first = start as i64 + shift as i64 + MARGIN as i64;
            let available = branches.signals[0].len() as i64;
            // Outside the kept signals everything is zero.
            let skip = (-first).clamp(0, (end - start) as i64);
            let count = ((end - start) as i64 - skip)
                .min(available - first - skip)
                .max(0) as usize;
            let skip = skip as usize;
            if count > 0 {
                let from = (first + skip as i64) as usize;
                let target = &mut folded[place + skip..place + skip + count];
                accumulate(
                    &branches.signals,
                    from,
                    lag - shift + excess * skip as f64,
                    excess,
                    target,
                );
            }
            start = end;
        }
    }
}

/// Real and imaginary parts.
fn separate(values: &[Complex<f32>], real: &mut [f32], imaginary: &mut [f32]) {
    vectorized(|| {
        for ((value, re), im) in values.iter().zip(real).zip(imaginary) {
            (*re, *im) = (value.re, value.im);
        }
    });
}

/// Adds the polynomial in the fraction `fraction + slope i` to every output i.
fn accumulate(signals: &[Vec<f32>], from: usize, fraction: f64, slope: f64, target: &mut [f32]) {
    let count = target.len();
    let (fraction, slope) = (fraction as f32, slope as f32);
    let part = |branch: usize| &signals[branch][from..from + count];
    let (s0, s1, s2, s3) = (part(0), part(1), part(2), part(3));
    let (s4, s5, s6, s7) = (part(4), part(5), part(6), part(7));
    vectorized(|| {
        for (i, out) in target.iter_mut().enumerate() {
            let u = fraction + slope * (i as i32 as f32);
            let high = ((s7[i] * u + s6[i]) * u + s5[i]) * u + s4[i];
            *out += (((high * u + s3[i]) * u + s2[i]) * u + s1[i]) * u + s0[i];
        }
    });
}

/// Polynomial coefficients a_p(m) in u of the weight h(u - m) for every offset m from -HALF_WIDTH.
fn branch_coefficients() -> Vec<[f64; BRANCHES]> {
    // Interpolation at the Chebyshev nodes of [-1/2, 1/2]; the system is solved once in double precision.
    let nodes: Vec<f64> = (0..BRANCHES)
        .map(|i| 0.5 * (PI * (i as f64 + 0.5) / BRANCHES as f64).cos())
        .collect();
    (0..=2 * HALF_WIDTH)
        .map(|tap| {
            let offset = tap as f64 - HALF_WIDTH as f64;
            let mut divided: Vec<f64> = nodes.iter().map(|u| kernel(u - offset)).collect();
            for level in 1..BRANCHES {
                for i in (level..BRANCHES).rev() {
                    divided[i] = (divided[i] - divided[i - 1]) / (nodes[i] - nodes[i - level]);
                }
            }
            // Newton form to powers of u, from the innermost bracket outwards.
            let mut polynomial = [0.0; BRANCHES];
            for i in (0..BRANCHES).rev() {
                for power in (1..BRANCHES).rev() {
                    polynomial[power] = polynomial[power - 1] - nodes[i] * polynomial[power];
                }
                polynomial[0] = divided[i] - nodes[i] * polynomial[0];
            }
            polynomial
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest error of a resampled tone against the exact one, relative to its amplitude, away from the ends.
    fn error_of_tone(frequency: f64, excess: f64) -> f64 {
        let (length, origin) = (8192, 4096.0);
        let resampler = TimeScaler::new(length);
        let mut branches = resampler.branches();
        let tone = |position: f64| (2.0 * PI * frequency * position + 0.3).sin();
        let block: Vec<f32> = (0..length).map(|k| tone(k as f64) as f32).collect();
        resampler.prepare(&block, &mut branches);
        let mut folded = vec![0.0; length];
        resampler.fold(&branches, origin, excess, &mut folded);
        (200..length - 200)
            .map(|k| {
                (f64::from(folded[k]) - tone(origin + (1.0 + excess) * (k as f64 - origin))).abs()
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn tones_up_to_nineteen_of_twenty_kilohertz_keep_an_error_below_minus_60_db() {
        for excess in [0.0, 1.2e-3, -2.4e-3, 7.0e-3] {
            for frequency_hz in [
                100.0, 1000.0, 5000.0, 10_000.0, 15_000.0, 18_000.0, 19_000.0,
            ] {
                let error = error_of_tone(frequency_hz / 40_000.0, excess);
                let level_db = 20.0 * error.max(1e-12).log10();
                assert!(
                    level_db < -60.0,
                    "{frequency_hz} Hz, ratio 1 + {excess}: {level_db:.1} dB"
                );
            }
        }
    }

    #[test]
    fn folding_agrees_with_the_plain_windowed_sinc() {
        let (period, periods) = (300, 3);
        let length = period * periods;
        let resampler = TimeScaler::new(length);
        let mut branches = resampler.branches();
        let block: Vec<f32> = (0..length)
            .map(|k| ((k * k) as f32 * 0.01).sin() + (k as f32 * 0.7).cos())
            .collect();
        resampler.prepare(&block, &mut branches);
        let mut folded = vec![0.0; period];
        for (origin, excess) in [
            (450.0, 0.0),
            (450.0, 0.01),
            (450.0, -0.02),
            (0.0, 0.013),
            (0.0, -0.5),
        ] {
            resampler.fold(&branches, origin, excess, &mut folded);
            let plain = crate::reference::resample_and_fold(&block, origin, excess, period);
            for (fast, slow) in folded.iter().zip(&plain) {
                assert!(
                    (f64::from(*fast) - slow).abs() < 2e-4,
                    "{fast} is not {slow} at {excess}"
                );
            }
        }
    }
}
