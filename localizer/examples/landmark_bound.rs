//! Error of a peak's range and cosine over noise and periods M, beside the Cramer-Rao bound.
//!
//! `make bound` writes one row for each signal-to-noise ratio and M: root mean squares of what `PeakFinder` is off by,
//! and the least that any unbiased estimate has (docs/theory/landmarks.md).

use std::error::Error;
use std::f64::consts::{PI, TAU};

use localizer::Parameters;
use localizer::echo::DopplerBank;
use localizer::landmarks::peaks::PeakFinder;
use localizer::random;
use localizer::signal::waveform::transmit_period;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// Echoes for each row.
const TRIALS: usize = 60;
/// Speed of the robot in m/s.
const SPEED_MPS: f64 = 0.3;
/// Ratios of the echo's power to the noise's, in decibels.
const RATIOS_DB: [f64; 7] = [-25.0, -20.0, -15.0, -10.0, 0.0, 10.0, 20.0];

/// The period between its samples, by a windowed sinc.
fn between(period: &[f64], at: f64) -> f64 {
    let base = at.floor();
    (-24..=24_i32)
        .map(|k| {
            let n = base + f64::from(k);
            let x = PI * (at - n);
            let sinc = if x.abs() < 1e-9 { 1.0 } else { x.sin() / x };
            let window = (0.5 * PI * (at - n) / 25.0).cos().powi(2);
            period[(n as i64).rem_euclid(period.len() as i64) as usize] * sinc * window
        })
        .sum()
}

/// Root mean square of the period's frequencies around the carrier, in hertz.
fn bandwidth_hz(period: &[f64], parameters: &Parameters) -> f64 {
    let mut spectrum: Vec<Complex<f64>> = period.iter().map(|&x| Complex::new(x, 0.0)).collect();
    FftPlanner::new()
        .plan_fft_forward(spectrum.len())
        .process(&mut spectrum);
    let step_hz = parameters.signal.sample_rate_hz / period.len() as f64;
    let (mut power, mut squares) = (0.0, 0.0);
    for (k, value) in spectrum.iter().enumerate().take(period.len() / 2) {
        let off_hz = k as f64 * step_hz - parameters.signal.carrier_hz;
        power += value.norm_sqr();
        squares += value.norm_sqr() * off_hz * off_hz;
    }
    (squares / power).sqrt()
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("snr_db,periods,found,range_m,range_bound_m,cosine,cosine_bound");
    for periods in [1, 2, 6] {
        let mut parameters = Parameters::default();
        parameters.measurement.periods = periods;
        let signal = &parameters.signal;
        let period = transmit_period(signal);
        let power = period.iter().map(|x| x * x).sum::<f64>() / period.len() as f64;
        let c_mps = signal.speed_of_sound_mps;
        let bank = DopplerBank::new(&parameters)?;
        let (mut scratch, mut intensity) = (bank.scratch(), bank.intensity());
        let length = bank.block_length();
        for snr_db in RATIOS_DB {
            let mut random = random::stream(random::trial_seed("bound", "", 1), "echoes");
            let (mut squares, mut found) = ([0.0; 2], 0.0);
            for _ in 0..TRIALS {
                let range_m: f64 = random.random_range(0.6..5.0);
                let cosine: f64 = random.random_range(-0.9..0.9);
                let approach_mps = SPEED_MPS * cosine;
                let stretch = 1.0 + 2.0 * approach_mps / (c_mps - approach_mps);
                let delay = 2.0 * range_m / c_mps * signal.sample_rate_hz;
                let middle = 0.5 * length as f64;
                let sigma = (power / 10_f64.powf(0.1 * snr_db)).sqrt();
                let block: Vec<f32> = (0..length)
                    .map(|n| {
                        let at = middle - delay + stretch * (n as f64 - middle);
                        let noise: f64 = StandardNormal.sample(&mut random);
                        (between(&period, at) + sigma * noise) as f32
                    })
                    .collect();
                bank.measure(&block, SPEED_MPS, &mut scratch, &mut intensity);
                let mut peaks = Vec::new();
                PeakFinder::new(&parameters).find(intensity.view(), SPEED_MPS, &mut peaks);
                let near = peaks
                    .first()
                    .filter(|peak| (peak.range_m - range_m).abs() < 0.05);
                if let Some(peak) = near {
                    found += 1.0;
                    squares[0] += (peak.range_m - range_m).powi(2);
                    squares[1] += (peak.cosine - cosine).powi(2);
                }
            }
            // Twice the energy over the noise's density: energy over variance, sample by sample.
            let samples = (periods * period.len()) as f64;
            let root = (samples * 10_f64.powf(0.1 * snr_db)).sqrt();
            let duration_s = periods as f64 * parameters.period_s() / 12_f64.sqrt();
            let range_bound = 0.5 * c_mps / (TAU * bandwidth_hz(&period, &parameters) * root);
            let shift_bound = 1.0 / (TAU * duration_s * root);
            let cosine_bound = c_mps / (2.0 * SPEED_MPS * signal.carrier_hz) * shift_bound;
            let rms = squares.map(|sum| (sum / f64::max(found, 1.0)).sqrt());
            println!(
                "{snr_db},{periods},{:.2},{:.2e},{range_bound:.2e},{:.2e},{cosine_bound:.2e}",
                found / TRIALS as f64,
                rms[0],
                rms[1],
            );
        }
    }
    Ok(())
}
