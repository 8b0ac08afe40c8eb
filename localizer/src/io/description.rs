//! The description of a transmitted signal, `tx.json` beside `tx.wav`, and one period of another waveform.

use std::path::Path;

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::files;
use super::wav::WavStream;
use crate::error::Error;

/// Largest share of the power outside of the lines of a period.
const MOST_BETWEEN: f64 = 1e-3;

/// Most samples of a waveform's file.
const MOST_SAMPLES: usize = 1 << 25;

/// The code in a file of sound.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransmitDescription {
    /// Chips L of the M-sequence.
    pub code_length: usize,
    /// Chip rate 1/T_c in Hz.
    pub chip_rate_hz: f64,
    /// Carrier frequency f_c in Hz.
    pub carrier_hz: f64,
    /// Rate of the file in Hz.
    pub sample_rate_hz: f64,
    /// Whole periods in it.
    pub periods: usize,
    /// Duration of one period in seconds.
    pub period_s: f64,
    /// Largest sample, decibels of full scale.
    pub level_db: f64,
    /// A digest of the file, by which it is known when it is to be replaced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
}

impl TransmitDescription {
    /// Reads a description.
    ///
    /// # Errors
    /// [`Error`] when it cannot be read or has other fields.
    pub fn read(path: &Path) -> Result<Self, Error> {
        files::read_json(path)
    }

    /// Writes it under a temporary name and renames it.
    ///
    /// # Errors
    /// [`Error::Io`] when that fails.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        files::write_json(path, self)
    }
}

/// One period of a waveform as the lines of its spectrum, from which it follows at any rate.
#[derive(Debug, Clone, PartialEq)]
pub struct PeriodicSpectrum {
    /// Lines of positive frequency, from the mean on; amplitude of the cosine in the real part.
    lines: Vec<Complex<f64>>,
    /// Duration of the period in seconds.
    pub period_s: f64,
}

impl PeriodicSpectrum {
    /// Reads `transmitted.wav`: one period, or as many whole ones of `period_s` as fit.
    ///
    /// # Errors
    /// [`Error`] for a file that cannot be read, is silent, or does not repeat after `period_s`.
    pub fn read(path: &Path, period_s: Option<f64>) -> Result<Self, Error> {
        let refuse = |field: &str, problem: String, remedy: &str| {
            Err(Error::invalid(path.display(), field, problem, remedy))
        };
        let mut stream = WavStream::open(path)?;
        let rate_hz = stream.rate_hz();
        let mut samples = Vec::new();
        while samples.len() < MOST_SAMPLES && stream.read(1 << 16, 1, &mut samples)? > 0 {}
        let length_s = samples.len() as f64 / rate_hz;
        let count = period_s.map_or(1, |period_s| (length_s / period_s).round() as usize);
        let expected = period_s.unwrap_or(length_s) * count as f64 * rate_hz;
        if samples.len() < 16 || count == 0 || (expected - samples.len() as f64).abs() > 0.51 {
            let problem = format!("{} samples are no whole number of periods", samples.len());
            return refuse(
                "samples",
                problem,
                "give exactly one period of the waveform",
            );
        }
        let mut spectrum: Vec<Complex<f64>> = samples
            .iter()
            .map(|&sample| Complex::new(f64::from(sample), 0.0))
            .collect();
        FftPlanner::new()
            .plan_fft_forward(spectrum.len())
            .process(&mut spectrum);
        let half = spectrum.len().div_ceil(2);
        let scale = 2.0 / spectrum.len() as f64;
        let power: f64 = spectrum[1..half].iter().map(Complex::norm_sqr).sum();
        let lines: Vec<Complex<f64>> = spectrum[..half]
            .iter()
            .step_by(count)
            .map(|line| line * scale)
            .collect();
        let kept: f64 = lines[1..]
            .iter()
            .map(|line| line.norm_sqr() / (scale * scale))
            .sum();
        if power.is_nan() || power <= 0.0 {
            return refuse(
                "samples",
                "are silent".to_owned(),
                "give a period with sound in it",
            );
        }
        if kept < (1.0 - MOST_BETWEEN) * power {
            let problem = format!("does not repeat {count} times");
            return refuse(
                "samples",
                problem,
                "give exactly one period of the waveform",
            );
        }
        Ok(Self {
            lines,
            period_s: period_s.unwrap_or(length_s),
        })
    }

    /// Highest frequency below which nearly all of the power lies, in Hz.
    pub fn highest_hz(&self) -> f64 {
        let power: f64 = self.lines[1..].iter().map(Complex::norm_sqr).sum();
        let mut above = 0.0;
        for (k, line) in self.lines.iter().enumerate().rev() {
            above += line.norm_sqr();
            if above > 1e-3 * power {
                return k as f64 / self.period_s;
            }
        }
        0.0
    }

    /// Centre of the power over frequency, in Hz.
    pub fn centroid_hz(&self) -> f64 {
        let lines = || self.lines.iter().enumerate().skip(1);
        let power: f64 = lines().map(|(_, line)| line.norm_sqr()).sum();
        lines()
            .map(|(k, line)| line.norm_sqr() * k as f64)
            .sum::<f64>()
            / power
            / self.period_s
    }

    /// `count` samples of the period, as far as they hold its band.
    pub fn samples(&self, count: usize) -> Vec<f32> {
        let mut spectrum = vec![Complex::ZERO; count];
        for (k, line) in self
            .lines
            .iter()
            .enumerate()
            .skip(1)
            .take_while(|(k, _)| 2 * k < count)
        {
            spectrum[k] = line * 0.5;
            spectrum[count - k] = line.conj() * 0.5;
        }
        FftPlanner::new()
            .plan_fft_inverse(count)
            .process(&mut spectrum);
        spectrum.iter().map(|value| value.re as f32).collect()
    }
}
