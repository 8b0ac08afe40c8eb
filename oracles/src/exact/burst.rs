//! A short tone with a Gaussian envelope: smooth, of finite length within the rounding of `f64`, with a known spectrum.

use fdtd::waveform::PeriodicWaveform;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Beyond this many standard deviations the envelope is below 1e-15.
const REACH_SIGMAS: f64 = 8.4;

/// `exp(-(t - centre)^2 / (2 sigma^2)) cos(2 pi f (t - centre))`, peak 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Burst {
    /// Frequency of the tone in hertz.
    pub frequency_hz: f64,
    /// Time of the peak in seconds.
    pub centre_s: f64,
    /// Standard deviation of the envelope in seconds; the spectrum's is `1 / (2 pi sigma)` hertz.
    pub sigma_s: f64,
}

impl Burst {
    /// A burst that starts at time 0 and whose spectrum has the standard deviation `spread_hz`.
    pub fn from_zero(frequency_hz: f64, spread_hz: f64) -> Self {
        let sigma_s = 1.0 / (TAU * spread_hz);
        Self {
            frequency_hz,
            centre_s: REACH_SIGMAS * sigma_s,
            sigma_s,
        }
    }

    /// Value at a time.
    pub fn value(&self, t_s: f64) -> f64 {
        let since_s = t_s - self.centre_s;
        (-0.5 * (since_s / self.sigma_s).powi(2)).exp() * (TAU * self.frequency_hz * since_s).cos()
    }

    /// The burst repeated every `period_s` seconds (up to a sample at `rate_hz`) and limited to a band, for simulations
    /// that end before the second one.
    pub fn every(&self, period_s: f64, band_hz: [f64; 2], rate_hz: f64) -> PeriodicWaveform {
        let one: Vec<f64> = (0..(period_s * rate_hz) as usize)
            .map(|n| self.value(n as f64 / rate_hz))
            .collect();
        PeriodicWaveform::with_band(&one, one.len() as f64 / rate_hz, band_hz, rate_hz)
    }

    /// First and last time in seconds at which it is not negligible.
    pub fn support_s(&self) -> [f64; 2] {
        let reach_s = REACH_SIGMAS * self.sigma_s;
        [self.centre_s - reach_s, self.centre_s + reach_s]
    }

    /// Fourier transform, the integral of `value(t) e^(-i omega t)`, in seconds.
    pub fn spectrum(&self, omega_radps: f64) -> Complex<f64> {
        let half = |omega: f64| (-0.5 * (omega * self.sigma_s).powi(2)).exp();
        let tone = TAU * self.frequency_hz;
        let size =
            0.5 * self.sigma_s * TAU.sqrt() * (half(omega_radps - tone) + half(omega_radps + tone));
        Complex::from_polar(size, -omega_radps * self.centre_s)
    }
}
