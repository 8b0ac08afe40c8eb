//! Correlation of whole periods with the transmitted one, all lags or the direct wave's alone.

use std::f64::consts::TAU;
use std::sync::Arc;

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use crate::error::Error;
use crate::parameters::Parameters;
use crate::signal::waveform;

/// The transmitted period as an analytic signal, prepared for correlation.
pub(super) struct Replica {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// Conjugate spectrum, scaled so that an echo of amplitude 1 gives 1.
    conjugate: Vec<Complex<f64>>,
    /// The direct wave's analytic period, conjugate, with the same scale.
    direct: Vec<Complex<f32>>,
    work: Vec<Complex<f64>>,
    /// Centroid of the power over frequency in Hz: a small delay turns the correlation by this frequency's phase.
    pub(super) centroid_hz: f64,
    /// Samples of the direct wave's way.
    pub(super) direct_lag: f64,
}

impl Replica {
    /// Prepares the period of checked parameters.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a silent period.
    pub(super) fn new(parameters: &Parameters) -> Result<Self, Error> {
        let [forward_m, left_m] = parameters.signal.sensor_baseline_m;
        let way_s = forward_m.hypot(left_m) / parameters.signal.speed_of_sound_mps;
        Self::with_lag(parameters, way_s * parameters.signal.sample_rate_hz)
    }

    /// As [`Self::new`] with another lag of the direct wave, in samples.
    pub(super) fn with_lag(parameters: &Parameters, direct_lag: f64) -> Result<Self, Error> {
        let transmitted = waveform::transmitted(parameters);
        let length = transmitted.len();
        let rate_hz = parameters.signal.sample_rate_hz;
        let mut planner = FftPlanner::new();
        let forward = planner.plan_fft_forward(length);
        let inverse = planner.plan_fft_inverse(length);
        let mut spectrum: Vec<Complex<f64>> = transmitted
            .iter()
            .map(|&sample| Complex::new(sample, 0.0))
            .collect();
        forward.process(&mut spectrum);
        // The analytic signal has positive frequencies alone, and no mean.
        let mut moment = [0.0; 2];
        for (k, line) in spectrum.iter_mut().enumerate() {
            if k == 0 || 2 * k >= length {
                *line = Complex::ZERO;
            }
            moment[0] += line.norm_sqr();
            moment[1] += line.norm_sqr() * k as f64 * rate_hz / length as f64;
        }
        if moment[0].is_nan() || moment[0] <= 0.0 {
            let remedy = "give a period with sound in it";
            return Err(Error::invalid(
                "transmitted.wav",
                "samples",
                "are silent",
                remedy,
            ));
        }
        let scale = 1.0 / moment[0];
        let mut direct: Vec<Complex<f64>> = spectrum
            .iter()
            .enumerate()
            .map(|(k, line)| {
                let turn = -TAU * k as f64 * direct_lag / length as f64;
                line * Complex::from_polar(scale, turn)
            })
            .collect();
        inverse.process(&mut direct);
        Ok(Self {
            conjugate: spectrum.iter().map(|line| line.conj() * scale).collect(),
            direct: direct
                .iter()
                .map(|value| Complex::new(value.re as f32, -value.im as f32))
                .collect(),
            work: vec![Complex::ZERO; length],
            centroid_hz: moment[1] / moment[0],
            direct_lag,
            forward,
            inverse,
        })
    }

    /// The correlation with one period at all lags.
    pub(super) fn correlate(&mut self, period: &[f32]) -> &[Complex<f64>] {
        for (value, &sample) in self.work.iter_mut().zip(period) {
            *value = Complex::new(f64::from(sample), 0.0);
        }
        self.forward.process(&mut self.work);
        for (value, weight) in self.work.iter_mut().zip(&self.conjugate) {
            *value *= weight;
        }
        self.inverse.process(&mut self.work);
        &self.work
    }

    /// The correlation with one period at the direct wave's lag.
    pub(super) fn direct(&self, period: &[f32]) -> Complex<f64> {
        let mut sums = [[0.0_f32; 8]; 2];
        let mut total = Complex::new(0.0_f64, 0.0);
        // Short sums in single precision side by side, their sum in double precision.
        for (samples, values) in period.chunks(64).zip(self.direct.chunks(64)) {
            for (index, (sample, value)) in samples.iter().zip(values).enumerate() {
                sums[0][index % 8] += sample * value.re;
                sums[1][index % 8] += sample * value.im;
            }
            let [re, im] = sums.map(|parts| f64::from(parts.iter().sum::<f32>()));
            total += Complex::new(re, im);
            sums = [[0.0; 8]; 2];
        }
        total
    }
}

/// The middle of some values; 0 without any.
pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Intercept and slope of the line through `[place, value]` by least squares; level with fewer than two places.
pub(super) fn line(points: &[[f64; 2]]) -> [f64; 2] {
    let count = points.len().max(1) as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let spread: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
    let joint: f64 = points
        .iter()
        .map(|point| (point[0] - x) * (point[1] - y))
        .sum();
    let slope = if spread > 0.0 { joint / spread } else { 0.0 };
    [y - slope * x, slope]
}
