//! Decimation: tones through the filter, plain convolution as oracle, refusals.

use fdtd::decimate::{Decimator, decimate};
use std::f64::consts::TAU;

fn tone(frequency_hz: f64, rate_hz: f64, count: usize) -> Vec<f32> {
    (0..count)
        .map(|n| (TAU * frequency_hz * n as f64 / rate_hz + 0.3).cos() as f32)
        .collect()
}

/// Rates of a field and a microphone with a band each: whole, rational and awkward ratios.
const RATES: [(f64, f64, f64); 6] = [
    (1.0 / 8.333333333333333e-6, 40e3, 19e3),
    (100e3, 50e3, 19e3),
    (120e3, 50e3, 24e3),
    (150e3, 40e3, 18e3),
    (1.0 / 8.3e-6, 40e3, 19e3),
    (130e3 * std::f64::consts::SQRT_2 / 1.4, 44.1e3, 20e3),
];

#[test]
fn tones_in_the_band_pass_without_delay() {
    for (field_rate_hz, sample_rate_hz, band_hz) in RATES {
        let count = 40_000;
        let decimator = Decimator::new(field_rate_hz, sample_rate_hz, band_hz).unwrap();
        for part in [0.0, 0.01, 0.5, 0.9, 0.99, 1.0] {
            let frequency_hz = part * band_hz;
            let output = decimator.apply(&tone(frequency_hz, field_rate_hz, count));
            let edge = (decimator.reach() as f64 * sample_rate_hz / field_rate_hz) as usize + 2;
            for (k, &value) in output
                .iter()
                .enumerate()
                .skip(edge)
                .take(output.len() - 2 * edge)
            {
                let expected = (TAU * frequency_hz * k as f64 / sample_rate_hz + 0.3).cos();
                // 0.01 dB is 1.15e-3; the filter does far better.
                assert!(
                    (f64::from(value) - expected).abs() < 1.2e-4,
                    "{frequency_hz} Hz at {field_rate_hz} -> {sample_rate_hz}"
                );
            }
        }
    }
}

#[test]
fn tones_that_would_fall_into_the_band_are_gone() {
    for (field_rate_hz, sample_rate_hz, band_hz) in RATES {
        let decimator = Decimator::new(field_rate_hz, sample_rate_hz, band_hz).unwrap();
        let highest_hz = 0.5 * field_rate_hz;
        for part in [0.0, 0.01, 0.1, 0.5, 0.9] {
            let lowest_hz = sample_rate_hz - band_hz;
            let frequency_hz = lowest_hz + part * (highest_hz - lowest_hz);
            let output = decimator.apply(&tone(frequency_hz, field_rate_hz, 40_000));
            let edge = decimator.reach();
            let peak = output[edge..output.len() - edge]
                .iter()
                .fold(0.0_f32, |peak, value| peak.max(value.abs()));
            assert!(
                peak < 1e-4,
                "{frequency_hz} Hz: {:.1} dB",
                20.0 * peak.log10()
            );
        }
    }
}

#[test]
fn outputs_are_those_of_a_plain_convolution() {
    // Impulses read the filter out; two outputs at the same place after an input see the same filter.
    let decimator = Decimator::new(120e3, 40e3, 19e3).unwrap();
    let reach = decimator.reach();
    let impulse_at = |n: usize| {
        let mut field = vec![0.0_f32; 3000];
        field[n] = 1.0;
        decimator.apply(&field)
    };
    // h[d]: weight of the input d samples after the output.
    let weight = |d: isize| f64::from(impulse_at((1500 + d) as usize)[500]);
    let weights: Vec<f64> = (-(reach as isize)..=reach as isize).map(weight).collect();
    for d in 0..=reach {
        assert!(
            (weights[reach + d] - weights[reach - d]).abs() < 1e-7,
            "symmetric, hence without delay"
        );
    }
    let field: Vec<f32> = (0..3000).map(|n| ((n * n) as f32 * 0.001).sin()).collect();
    let output = decimator.apply(&field);
    assert_eq!(output.len(), 1000);
    for (k, &value) in output.iter().enumerate() {
        let plain: f64 = weights
            .iter()
            .enumerate()
            .filter_map(|(i, weight)| {
                (3 * k + i)
                    .checked_sub(reach)
                    .and_then(|n| field.get(n))
                    .map(|&x| weight * f64::from(x))
            })
            .sum();
        assert!((f64::from(value) - plain).abs() < 1e-5, "output {k}");
    }
}

#[test]
fn lengths_and_equal_rates() {
    let field = tone(440.0, 40e3, 100);
    assert_eq!(decimate(&field, 40e3, 40e3, 19e3).unwrap(), field);
    assert!(decimate(&[], 120e3, 40e3, 19e3).unwrap().is_empty());
    assert_eq!(decimate(&[1.0], 120e3, 40e3, 19e3).unwrap().len(), 1);
    assert_eq!(
        decimate(
            &vec![0.0; 5_400_001],
            1.0 / 8.333333333333333e-6,
            40e3,
            19e3
        )
        .unwrap()
        .len(),
        1_800_001
    );
}

#[test]
fn rates_and_bands_that_do_not_fit_are_refused() {
    for (field_rate_hz, sample_rate_hz, band_hz, named) in [
        (120e3, 40e3, 20e3, "band_hz"),
        (120e3, 40e3, f64::NAN, "band_hz"),
        (120e3, 130e3, 19e3, "sample_rate_hz"),
        (120e3, 0.0, 19e3, "sample_rate_hz"),
        (f64::INFINITY, 40e3, 19e3, "field_rate_hz"),
    ] {
        let message = decimate(&[0.0; 9], field_rate_hz, sample_rate_hz, band_hz)
            .unwrap_err()
            .to_string();
        assert!(message.contains(named), "{message}");
    }
}
