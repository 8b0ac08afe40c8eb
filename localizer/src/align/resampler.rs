//! Samples between the samples, at any position and any ratio, by a windowed sinc.
//!
//! The weights of a position between two samples are read from a table of [`PHASES`] positions and interpolated
//! linearly, which leaves -90 dB; the sinc itself leaves -60 dB up to 0.475 of the lower of the two rates.

use crate::signal::time_scale::{HALF_WIDTH, kernel};

/// Tabulated positions between two samples.
const PHASES: usize = 512;

/// A place between samples, exact however far it is from the first.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Position {
    /// Whole samples.
    pub whole: i64,
    /// What is left, 0 to 1.
    pub fraction: f64,
}

impl Position {
    /// The position `samples` after the first sample.
    pub fn at(samples: f64) -> Self {
        Self::default().plus(samples)
    }

    /// The position `samples` further on.
    pub fn plus(self, samples: f64) -> Self {
        let sum = self.fraction + samples;
        Self {
            whole: self.whole + sum.floor() as i64,
            fraction: sum - sum.floor(),
        }
    }

    /// Samples since the first.
    pub fn samples(self) -> f64 {
        self.whole as f64 + self.fraction
    }

    /// The same place counted from another first sample.
    pub fn since(self, first: i64) -> Self {
        Self {
            whole: self.whole - first,
            ..self
        }
    }
}

/// A table of weights for one ratio of rates.
#[derive(Debug, Clone)]
pub struct Resampler {
    /// Weights of `2 reach` samples a phase, `PHASES + 1` phases.
    weights: Vec<f32>,
    reach: usize,
}

impl Resampler {
    /// Weights for steps of `step` input samples an output sample; steps above 1 also limit the band.
    pub fn new(step: f64) -> Self {
        // A clock's drift is no other rate: the band stays whole.
        let share = if step > 1.001 { 1.0 / step } else { 1.0 };
        let reach = ((HALF_WIDTH as f64 + 0.5) / share).ceil() as usize;
        let mut weights = Vec::with_capacity((PHASES + 1) * 2 * reach);
        for phase in 0..=PHASES {
            let fraction = phase as f64 / PHASES as f64;
            weights.extend((0..2 * reach).map(|tap| {
                // Sample `tap` lies at tap + 1 - reach from the one before the position.
                let x = tap as f64 + 1.0 - reach as f64 - fraction;
                (share * kernel(share * x)) as f32
            }));
        }
        Self { weights, reach }
    }

    /// Samples needed to both sides of a position.
    pub fn reach(&self) -> usize {
        self.reach
    }

    /// Fills `output` with the values at `start`, `start + step`, ... (positions in `input`); zero beyond its ends.
    pub fn fill(&self, input: &[f32], start: f64, step: f64, output: &mut [f32]) {
        self.fill_from(input, Position::at(start), step, output);
    }

    /// As [`Self::fill`] from a position whose whole samples do not blur its fraction: the values are the same wherever
    /// `input` begins.
    pub fn fill_from(&self, input: &[f32], start: Position, step: f64, output: &mut [f32]) {
        let width = 2 * self.reach;
        for (k, output) in output.iter_mut().enumerate() {
            let position = start.fraction + step * k as f64;
            let whole = position.floor();
            let phase = (position - whole) * PHASES as f64;
            let first = (phase as usize).min(PHASES - 1);
            let share = (phase - first as f64) as f32;
            let row = &self.weights[first * width..(first + 2) * width];
            let (low, high) = row.split_at(width);
            let from = start.whole + whole as i64 + 1 - self.reach as i64;
            let skip = (-from).clamp(0, width as i64) as usize;
            let end = (input.len() as i64 - from).clamp(skip as i64, width as i64) as usize;
            if skip == end {
                *output = 0.0;
                continue;
            }
            let at = (from + skip as i64) as usize;
            let samples = &input[at..at + end - skip];
            *output = blend(samples, &low[skip..end], &high[skip..end], share);
        }
    }
}

/// The sum of samples times weights, these between two rows. Eight sums side by side, always in the same order.
fn blend(samples: &[f32], low: &[f32], high: &[f32], share: f32) -> f32 {
    let mut sums = [0.0_f32; 8];
    let mut parts = samples.chunks_exact(8);
    let (mut lows, mut highs) = (low.chunks_exact(8), high.chunks_exact(8));
    for ((samples, low), high) in (&mut parts).zip(&mut lows).zip(&mut highs) {
        for i in 0..8 {
            sums[i] += samples[i] * (low[i] + share * (high[i] - low[i]));
        }
    }
    let rest = parts.remainder().iter();
    let rest = rest.zip(lows.remainder()).zip(highs.remainder());
    let tail: f32 = rest
        .map(|((sample, low), high)| sample * (low + share * (high - low)))
        .sum();
    sums.iter().sum::<f32>() + tail
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Largest error of a tone resampled from one rate to another, in decibels below its amplitude.
    fn error_db(from_hz: f64, to_hz: f64, tone_hz: f64) -> f64 {
        let tone = |t_s: f64| (TAU * tone_hz * t_s + 0.4).sin();
        let input: Vec<f32> = (0..20_000)
            .map(|k| tone(k as f64 / from_hz) as f32)
            .collect();
        let step = from_hz / to_hz;
        let mut output = vec![0.0; (18_000.0 / step) as usize];
        let start = 900.3;
        Resampler::new(step).fill(&input, start, step, &mut output);
        let worst = output.iter().enumerate().map(|(k, value)| {
            (f64::from(*value) - tone((start + step * k as f64) / from_hz)).abs()
        });
        20.0 * worst.fold(1e-12, f64::max).log10()
    }

    #[test]
    fn tones_keep_an_error_below_minus_60_db_at_the_rates_of_sound_cards() {
        for (from_hz, to_hz) in [
            (44_100.0, 4512.0 / 0.1023),
            (48_000.0, 4911.0 / 0.1023),
            (96_000.0, 4911.0 / 0.1023),
            (192_000.0, 4911.0 / 0.1023),
            (40_000.4, 4093.0 / 0.1023),
            // Clocks that differ.
            (48_000.0 * (1.0 + 100e-6), 4911.0 / 0.1023),
            (40_000.0 * (1.0 - 100e-6), 40_000.0),
        ] {
            for tone_hz in [100.0, 1000.0, 5000.0, 10_000.0, 15_000.0, 18_500.0] {
                let level_db = error_db(from_hz, to_hz, tone_hz);
                assert!(
                    level_db < -60.0,
                    "{from_hz} Hz, {tone_hz} Hz: {level_db:.1} dB"
                );
            }
        }
    }

    #[test]
    fn a_lower_rate_takes_what_it_cannot_hold_away() {
        let (from_hz, to_hz) = (192_000.0, 4911.0 / 0.1023);
        let input: Vec<f32> = (0..20_000)
            .map(|k| (TAU * 30_000.0 * f64::from(k) / from_hz).sin() as f32)
            .collect();
        let mut output = vec![0.0; 4000];
        Resampler::new(from_hz / to_hz).fill(&input, 1000.0, from_hz / to_hz, &mut output);
        let worst = output
            .iter()
            .fold(0.0_f32, |worst, value| worst.max(value.abs()));
        assert!(worst < 1e-3, "{worst}");
    }

    #[test]
    fn beyond_the_ends_there_is_silence() {
        let mut output = [1.0; 4];
        let resampler = Resampler::new(1.0);
        resampler.fill(&[1.0; 10], -500.0, 0.5, &mut output);
        assert_eq!(output, [0.0; 4]);
        resampler.fill(&[], 0.0, 1.0, &mut output);
        assert_eq!(output, [0.0; 4]);
        resampler.fill(&[0.25; 400], 200.0, 0.3, &mut output);
        assert!(output.iter().all(|value| (value - 0.25).abs() < 1e-3));
    }
}
