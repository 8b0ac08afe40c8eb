//! The periodic waveform against the plain Fourier sum.

use fdtd::waveform::{PeriodicWaveform, band_gain};
use std::f64::consts::TAU;

/// Samples of a rough periodic signal, the same on every run.
fn rough(count: usize) -> Vec<f64> {
    let mut state = 12345_u64;
    (0..count)
        .map(|_| {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            if state >> 63 == 0 { 1.0 } else { -1.0 }
        })
        .collect()
}

/// The band-limited Fourier sum at time `t_s`, harmonic by harmonic.
fn fourier_sum(samples: &[f64], period_s: f64, band_hz: [f64; 2], t_s: f64) -> f64 {
    let count = samples.len();
    let mut value = 0.0;
    for k in 0..count.div_ceil(2) {
        let gain =
            band_gain(k as f64 / period_s, band_hz) / count as f64 * if k == 0 { 1.0 } else { 2.0 };
        if gain == 0.0 {
            continue;
        }
        for (n, sample) in samples.iter().enumerate() {
            value +=
                gain * sample * (TAU * k as f64 * (t_s / period_s - n as f64 / count as f64)).cos();
        }
    }
    value
}

#[test]
fn values_are_those_of_the_fourier_sum() {
    let samples = rough(372);
    let period_s = 372.0 / 40e3;
    for (band_hz, field_rate_hz) in [
        ([0.0, 19e3], 120e3),
        ([500.0, 18e3], 100e3),
        ([0.0, 19e3], 123_456.7),
        ([0.0, 50e3], 120e3),
    ] {
        let waveform = PeriodicWaveform::with_band(&samples, period_s, band_hz, field_rate_hz);
        for k in -20..60 {
            let t_s = f64::from(k) * 2.3457e-4;
            let error = waveform.value(t_s) - fourier_sum(&samples, period_s, band_hz, t_s);
            assert!(error.abs() < 1e-7, "{error} at {t_s}");
        }
    }
}

#[test]
fn the_table_is_at_the_rate_of_the_field() {
    let samples = rough(4092);
    // The step of a scene file, not exactly 1/120 kHz.
    let field_rate_hz = 1.0 / 8.333333333333333e-6;
    let waveform = PeriodicWaveform::new(&samples, 0.1023, 19e3, field_rate_hz);
    let per_step = waveform.one_period().len() / 12276;
    assert_eq!(waveform.one_period().len() % 12276, 0);
    for step in [0_usize, 1, 777, 12275, 12276, 5_400_000] {
        let entry = waveform.one_period()[step % 12276 * per_step];
        assert!((waveform.value(step as f64 / field_rate_hz) - entry).abs() < 1e-6);
    }
}

#[test]
fn tones_in_the_band_keep_their_amplitude_and_those_beyond_are_gone() {
    let period_s = 0.01;
    for (frequency_hz, gain, field_rate_hz) in [
        (0.0, 1.0, 120e3),
        (100.0, 1.0, 96e3),
        (10e3, 1.0, 132e3),
        (17.9e3, 1.0, 115.2e3),
        (18.5e3, 0.5, 160e3),
        (19e3, 0.0, 110e3),
        (19.9e3, 0.0, 192e3),
    ] {
        let samples: Vec<f64> = (0..400)
            .map(|n| (TAU * frequency_hz * f64::from(n) / 40e3).cos())
            .collect();
        let waveform = PeriodicWaveform::new(&samples, period_s, 19e3, field_rate_hz);
        for n in 0..300 {
            let t_s = f64::from(n) * 1.37e-5;
            assert!((waveform.value(t_s) - gain * (TAU * frequency_hz * t_s).cos()).abs() < 1e-7);
        }
        assert!((waveform.peak() - gain).abs() < 0.02);
        assert!(
            (waveform.rms()
                - if frequency_hz == 0.0 {
                    1.0
                } else {
                    gain * 0.5_f64.sqrt()
                })
            .abs()
                < 1e-6
        );
    }
}

#[test]
fn it_repeats_and_bad_input_gives_silence() {
    for (samples, field_rate_hz) in [(4092, 120e3), (2044, 132e3), (8188, 110e3)] {
        let period_s = samples as f64 / 40e3;
        let waveform = PeriodicWaveform::new(&rough(samples), period_s, 19e3, field_rate_hz);
        for k in 0..200 {
            let t_s = f64::from(k) * 5.1e-4;
            assert!((waveform.value(t_s) - waveform.value(t_s + 440.0 * period_s)).abs() < 1e-6);
            assert!((waveform.value(t_s) - waveform.value(t_s - period_s)).abs() < 1e-9);
        }
    }
    let waveform = PeriodicWaveform::new(&rough(372), 0.0093, 19e3, 120e3);
    assert_eq!(waveform.value(f64::NAN), 0.0);
    for silent in [
        PeriodicWaveform::new(&[], 0.1, 19e3, 120e3),
        PeriodicWaveform::new(&[1.0, 2.0], f64::NAN, 19e3, 120e3),
        PeriodicWaveform::new(&[1.0, -1.0], 0.1, 19e3, f64::NAN),
    ] {
        assert_eq!(silent.value(0.123), 0.0);
    }
}
