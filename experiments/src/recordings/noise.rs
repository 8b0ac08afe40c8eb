//! White noise at the microphone, eqs. (19)-(21) of the 2024 paper.

use localizer::random;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;

/// White noise added to a recording. Noises of one number have the same samples at every level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Noise {
    /// Ratio of the power of the reflected signal to that of the noise, decibels.
    pub snr_db: f64,
    /// Number of the noise.
    pub trial: u64,
}

/// Added to the number of a noise for that of the mapping drive, so that both drives have samples of their own.
const OF_MAPPING: u64 = 1 << 32;

impl Noise {
    /// The noise of the mapping drive that goes with this one of the localization drive.
    pub fn of_mapping(self) -> Self {
        Self {
            trial: self.trial + OF_MAPPING,
            ..self
        }
    }

    /// Samples of variance 1.
    pub fn samples(&self, length: usize) -> Vec<f64> {
        let mut random = random::stream(random::trial_seed("noise", "", self.trial), "microphone");
        (0..length)
            .map(|_| StandardNormal.sample(&mut random))
            .collect()
    }

    /// Factor of the samples with which `snr_db` is the ratio of the power of `signal - direct` (eq. (20)) to theirs
    /// (eq. (21)).
    pub fn level(&self, signal: &[f32], direct: &[f32], samples: &[f64]) -> f64 {
        let reflected: f64 = signal
            .iter()
            .zip(direct)
            .map(|(all, direct)| f64::from(all - direct).powi(2))
            .sum();
        let power: f64 = samples.iter().map(|sample| sample * sample).sum();
        (reflected / power.max(f64::MIN_POSITIVE) / 10_f64.powf(0.1 * self.snr_db)).sqrt()
    }

    /// Adds the noise to a signal whose direct wave is `direct`.
    pub fn add_to(&self, signal: &mut [f32], direct: &[f32]) {
        let samples = self.samples(signal.len());
        let level = self.level(signal, direct, &samples);
        for (value, sample) in signal.iter_mut().zip(&samples) {
            *value += (level * sample) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_asked_power() {
        let direct: Vec<f32> = (0..20_000).map(|k| (k as f32 * 0.7).sin()).collect();
        let echoes: Vec<f32> = (0..20_000).map(|k| 0.1 * (k as f32 * 0.3).sin()).collect();
        let clean: Vec<f32> = direct.iter().zip(&echoes).map(|(a, b)| a + b).collect();
        let with = |snr_db, trial| {
            let mut noisy = clean.clone();
            Noise { snr_db, trial }.add_to(&mut noisy, &direct);
            noisy
        };
        let noisy = with(6.0, 1);
        let power = |values: &mut dyn Iterator<Item = f32>| {
            values.map(|value| f64::from(value * value)).sum::<f64>()
        };
        let noise = power(&mut noisy.iter().zip(&clean).map(|(a, b)| a - b));
        let snr_db = 10.0 * (power(&mut echoes.iter().copied()) / noise).log10();
        assert!((snr_db - 6.0).abs() < 0.01, "{snr_db}");
        assert_eq!(with(6.0, 1), noisy);
        assert_ne!(with(6.0, 2), noisy);
    }
}
