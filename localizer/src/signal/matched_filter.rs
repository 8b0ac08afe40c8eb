//! Matched filter, eq. (1): correlation of one received period with the transmitted one, and its envelope.
//!
//! The transmitted signal is periodic, so the correlation is circular with L_s lags, of which only those of the
//! ranges in use are needed. A period is therefore continued by as many of its own samples as there are lags, and
//! correlated linearly by transforms whose length has small factors, whatever those of L_s are.
//!
//! The envelope is the magnitude of the analytic signal, that is, of the correlation with the analytic signal of the
//! transmitted period. Two real signals x and y share one transform, as x + i y: the correlation with the analytic
//! replica a is c_x + i c_y and that with the conjugate of a is conj(c_x) + i conj(c_y); sum and difference separate
//! the two.

use std::sync::Arc;

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use super::spectrum::{fast_length, multiply};
use crate::simd::vectorized;

/// A plan of the correlation with one transmitted period.
pub(crate) struct MatchedFilter {
    period: usize,
    lags: usize,
    forward: Arc<dyn Fft<f32>>,
    inverse: Arc<dyn Fft<f32>>,
    /// Conjugate spectra of the analytic replica and of its conjugate, scaled so that an echo of amplitude 1 gives 1.
    replicas: [Vec<Complex<f32>>; 2],
}

/// Buffers of [`MatchedFilter::correlate`], owned by the caller and reused.
pub(crate) struct MatchedFilterScratch {
    joint: Vec<Complex<f32>>,
    products: [Vec<Complex<f32>>; 2],
    work: Vec<Complex<f32>>,
}

impl MatchedFilterScratch {
    /// The first `count` lags of the products.
    fn lags(&self, count: usize) -> [&[Complex<f32>]; 2] {
        self.products.each_ref().map(|product| &product[..count])
    }
}

impl MatchedFilter {
    /// Plans the correlation with `transmitted` over the first `lags` lags (at most one period). Signals are sums
    /// over `periods` periods.
    pub(crate) fn new(transmitted: &[f64], periods: usize, lags: usize) -> Self {
        let period = transmitted.len();
        let length = fast_length(period + lags.saturating_sub(1));
        let energy: f64 = transmitted.iter().map(|sample| sample * sample).sum();
        let scale = 0.5 / (energy * periods as f64 * length as f64);
        let analytic = analytic(transmitted);
        let exact = FftPlanner::new().plan_fft_forward(length);
        let replicas = [1.0, -1.0].map(|sign| {
            let mut taps = vec![Complex::new(0.0, 0.0); length];
            for (tap, value) in taps.iter_mut().zip(&analytic) {
                *tap = Complex::new(value.re, sign * value.im) * scale;
            }
            exact.process(&mut taps);
            taps.iter()
                .map(|line| Complex::new(line.re as f32, -line.im as f32))
                .collect()
        });
        let mut planner = FftPlanner::new();
        Self {
            period,
            lags,
            forward: planner.plan_fft_forward(length),
            inverse: planner.plan_fft_inverse(length),
            replicas,
        }
    }

    /// Buffers for [`Self::correlate`].
    pub(crate) fn scratch(&self) -> MatchedFilterScratch {
        let buffer = || vec![Complex::new(0.0, 0.0); self.forward.len()];
        let (forward, inverse) = (&self.forward, &self.inverse);
        let work = forward
            .get_inplace_scratch_len()
            .max(inverse.get_inplace_scratch_len());
        MatchedFilterScratch {
            joint: buffer(),
            products: [buffer(), buffer()],
            work: vec![Complex::new(0.0, 0.0); work],
        }
    }

    /// Correlates two signals of one period each; linear in the signals. [`Self::envelopes`] reads the result.
    pub(crate) fn correlate(&self, signals: &[Vec<f32>; 2], scratch: &mut MatchedFilterScratch) {
        let MatchedFilterScratch {
            joint,
            products,
            work,
        } = scratch;
        let [first, second] = signals;
        for ((value, &re), &im) in joint.iter_mut().zip(first).zip(second) {
            *value = Complex::new(re, im);
        }
        joint.copy_within(..self.lags.saturating_sub(1), self.period);
        joint[self.period + self.lags.saturating_sub(1)..].fill(Complex::new(0.0, 0.0));
        self.forward.process_with_scratch(joint, work);
        for (product, replica) in products.iter_mut().zip(&self.replicas) {
            multiply(joint, replica, product);
            self.inverse.process_with_scratch(product, work);
        }
    }

    /// The envelopes, over the lags, of the two signals that were correlated last.
    pub(crate) fn envelopes(&self, scratch: &MatchedFilterScratch, envelopes: &mut [Vec<f32>; 2]) {
        let [with, against] = scratch.lags(self.lags);
        let [first, second] = envelopes;
        vectorized(|| {
            let pairs = with.iter().zip(against);
            for ((one, other), (&with, &against)) in first.iter_mut().zip(second).zip(pairs) {
                [*one, *other] = magnitudes(with, against);
            }
        });
    }

    /// [`Self::envelopes`] of the signals of `scratch` plus `level` times those of `noise`.
    pub(crate) fn envelopes_of_sum(
        &self,
        scratch: &MatchedFilterScratch,
        noise: &MatchedFilterScratch,
        level: f32,
        envelopes: &mut [Vec<f32>; 2],
    ) {
        let [with, against] = scratch.lags(self.lags);
        let [noise_with, noise_against] = noise.lags(self.lags);
        let [first, second] = envelopes;
        vectorized(|| {
            let pairs = with.iter().zip(against);
            let noises = noise_with.iter().zip(noise_against);
            let envelopes = first.iter_mut().zip(second);
            for ((envelopes, (with, against)), (noise_with, noise_against)) in
                envelopes.zip(pairs).zip(noises)
            {
                [*envelopes.0, *envelopes.1] =
                    magnitudes(with + noise_with * level, against + noise_against * level);
            }
        });
    }
}

/// Magnitudes of the analytic correlations of the two signals behind a pair of products.
fn magnitudes(with: Complex<f32>, against: Complex<f32>) -> [f32; 2] {
    let against = against.conj();
    [with + against, with - against].map(|value| value.norm_sqr().sqrt())
}

/// Analytic signal of a periodic signal. The mean and the line at half the sample rate carry no envelope and are left
/// out.
fn analytic(signal: &[f64]) -> Vec<Complex<f64>> {
    let period = signal.len();
    let mut planner = FftPlanner::new();
    let mut lines: Vec<Complex<f64>> = signal.iter().map(|&s| Complex::new(s, 0.0)).collect();
    planner.plan_fft_forward(period).process(&mut lines);
    for (line, value) in lines.iter_mut().enumerate() {
        let kept = (1..period.div_ceil(2)).contains(&line);
        *value *= if kept { 2.0 / period as f64 } else { 0.0 };
    }
    planner.plan_fft_inverse(period).process(&mut lines);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference;

    /// The correlation by its sum, the envelope by the naive analytic signal.
    fn plain(signal: &[f32], transmitted: &[f64], periods: usize) -> Vec<f64> {
        let period = transmitted.len();
        let energy: f64 = transmitted.iter().map(|sample| sample * sample).sum();
        let correlation: Vec<f64> = (0..period)
            .map(|lag| {
                let products =
                    (0..period).map(|k| f64::from(signal[(k + lag) % period]) * transmitted[k]);
                products.sum::<f64>() / (energy * periods as f64)
            })
            .collect();
        reference::envelope(&correlation)
    }

    #[test]
    fn two_signals_at_once_have_the_envelopes_of_the_circular_sums() {
        for (period, lags) in [(124, 50), (124, 124), (93, 1), (155, 154)] {
            let transmitted: Vec<f64> = (0..period)
                .map(|k| ((k * k) as f64 * 0.37).sin() + 0.2)
                .collect();
            let signals = [0.11, 0.73].map(|a: f32| -> Vec<f32> {
                (0..period).map(|k| ((k * k) as f32 * a).cos()).collect()
            });
            let correlator = MatchedFilter::new(&transmitted, 3, lags);
            let mut scratch = correlator.scratch();
            let mut envelopes = [vec![0.0; lags], vec![0.0; lags]];
            for _ in 0..2 {
                correlator.correlate(&signals, &mut scratch);
                correlator.envelopes(&scratch, &mut envelopes);
            }
            for (signal, envelope) in signals.iter().zip(&envelopes) {
                for (fast, slow) in envelope.iter().zip(plain(signal, &transmitted, 3)) {
                    assert!(
                        (f64::from(*fast) - slow).abs() < 1e-5,
                        "{fast} is not {slow} at {period}, {lags}"
                    );
                }
            }
        }
    }
}
