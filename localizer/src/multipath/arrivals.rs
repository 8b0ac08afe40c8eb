//! Arrival times of a whole recording (2021, process (iii)): impulse responses and their peaks, block by block.
//!
//! The Doppler effect decorrelates echoes of a moving robot from the transmitted signal. The impulse response is
//! therefore the largest envelope over the directions of the Doppler bank, so that every echo appears with the scale
//! that fits it. The static direct wave is removed beforehand (see [`crate::DirectWave`]), and delays below
//! `min_range_m` are not picked.

use ndarray::Array2;

use super::peaks::{Picking, pick};
use crate::echo::recording_blocks::map_blocks;
use crate::error::Error;
use crate::odometry::{Odometry, mean_over_periods};
use crate::parameters::Parameters;
use crate::recording::Recording;

/// Arrival times of one block.
#[derive(Debug, Clone, PartialEq)]
pub struct ArrivalBlock {
    /// Instant to which they refer, in seconds.
    pub t_s: f64,
    /// Time since the block before, or since time 0, in seconds.
    pub step_s: f64,
    /// Mean odometry over that time.
    pub odometry: Odometry,
    /// Arrival times after emission, in seconds, increasing.
    pub times_s: Vec<f64>,
}

/// Measures the arrival times of every block of a recording, as [`crate::echo::measure`] does echoes. The noise level
/// is that of all delays up to `max_range_m`; peaks are picked at round trips within `round_trip_m`.
///
/// # Errors
/// As [`crate::echo::measure`].
pub fn measure(
    recording: &Recording,
    parameters: &Parameters,
    picking: &Picking,
    round_trip_m: [f64; 2],
) -> Result<Vec<ArrivalBlock>, Error> {
    let rate_hz = parameters.signal.sample_rate_hz;
    let [first, last] =
        round_trip_m.map(|way_m| (way_m / parameters.signal.speed_of_sound_mps * rate_hz) as usize);
    let (blocks, odometry) = map_blocks(
        recording,
        parameters,
        |bank| (bank.scratch(), bank.intensity(), Vec::new()),
        |bank, (scratch, intensity, envelope), _, block, odometry| {
            let v_mps =
                mean_over_periods(odometry, 0.0, parameters.measurement.periods as f64).v_mps;
            bank.measure(block, v_mps, scratch, intensity);
            largest(intensity, envelope);
            let peaks = pick(envelope, first..last, picking);
            peaks.iter().map(|peak| peak.delay / rate_hz).collect()
        },
    )?;
    let period_s = parameters.period_s();
    let reference = parameters.measurement.reference_periods();
    let timed = blocks.into_iter().enumerate().map(|(index, times_s)| {
        let to = index as f64 + reference;
        let from = if index == 0 { 0.0 } else { to - 1.0 };
        ArrivalBlock {
            t_s: to * period_s,
            step_s: (to - from) * period_s,
            odometry: mean_over_periods(&odometry, from, to),
            times_s,
        }
    });
    Ok(timed.collect())
}

/// The largest intensity over the directions at every delay.
fn largest(intensity: &Array2<f32>, envelope: &mut Vec<f32>) {
    envelope.clear();
    envelope.resize(intensity.ncols(), 0.0);
    for row in intensity.rows() {
        for (most, &value) in envelope.iter_mut().zip(row) {
            *most = most.max(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::odometry::OdometrySample;
    use crate::parameters::{MeasurementParameters, SignalParameters};
    use crate::recording::RecordingMeta;
    use crate::signal::waveform::m_sequence;
    use std::f64::consts::TAU;

    /// The transmitted signal at any time: rectangular chips on the carrier.
    fn sent(code: &[i8], t_s: f64) -> f64 {
        let chip = (t_s * 10e3).floor().rem_euclid(code.len() as f64) as usize;
        f64::from(code[chip]) * (TAU * 10e3 * t_s).sin()
    }

    /// Domain: a robot at 0.3 m/s between a wall ahead (echo at 3.2 m - 0.6 t) and one behind (6 m + 0.6 t), with a
    /// static direct wave at 0.1 m, ten times as loud. Delay law of a uniform approach to a wall; tolerance 0.02 m of
    /// round trip (rectangular chips at 40 kHz).
    #[test]
    fn moving_walls_are_timed_and_the_direct_wave_is_not_picked() {
        for (order, c) in [(10, 340.0), (10, 333.0), (10, 350.0)] {
            check(order, c);
        }
    }

    fn check(order: u32, c: f64) {
        let v = 0.3;
        let code = m_sequence(order);
        let parameters = Parameters {
            signal: SignalParameters {
                code_length: code.len(),
                speed_of_sound_mps: c,
                ..SignalParameters::default()
            },
            measurement: MeasurementParameters {
                periods: 2,
                directions: 12,
                direct_wave: crate::DirectWave::GatedMean,
                max_range_m: 17.0,
                ..MeasurementParameters::default()
            },
            ..Parameters::default()
        };
        let samples = parameters.samples_per_period() as u32;
        let signal = (0..8 * samples)
            .map(|k| {
                let t = f64::from(k) / 40e3;
                // c (t - t_e) = way(t) - v (t - t_e) for the wall ahead: source and receiver both move.
                let ahead = (3.2 - 2.0 * v * t) / (c - v);
                let behind = (6.0 + 2.0 * v * t) / (c + v);
                let sum = 10.0 * sent(&code, t - 0.1 / c)
                    + sent(&code, t - ahead)
                    + 0.7 * sent(&code, t - behind);
                sum as f32
            })
            .collect();
        let recording = Recording {
            unheard: Vec::new(),
            signal,
            direct: None,
            odometry: [0.0, 0.5, 1.0, 2.0]
                .map(|t_s| OdometrySample {
                    t_s,
                    v_mps: v,
                    omega_radps: 0.0,
                })
                .to_vec(),
            truth: None,
            meta: RecordingMeta::from_parameters(&parameters),
        };
        let picking = Picking {
            threshold: 5.0,
            separation: 4,
            most: 9,
        };
        let blocks = measure(&recording, &parameters, &picking, [0.6, 12.0]).unwrap();
        assert_eq!(blocks.len(), 7);
        assert!((blocks[0].step_s - parameters.period_s()).abs() < 1e-12);
        for block in &blocks {
            let ways: Vec<f64> = block.times_s.iter().map(|t| t * c).collect();
            assert_eq!(ways.len(), 2, "{ways:?}");
            let t = block.t_s;
            assert!((ways[0] - (3.2 - 0.6 * t)).abs() < 0.02, "{ways:?} at {t}");
            assert!((ways[1] - (6.0 + 0.6 * t)).abs() < 0.02, "{ways:?} at {t}");
        }
    }
}
