//! The Doppler bank: delay and bearing of the echoes in one block, eqs. (1)-(3).
//!
//! For each direction pi n / N_theta the block is resampled at the ratio that cancels the Doppler effect of an echo from
//! there, eq. (2) and (3), its M periods are added up, and one period of the sum is correlated with the transmitted one,
//! eq. (1). The envelope of the correlation is the magnitude of its analytic signal, which costs nothing in the frequency
//! domain: the spectrum's negative half is left out.
//!
//! The transmitted signal is periodic, so the correlation is circular with L_s lags. Resampling about the block's centre
//! leaves an echo at the delay that it has there; the lag is then the delay itself, because a block starts with a period.

use std::f64::consts::PI;
use std::sync::Arc;

use ndarray::Array2;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use crate::error::Error;
use crate::parameters::{Parameters, TimeReference};
use crate::resample::{Branches, Resampler};
use crate::waveform::transmit_period;

/// Everything that is planned once for a set of parameters.
pub struct DopplerBank {
    period: usize,
    block_length: usize,
    delays: usize,
    directions: usize,
    /// Delays to both sides over which the largest envelope counts.
    pool: usize,
    speed_of_sound_mps: f64,
    /// Position in the block, in samples, that the resampling leaves in place.
    origin: f64,
    resampler: Resampler,
    forward: Arc<dyn Fft<f32>>,
    inverse: Arc<dyn Fft<f32>>,
    /// Conjugate spectrum of one transmitted period, lines 1 to L_s/2, scaled so that an echo of amplitude 1 gives 1.
    replica: Vec<Complex<f32>>,
}

/// Buffers of [`DopplerBank::measure`], owned by the caller and reused from block to block.
pub struct DopplerScratch {
    branches: Branches,
    folded: [Vec<f32>; 2],
    spectrum: Vec<Complex<f32>>,
    analytic: Vec<Complex<f32>>,
    envelope: Vec<f32>,
    work: Vec<Complex<f32>>,
}

impl DopplerBank {
    /// Plans the bank.
    ///
    /// # Errors
    /// Those of [`Parameters::check`].
    pub fn new(parameters: &Parameters) -> Result<Self, Error> {
        parameters.check()?;
        let period = parameters.samples_per_period();
        let block_length = parameters.periods * period;
        let mut planner = FftPlanner::<f32>::new();
        Ok(Self {
            period,
            block_length,
            delays: parameters.delays(),
            directions: parameters.directions,
            pool: parameters.delay_of_range(parameters.range_pool_m),
            speed_of_sound_mps: parameters.speed_of_sound_mps,
            origin: match parameters.time_reference {
                TimeReference::Centre => 0.5 * block_length as f64,
                TimeReference::Start => 0.0,
            },
            resampler: Resampler::new(block_length),
            forward: planner.plan_fft_forward(period),
            inverse: planner.plan_fft_inverse(period),
            replica: matched_filter(&transmit_period(parameters), parameters.periods),
        })
    }

    /// Buffers for [`Self::measure`].
    pub fn scratch(&self) -> DopplerScratch {
        let zero = Complex::new(0.0, 0.0);
        let work = self
            .forward
            .get_inplace_scratch_len()
            .max(self.inverse.get_inplace_scratch_len());
        DopplerScratch {
            branches: self.resampler.branches(),
            folded: [vec![0.0; self.period], vec![0.0; self.period]],
            spectrum: vec![zero; self.period],
            analytic: vec![zero; self.period],
            envelope: vec![0.0; (self.delays + self.pool).min(self.period)],
            work: vec![zero; work],
        }
    }

    /// An intensity of the right shape: `[N_theta + 1, delays]`.
    pub fn intensity(&self) -> Array2<f32> {
        Array2::zeros((self.directions + 1, self.delays))
    }

    /// Samples of one block, M L_s.
    pub fn block_length(&self) -> usize {
        self.block_length
    }

    /// Eq. (3): the sampling ratio of direction n at the speed `v_mps`, less one.
    pub fn excess(&self, v_mps: f64, direction: usize) -> f64 {
        let approach = v_mps * (PI * direction as f64 / self.directions as f64).cos();
        -2.0 * approach / (self.speed_of_sound_mps + approach)
    }

    /// Eqs. (1)-(3): the envelope H of every direction and delay.
    ///
    /// `block` holds M periods that start with a period; `v_mps` is the speed along the heading during it. `intensity` is
    /// `[direction, delay in samples]` and 1 for an echo of amplitude 1. Rows that `intensity` has too many stay as
    /// they are.
    pub fn measure(
        &self,
        block: &[f32],
        v_mps: f64,
        scratch: &mut DopplerScratch,
        intensity: &mut Array2<f32>,
    ) {
        self.resampler.prepare(block, &mut scratch.branches);
        for first in (0..=self.directions).step_by(2) {
            // Two real signals share one complex transform.
            let pair = first..=(first + 1).min(self.directions);
            for (direction, folded) in pair.clone().zip(&mut scratch.folded) {
                self.resampler.fold(
                    &scratch.branches,
                    self.origin,
                    self.excess(v_mps, direction),
                    folded,
                );
            }
            let [real, imaginary] = &scratch.folded;
            for ((line, &re), &im) in scratch.spectrum.iter_mut().zip(real).zip(imaginary) {
                *line = Complex::new(re, im);
            }
            self.forward
                .process_with_scratch(&mut scratch.spectrum, &mut scratch.work);
            for direction in pair {
                self.correlate(&scratch.spectrum, direction % 2 == 1, &mut scratch.analytic);
                self.inverse
                    .process_with_scratch(&mut scratch.analytic, &mut scratch.work);
                for (out, value) in scratch.envelope.iter_mut().zip(&scratch.analytic) {
                    *out = (value.re * value.re + value.im * value.im).sqrt();
                }
                pool(
                    &scratch.envelope,
                    self.pool,
                    intensity.row_mut(direction).into_slice(),
                );
            }
        }
    }

    /// One-sided spectrum of the correlation of one of the two signals whose joint spectrum is given.
    fn correlate(&self, joint: &[Complex<f32>], second: bool, analytic: &mut [Complex<f32>]) {
        analytic.fill(Complex::new(0.0, 0.0));
        for (index, weight) in self.replica.iter().enumerate() {
            let line = index + 1;
            let (here, mirrored) = (joint[line], joint[self.period - line].conj());
            let own = if second {
                (here - mirrored) * Complex::new(0.0, -0.5)
            } else {
                (here + mirrored) * 0.5
            };
            analytic[line] = own * weight;
        }
    }
}

/// The largest of the values up to `reach` places away, for the first places of `envelope`.
fn pool(envelope: &[f32], reach: usize, pooled: Option<&mut [f32]>) {
    // A row of a standard array is contiguous; only a caller's own exotic layout is not, and stays as it is.
    let Some(pooled) = pooled else {
        return;
    };
    let count = pooled.len().min(envelope.len());
    let pooled = &mut pooled[..count];
    pooled.copy_from_slice(&envelope[..count]);
    for shift in 1..=reach {
        let after = envelope.get(shift..).unwrap_or(&[]);
        let before = pooled.get_mut(shift..).unwrap_or(&mut []);
        for (value, &other) in before.iter_mut().zip(envelope) {
            *value = if other > *value { other } else { *value };
        }
        for (value, &other) in pooled.iter_mut().zip(after) {
            *value = if other > *value { other } else { *value };
        }
    }
}

/// Conjugate spectrum of the transmitted period with the scale of the inverse transform, the sum over M periods and the
/// analytic signal (factor 2); the mean and the line at half the sample rate carry no envelope and are left out.
fn matched_filter(transmitted: &[f64], periods: usize) -> Vec<Complex<f32>> {
    let mut spectrum: Vec<Complex<f64>> = transmitted
        .iter()
        .map(|&sample| Complex::new(sample, 0.0))
        .collect();
    FftPlanner::new()
        .plan_fft_forward(spectrum.len())
        .process(&mut spectrum);
    let energy: f64 = transmitted.iter().map(|sample| sample * sample).sum();
    let scale = 2.0 / (energy * periods as f64 * transmitted.len() as f64);
    spectrum[1..transmitted.len().div_ceil(2)]
        .iter()
        .map(|line| Complex::new((line.re * scale) as f32, (-line.im * scale) as f32))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pooling_takes_the_largest_neighbour() {
        let envelope = [0.0, 5.0, 0.0, 0.0, 0.0, 2.0, 0.0, 3.0];
        let mut pooled = [0.0; 6];
        for (reach, expected) in [
            (0, [0.0, 5.0, 0.0, 0.0, 0.0, 2.0]),
            (1, [5.0, 5.0, 5.0, 0.0, 2.0, 2.0]),
            (2, [5.0, 5.0, 5.0, 5.0, 2.0, 3.0]),
            (99, [5.0; 6]),
        ] {
            pool(&envelope, reach, Some(&mut pooled));
            assert_eq!(pooled, expected, "reach {reach}");
        }
    }
}
