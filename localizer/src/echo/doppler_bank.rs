//! The Doppler bank: delay and bearing of the echoes in one block, eqs. (1)-(3).
//!
//! For each direction pi n / N_theta the block is resampled at the ratio that cancels the Doppler effect of an echo
//! from there, eqs. (2) and (3), its M periods are added up, and one period of the sum is correlated with the
//! transmitted one, eq. (1).
//!
//! Resampling about the block's centre leaves an echo at the delay that it has there; the lag is then the delay
//! itself, because a block starts with a period.

use std::f64::consts::PI;

use ndarray::Array2;

use crate::error::Error;
use crate::parameters::{Parameters, TimeReference};
use crate::signal::matched_filter::{MatchedFilter, MatchedFilterScratch};
use crate::signal::time_scale::{Branches, TimeScaler};
use crate::signal::waveform;

/// A plan of eqs. (1)-(3) for one set of parameters.
///
/// ```
/// use localizer::Parameters;
/// use localizer::echo::DopplerBank;
/// use localizer::signal::waveform::transmit_period;
///
/// // A robot at rest and an echo 100 samples late.
/// let parameters = Parameters::default();
/// let period = transmit_period(&parameters.signal);
/// let bank = DopplerBank::new(&parameters)?;
/// let block: Vec<f32> = (0..bank.block_length())
///     .map(|k| period[(k + period.len() - 100) % period.len()] as f32)
///     .collect();
/// let mut intensity = bank.intensity();
/// bank.measure(&block, 0.0, &mut bank.scratch(), &mut intensity);
/// assert!((intensity[[0, 100]] - 1.0).abs() < 0.1);
/// assert!(intensity[[0, 200]] < 0.1);
/// # Ok::<(), localizer::Error>(())
/// ```
pub struct DopplerBank {
    period: usize,
    block_length: usize,
    delays: usize,
    /// Lags whose envelopes are needed.
    lags: usize,
    directions: usize,
    /// Delays to both sides over which the largest envelope counts.
    pool: usize,
    speed_of_sound_mps: f64,
    /// Position in the block, in samples, that the time scaling leaves in place.
    origin: f64,
    resampler: TimeScaler,
    correlator: MatchedFilter,
}

/// Buffers of [`DopplerBank::measure`], owned by the caller and reused from block to block.
pub struct DopplerScratch {
    branches: Branches,
    folded: [Vec<f32>; 2],
    correlation: MatchedFilterScratch,
    envelopes: [Vec<f32>; 2],
}

impl DopplerBank {
    /// Plans the bank.
    ///
    /// # Errors
    /// Those of [`Parameters::check`].
    pub fn new(parameters: &Parameters) -> Result<Self, Error> {
        parameters.check()?;
        let period = parameters.samples_per_period();
        let block_length = parameters.measurement.periods * period;
        let (delays, pool) = (
            parameters.delays(),
            parameters
                .signal
                .delay_of_range(parameters.measurement.range_pool_m),
        );
        let lags = (delays + pool).min(period);
        Ok(Self {
            period,
            block_length,
            delays,
            lags,
            directions: parameters.measurement.directions,
            pool,
            speed_of_sound_mps: parameters.signal.speed_of_sound_mps,
            origin: match parameters.measurement.time_reference {
                TimeReference::Centre => 0.5 * block_length as f64,
                TimeReference::Start => 0.0,
            },
            resampler: TimeScaler::new(block_length),
            correlator: MatchedFilter::new(
                &waveform::transmitted(parameters),
                parameters.measurement.periods,
                lags,
            ),
        })
    }

    /// Buffers for [`Self::measure`].
    pub fn scratch(&self) -> DopplerScratch {
        DopplerScratch {
            branches: self.resampler.branches(),
            folded: [vec![0.0; self.period], vec![0.0; self.period]],
            correlation: self.correlator.scratch(),
            envelopes: [vec![0.0; self.lags], vec![0.0; self.lags]],
        }
    }

    /// A zero intensity of the right shape: `[N_theta + 1, delays]`.
    pub fn intensity(&self) -> Array2<f32> {
        Array2::zeros((self.directions + 1, self.delays))
    }

    /// Samples of one block, M L_s.
    pub fn block_length(&self) -> usize {
        self.block_length
    }

    /// Eq. (3): the sampling ratio of direction n at the speed `v_mps`, minus 1.
    pub fn excess(&self, v_mps: f64, direction: usize) -> f64 {
        let approach = v_mps * (PI * direction as f64 / self.directions as f64).cos();
        -2.0 * approach / (self.speed_of_sound_mps + approach)
    }

    /// Eqs. (1)-(3): the envelope H of every direction and delay.
    ///
    /// `block` holds M periods and starts with the start of one; `v_mps` is the mean speed along the heading.
    /// `intensity` is `[direction, delay in samples]`, 1 for an echo of amplitude 1. Surplus rows of `intensity` are
    /// left as they are.
    pub fn measure(
        &self,
        block: &[f32],
        v_mps: f64,
        scratch: &mut DopplerScratch,
        intensity: &mut Array2<f32>,
    ) {
        self.prepare(block, scratch);
        for first in Self::pairs(self.directions) {
            self.correlate(first, v_mps, scratch);
            let DopplerScratch {
                correlation,
                envelopes,
                ..
            } = scratch;
            self.correlator.envelopes(correlation, envelopes);
            self.store(first, envelopes, intensity);
        }
    }

    /// The first of every two directions of `0..=directions`; two directions share their transforms.
    pub(crate) fn pairs(directions: usize) -> impl Iterator<Item = usize> {
        (0..=directions).step_by(2)
    }

    /// Prepares a block for [`Self::correlate`].
    pub(crate) fn prepare(&self, block: &[f32], scratch: &mut DopplerScratch) {
        self.resampler.prepare(block, &mut scratch.branches);
    }

    /// Eqs. (1)-(3) up to the envelope, for direction `first` and the next one of the prepared block.
    pub(crate) fn correlate(&self, first: usize, v_mps: f64, scratch: &mut DopplerScratch) {
        for (direction, folded) in (first..=self.directions).zip(&mut scratch.folded) {
            self.resampler.fold(
                &scratch.branches,
                self.origin,
                self.excess(v_mps, direction),
                folded,
            );
        }
        self.correlator
            .correlate(&scratch.folded, &mut scratch.correlation);
    }

    /// Writes the envelopes of `signal + level noise`, both correlated, as [`Self::measure`] does those of a signal:
    /// all steps before the envelope are linear.
    pub(crate) fn store_sum(
        &self,
        first: usize,
        signal: &DopplerScratch,
        noise: &mut DopplerScratch,
        level: f32,
        intensity: &mut Array2<f32>,
    ) {
        let DopplerScratch {
            correlation,
            envelopes,
            ..
        } = noise;
        self.correlator
            .envelopes_of_sum(&signal.correlation, correlation, level, envelopes);
        self.store(first, envelopes, intensity);
    }

    /// Writes the envelopes of direction `first` and the next one, pooled, to their rows.
    fn store(&self, first: usize, envelopes: &[Vec<f32>; 2], intensity: &mut Array2<f32>) {
        for (direction, envelope) in (first..=self.directions).zip(envelopes) {
            pool(
                envelope,
                self.pool,
                intensity.row_mut(direction).into_slice(),
            );
        }
    }
}

/// For the first values of `envelope`, the largest within `reach` of each.
fn pool(envelope: &[f32], reach: usize, pooled: Option<&mut [f32]>) {
    // A row of a standard array is contiguous; other layouts are left as they are.
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
