//! The loudspeaker's periodic waveform, band-limited, at any time.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::f64::consts::{PI, TAU};

/// Width in hertz of the raised-cosine taper inside each edge of the band.
const TAPER_HZ: f64 = 1e3;
/// Points of the interpolating polynomial.
const POINTS: usize = 8;
/// Largest phase advance of the highest frequency from one entry of the table to the next, in radians. The eight-point
/// polynomial is then wrong by less than `PHASE_STEP^8 / 936 = 2.8e-9` of a component's amplitude.
const PHASE_STEP: f64 = 0.2;

/// A periodic waveform given by the samples of one period, limited to a band.
///
/// Its value at any time is that of the Fourier sum over the harmonics `k / period` (k below half the number of
/// samples), each times [`band_gain`], to better than 1e-7 of the sum's amplitude.
#[derive(Debug, Clone)]
pub struct PeriodicWaveform {
    period_s: f64,
    /// Entries of one period, the first at time 0; `POINTS` more on either side save the wrapping.
    table: Vec<f64>,
    entries: usize,
}

impl PeriodicWaveform {
    /// The waveform through one period of samples (the first at time 0, evenly over `period_s` seconds), limited
    /// to frequencies below `band_hz`.
    ///
    /// Frequencies within 1 kHz of the band's upper edge are tapered to zero there by a raised cosine, all lower ones
    /// keep their amplitude and phase. When the field's rate times the period is a whole number, the table holds the
    /// value at every step of the field itself. No samples, or a period that is not positive, give silence.
    pub fn new(
        samples_one_period: &[f64],
        period_s: f64,
        band_hz: f64,
        field_rate_hz: f64,
    ) -> Self {
        Self::with_band(samples_one_period, period_s, [0.0, band_hz], field_rate_hz)
    }

    /// As [`PeriodicWaveform::new`] with a lower edge too: see [`band_gain`].
    pub fn with_band(
        samples_one_period: &[f64],
        period_s: f64,
        band_hz: [f64; 2],
        field_rate_hz: f64,
    ) -> Self {
        let count = samples_one_period.len();
        if count == 0 || !(period_s.is_finite() && period_s > 0.0) {
            return Self::silence();
        }
        let harmonics = harmonics(samples_one_period, period_s, band_hz);
        let entries = table_length(harmonics.len(), period_s, field_rate_hz);
        let mut spectrum = vec![Complex::new(0.0, 0.0); entries];
        for (k, &value) in harmonics.iter().enumerate() {
            spectrum[k] = value;
        }
        FftPlanner::new()
            .plan_fft_inverse(entries)
            .process(&mut spectrum);
        let wrapped = |index: usize| spectrum[index % entries].re;
        let first = entries - POINTS % entries;
        Self {
            period_s,
            table: (first..first + entries + 2 * POINTS).map(wrapped).collect(),
            entries,
        }
    }

    fn silence() -> Self {
        Self {
            period_s: 1.0,
            table: vec![0.0; 1 + 2 * POINTS],
            entries: 1,
        }
    }

    /// Length of the period in seconds.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Value at any time, in the unit of the samples. Times that are not finite give zero.
    pub fn value(&self, t_s: f64) -> f64 {
        if !t_s.is_finite() {
            return 0.0;
        }
        let place = t_s.rem_euclid(self.period_s) / self.period_s * self.entries as f64;
        let left = (place.floor() as usize).min(self.entries);
        let fraction = place - left as f64;
        let first = left + POINTS - (POINTS / 2 - 1);
        let weights = lagrange_weights(fraction);
        let window = &self.table[first..first + POINTS];
        window
            .iter()
            .zip(weights)
            .map(|(value, weight)| value * weight)
            .sum()
    }

    /// Root of the mean square over a period.
    pub fn rms(&self) -> f64 {
        let sum: f64 = self.one_period().iter().map(|value| value * value).sum();
        (sum / self.entries as f64).sqrt()
    }

    /// Largest magnitude over a period, on the table's entries.
    pub fn peak(&self) -> f64 {
        self.one_period()
            .iter()
            .fold(0.0, |peak, value| peak.max(value.abs()))
    }

    /// Values of one period, evenly spaced from time 0, as finely as the table is: several per step of the field.
    pub fn one_period(&self) -> &[f64] {
        &self.table[POINTS..POINTS + self.entries]
    }
}

/// Gain at a frequency for a band in hertz: one inside, zero outside, and a raised cosine over the 1 kHz inside the
/// upper edge (and inside a lower edge above zero, over 1 kHz or as much as the edge's frequency).
pub fn band_gain(frequency_hz: f64, band_hz: [f64; 2]) -> f64 {
    let [low, high] = band_hz;
    // From 0 to 1 as `depth`, the distance inside the edge, goes from 0 to `width`.
    let rise = |depth: f64, width: f64| 0.5 - 0.5 * (PI * (depth / width).clamp(0.0, 1.0)).cos();
    if frequency_hz >= high || frequency_hz < low {
        return 0.0;
    }
    let upper = rise(high - frequency_hz, TAPER_HZ);
    let lower = if low > 0.0 {
        rise(frequency_hz - low, TAPER_HZ.min(low))
    } else {
        1.0
    };
    upper * lower
}

/// Complex amplitudes such that the waveform is the real part of `sum_k a[k] exp(2 pi i k t / period)`.
fn harmonics(samples: &[f64], period_s: f64, band_hz: [f64; 2]) -> Vec<Complex<f64>> {
    let count = samples.len();
    let mut spectrum: Vec<Complex<f64>> = samples
        .iter()
        .map(|&sample| Complex::new(sample, 0.0))
        .collect();
    FftPlanner::new()
        .plan_fft_forward(count)
        .process(&mut spectrum);
    // The harmonic at half the sampling rate has no phase of its own and is left out.
    spectrum.truncate(count.div_ceil(2));
    for (k, value) in spectrum.iter_mut().enumerate() {
        let both_sides = if k == 0 { 1.0 } else { 2.0 };
        *value *= both_sides / count as f64 * band_gain(k as f64 / period_s, band_hz);
    }
    let used = spectrum
        .iter()
        .rposition(|value| value.norm_sqr() > 0.0)
        .map_or(1, |last| last + 1);
    spectrum.truncate(used);
    spectrum
}

/// Entries of the table: fine enough for the highest harmonic, and a multiple of the field's steps per period where
/// those are whole.
fn table_length(harmonics: usize, period_s: f64, field_rate_hz: f64) -> usize {
    let least = (TAU * harmonics as f64 / PHASE_STEP)
        .ceil()
        .max(POINTS as f64);
    let steps = field_rate_hz * period_s;
    let whole = steps.round();
    let fits = whole >= 1.0 && whole <= 64.0 * least && (steps - whole).abs() <= 1e-9 * whole;
    if fits {
        ((least / whole).ceil() * whole) as usize
    } else {
        least as usize
    }
}

/// Weights of the polynomial through entries -3..=4 at `fraction` between entries 0 and 1.
fn lagrange_weights(fraction: f64) -> [f64; POINTS] {
    /// 1 / product over the other nodes of (node - other).
    const SCALE: [f64; POINTS] = [
        -1.0 / 5040.0,
        1.0 / 720.0,
        -1.0 / 240.0,
        1.0 / 144.0,
        -1.0 / 144.0,
        1.0 / 240.0,
        -1.0 / 720.0,
        1.0 / 5040.0,
    ];
    let mut weights = SCALE;
    let mut before = 1.0;
    let mut after = 1.0;
    for index in 0..POINTS {
        weights[index] *= before;
        before *= fraction + 3.0 - index as f64;
        let mirrored = POINTS - 1 - index;
        weights[mirrored] *= after;
        after *= fraction + 3.0 - mirrored as f64;
    }
    weights
}
