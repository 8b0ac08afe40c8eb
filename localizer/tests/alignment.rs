//! Alignment of a sound: domain: a repeated code with a moving echo, through a recorder that starts late and whose
//! clock runs at another rate. The recorder's samples are those of the signal at `(k / rate - late) (1 + drift)`, by
//! a windowed sinc of -60 dB; what is found must be what was put in, and the periods those of the signal.

use localizer::align::{Gap, Resampler, SoundAligner, SoundClock, SoundReport};
use localizer::parameters::SignalParameters;
use localizer::signal::waveform::transmit_period;
use localizer::{Error, Parameters};
use proptest::prelude::*;

/// A code of half the length keeps the tests short: 51 ms a period.
fn parameters(rate_hz: f64) -> Parameters {
    let signal = SignalParameters {
        code_length: 511,
        ..SignalParameters::default()
    };
    let period_s = signal.code_length as f64 / signal.chip_rate_hz;
    let samples = (period_s * rate_hz - 1e-6).ceil();
    let mut parameters = Parameters {
        signal: SignalParameters {
            sample_rate_hz: samples / period_s,
            ..signal
        },
        ..Parameters::default()
    };
    parameters.measurement.max_range_m = 4.0;
    parameters
}

/// The code, and an echo from 1 m ahead of a robot at 0.3 m/s, at 40 kHz.
fn signal(periods: usize) -> Vec<f32> {
    let period: Vec<f32> = transmit_period(&parameters(40_000.0).signal)
        .iter()
        .map(|&sample| sample as f32)
        .collect();
    let length = period.len();
    let direct: Vec<f32> = (0..periods * length).map(|k| period[k % length]).collect();
    let mut echo = vec![0.0; direct.len()];
    let approach = 0.3 / 340.0;
    let delay = 2.0 * 40_000.0 / 340.0;
    Resampler::new(1.0).fill(&direct, -delay, 1.0 + 2.0 * approach, &mut echo);
    direct
        .iter()
        .zip(&echo)
        .map(|(direct, echo)| direct + 0.4 * echo)
        .collect()
}

/// What a recorder makes of it.
fn recorded(signal: &[f32], rate_hz: f64, late_s: f64, drift_ppm: f64, noise: f32) -> Vec<f32> {
    let own_hz = rate_hz * (1.0 + 1e-6 * drift_ppm);
    let step = 40_000.0 / own_hz;
    let count = ((signal.len() as f64 / 40_000.0 + late_s) * own_hz) as usize;
    let mut samples = vec![0.0; count];
    Resampler::new(step).fill(signal, -late_s * 40_000.0, step, &mut samples);
    let mut state = 1_u64;
    for sample in &mut samples {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        *sample += noise * ((state >> 40) as f32 / (1 << 23) as f32 - 1.0);
    }
    samples
}

/// Periods, and which of them were heard.
type Aligned = (Vec<Vec<f32>>, Vec<bool>, SoundReport);

/// Runs a sound through an aligner in pieces of `piece` samples.
fn align(samples: &[f32], rate_hz: f64, clock: SoundClock, piece: usize) -> Result<Aligned, Error> {
    let mut aligner = SoundAligner::new(&parameters(rate_hz), rate_hz, clock)?;
    let (mut periods, mut heard) = (Vec::new(), Vec::new());
    let mut emit = |period: &[f32], is_heard: bool| {
        periods.push(period.to_vec());
        heard.push(is_heard);
        Ok(())
    };
    for piece in samples.chunks(piece) {
        aligner.push(piece, &mut emit)?;
    }
    aligner.finish(&mut emit)?;
    let report = aligner.report().clone();
    Ok((periods, heard, report))
}

const FOUND: SoundClock = SoundClock {
    late_s: None,
    drift_ppm: None,
};

#[test]
fn late_and_drifting_sounds_of_every_rate_are_aligned() {
    let signal = signal(120);
    for (rate_hz, late_s, drift_ppm) in [
        (48_000.0, 0.150, 20.0),
        (44_100.0, 0.0013, -100.0),
        (96_000.0, 0.2, 100.0),
        (192_000.0, 0.037, -3.0),
        (40_000.4, 0.0511, 50.0),
        (40_000.0, 0.0, 0.0),
    ] {
        let samples = recorded(&signal, rate_hz, late_s, drift_ppm, 0.01);
        let (periods, heard, report) = align(&samples, rate_hz, FOUND, 1000).unwrap();
        let case = format!("{rate_hz} Hz, {late_s} s, {drift_ppm} ppm: {report:?}");
        // By the recorder's clock; 10 us are 2 mm.
        let late_s = late_s * (1.0 + 1e-6 * drift_ppm);
        assert!((report.late_s - late_s).abs() < 1e-5, "{case}");
        assert!((report.drift_ppm - drift_ppm).abs() < 1.0, "{case}");
        assert!(
            heard.iter().all(|&heard| heard) && report.gaps.is_empty(),
            "{case}"
        );
        assert!(periods.len() >= 118, "{}, {case}", periods.len());
        // The code of the last period is where the first one's is: 0.3 us are a twentieth of a millimetre.
        let lag = |period: &[f32]| {
            let code = transmit_period(&parameters(rate_hz).signal);
            let shifted = |by: usize| -> f64 {
                let length = code.len();
                (0..length)
                    .map(|k| code[(k + length - by) % length] * f64::from(period[k]))
                    .sum()
            };
            shifted(0)
        };
        let (first, last) = (lag(&periods[1]), lag(&periods[periods.len() - 2]));
        assert!((last / first - 1.0).abs() < 0.05, "{first} {last}, {case}");
    }
}

#[test]
fn pieces_of_any_length_give_the_same_bytes() {
    let samples = recorded(&signal(60), 48_000.0, 0.07, 30.0, 0.01);
    let whole = align(&samples, 48_000.0, FOUND, usize::MAX).unwrap();
    for piece in [1, 64, 2453, 10_000] {
        assert_eq!(
            align(&samples, 48_000.0, FOUND, piece).unwrap(),
            whole,
            "{piece}"
        );
    }
}

#[test]
fn missing_samples_are_told_and_survived() {
    let mut samples = recorded(&signal(120), 48_000.0, 0.05, 20.0, 0.01);
    // 10 ms are lost after 60 periods, and later there is silence for five periods.
    samples.drain(150_000..150_480);
    samples[220_000..220_000 + 5 * 2453].fill(0.0);
    let (periods, heard, report) = align(&samples, 48_000.0, FOUND, 512).unwrap();
    let &[Gap { period, samples }] = report.gaps.as_slice() else {
        panic!("{report:?}");
    };
    assert!(
        (59..=68).contains(&period) && (samples - 480.0).abs() < 2.0,
        "{report:?}"
    );
    let deaf = heard.iter().filter(|heard| !**heard).count();
    assert!((8..=14).contains(&deaf), "{deaf} {report:?}");
    assert!(
        heard[periods.len() - 5..].iter().all(|&heard| heard),
        "{heard:?}"
    );
    assert!((report.drift_ppm - 20.0).abs() < 3.0, "{report:?}");
}

#[test]
fn given_clocks_are_taken_and_impossible_ones_refused() {
    let samples = recorded(&signal(60), 48_000.0, 0.05, 20.0, 0.01);
    let clock = |late_s, drift_ppm| SoundClock { late_s, drift_ppm };
    let (found, _, _) = align(&samples, 48_000.0, FOUND, 999).unwrap();
    let (given, _, report) = align(&samples, 48_000.0, clock(Some(0.05), Some(20.0)), 999).unwrap();
    assert_eq!(report.code_db, None);
    for (found, given) in found[1..].iter().zip(&given[1..]) {
        let difference: f32 = found.iter().zip(given).map(|(a, b)| (a - b).powi(2)).sum();
        let power: f32 = given.iter().map(|b| b * b).sum();
        // 3 us of the start turn the carrier by a fifth.
        assert!(difference < 0.1 * power, "{difference} {power}");
    }
    // Given late on purpose: the drift is found all the same.
    let (_, _, report) = align(&samples, 48_000.0, clock(Some(0.06), None), 999).unwrap();
    assert_eq!(report.late_s, 0.06);
    assert!((report.drift_ppm - 20.0).abs() < 1.0, "{report:?}");
    let (_, _, report) = align(&samples, 48_000.0, clock(None, Some(18.0)), 999).unwrap();
    assert!(
        (report.late_s - 0.05).abs() < 2e-5 && report.drift_ppm == 18.0,
        "{report:?}"
    );
    for (late_s, drift_ppm) in [
        (Some(-1.0), None),
        (None, Some(f64::NAN)),
        (None, Some(1e4)),
    ] {
        assert!(align(&samples, 48_000.0, clock(late_s, drift_ppm), 999).is_err());
    }
}

#[test]
fn a_sound_without_the_code_is_refused() {
    let noise = recorded(&vec![0.0; 80_000], 48_000.0, 0.0, 0.0, 0.5);
    let message = align(&noise, 48_000.0, FOUND, 4096)
        .unwrap_err()
        .to_string();
    assert!(message.contains("code is not heard"), "{message}");
    assert!(align(&[], 48_000.0, FOUND, 1).is_err());
    assert!(align(&[f32::NAN], 48_000.0, FOUND, 1).is_err());
    let tone: Vec<f32> = (0..100_000).map(|k| (0.3 * k as f32).sin()).collect();
    assert!(align(&tone, 48_000.0, FOUND, 4096).is_err());
    // The code begins after three seconds.
    let mut late = vec![0.0; 3 * 48_000];
    late.extend(recorded(&signal(40), 48_000.0, 0.0, 10.0, 0.01));
    let (_, _, report) = align(&late, 48_000.0, FOUND, 4096).unwrap();
    assert!((report.late_s - 3.0).abs() < 1e-3, "{report:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn any_start_and_drift_is_found(late_s in 0.0..0.3, drift_ppm in -110.0..110.0, noise in 0.0_f32..0.05) {
        let samples = recorded(&signal(40), 48_000.0, late_s, drift_ppm, noise);
        let (_, _, report) = align(&samples, 48_000.0, FOUND, 3000).unwrap();
        // A sound that begins within a hair's breadth of a period may lose it.
        let period_s = 0.0511 * (1.0 + 1e-6 * drift_ppm);
        let expected_s = late_s * (1.0 + 1e-6 * drift_ppm);
        let error_s = (report.late_s - expected_s + 0.5 * period_s).rem_euclid(period_s) - 0.5 * period_s;
        prop_assert!(error_s.abs() < 1e-5, "{} {report:?}", late_s);
        prop_assert!((report.drift_ppm - drift_ppm).abs() < 1.5, "{drift_ppm} {report:?}");
    }
}
