//! The Doppler bank on exact signals of a moving pair: range and bearing of one echo, and the plain reference.

use std::f64::consts::PI;

use crate::signals::Transmitter;
use localizer::echo::DopplerBank;
use localizer::parameters::{FilterParameters, MeasurementParameters, SignalParameters};
use localizer::{Parameters, TimeReference};
use ndarray::Array2;

/// One block that starts with period 3, of an echo with range `range_m` at its centre and the given bearing.
fn block_of_echo(
    parameters: &Parameters,
    source: &Transmitter,
    v_mps: f64,
    range_m: f64,
    bearing: f64,
) -> Vec<f32> {
    let length = parameters.measurement.periods * parameters.samples_per_period();
    let first = 3 * parameters.samples_per_period();
    let centre_s = (first as f64 + 0.5 * length as f64) / parameters.signal.sample_rate_hz;
    (0..length)
        .map(|k| {
            let t_s = (first + k) as f64 / parameters.signal.sample_rate_hz;
            let distance_m = range_m - v_mps * bearing.cos() * (t_s - centre_s);
            source.value(t_s - 2.0 * distance_m / parameters.signal.speed_of_sound_mps) as f32
        })
        .collect()
}

/// Direction, range (parabola through the three highest samples) and height of the highest peak.
fn highest(parameters: &Parameters, intensity: &Array2<f32>) -> (usize, f64, f64) {
    let mut best = (0, 0, 0.0);
    for ((direction, delay), &value) in intensity.indexed_iter() {
        if value > best.2 {
            best = (direction, delay, value);
        }
    }
    let (direction, delay, value) = best;
    let at = |delay: usize| f64::from(intensity.get((direction, delay)).copied().unwrap_or(0.0));
    let (left, right) = (at(delay.saturating_sub(1)), at(delay + 1));
    let offset = 0.5 * (left - right) / (left - 2.0 * f64::from(value) + right);
    (
        direction,
        parameters.signal.range_of_delay_m(delay as f64 + offset),
        f64::from(value),
    )
}

fn check_echoes(parameters: &Parameters) {
    let source = Transmitter::new(parameters);
    let bank = DopplerBank::new(parameters).unwrap();
    let mut scratch = bank.scratch();
    let mut intensity = bank.intensity();
    let (mut worst_range_m, mut wrong) = (0.0_f64, Vec::new());
    for v_mps in [0.1, 0.2, 0.4, -0.3] {
        for range_m in [0.3, 1.234, 2.5, 4.0] {
            for direction in [0, 1, 4, 9, 14, 15, 20, 26, 29] {
                let bearing = PI * direction as f64 / parameters.measurement.directions as f64;
                let block = block_of_echo(parameters, &source, v_mps, range_m, bearing);
                bank.measure(&block, v_mps, &mut scratch, &mut intensity);
                let (found, found_m, height) = highest(parameters, &intensity);
                worst_range_m = worst_range_m.max((found_m - range_m).abs());
                if found != direction {
                    wrong.push((v_mps, range_m, direction, found));
                }
                // Between two samples the highest one misses up to a seventh of a peak 0.1 ms wide.
                assert!(
                    (0.85..1.02).contains(&height),
                    "height {height} at {v_mps} m/s, {range_m} m, {direction}"
                );
            }
        }
    }
    assert!(worst_range_m < 0.01, "range is off by {worst_range_m} m");
    assert!(wrong.is_empty(), "(v, range, direction, found): {wrong:?}");
}

#[test]
fn an_echo_lands_in_its_pixel_at_40_khz() {
    check_echoes(&Parameters::default());
}

#[test]
fn an_echo_lands_in_its_pixel_at_50_khz_in_warm_air() {
    check_echoes(&Parameters {
        signal: SignalParameters {
            sample_rate_hz: 50_000.0,
            speed_of_sound_mps: 350.0,
            ..SignalParameters::default()
        },
        ..Parameters::default()
    });
}

#[test]
fn the_start_reference_shifts_the_delay_to_the_blocks_start() {
    let parameters = Parameters {
        measurement: MeasurementParameters {
            time_reference: TimeReference::Start,
            ..MeasurementParameters::default()
        },
        ..Parameters::default()
    };
    let source = Transmitter::new(&parameters);
    let bank = DopplerBank::new(&parameters).unwrap();
    let mut intensity = bank.intensity();
    let (v_mps, range_m) = (0.4, 2.0);
    let block = block_of_echo(&parameters, &source, v_mps, range_m, 0.0);
    bank.measure(&block, v_mps, &mut bank.scratch(), &mut intensity);
    let (direction, found_m, _) = highest(&parameters, &intensity);
    let at_start_m =
        range_m + v_mps * 0.5 * parameters.measurement.periods as f64 * parameters.period_s();
    // All of the resampling's surplus lies at one end, where the block lacks samples: the neighbour may win.
    assert!(direction <= 1, "{direction}");
    assert!(
        (found_m - at_start_m).abs() < 0.01,
        "{found_m} m instead of {at_start_m} m"
    );
}

#[test]
fn the_bank_agrees_with_the_printed_sums() {
    // A short code keeps the naive double sums affordable.
    let parameters = Parameters {
        transmitted: None,
        signal: SignalParameters {
            code_length: 63,
            speed_of_sound_mps: 336.0,
            ..SignalParameters::default()
        },
        measurement: MeasurementParameters {
            periods: 3,
            directions: 7,
            max_range_m: 1.0,
            ..MeasurementParameters::default()
        },
        filter: FilterParameters {
            window_half_width_m: 0.5,
            ..FilterParameters::default()
        },
    };
    let source = Transmitter::new(&parameters);
    let bank = DopplerBank::new(&parameters).unwrap();
    let mut scratch = bank.scratch();
    let mut intensity = bank.intensity();
    for time_reference in [TimeReference::Centre, TimeReference::Start] {
        let parameters = Parameters {
            measurement: MeasurementParameters {
                time_reference,
                ..parameters.measurement
            },
            ..parameters.clone()
        };
        let bank = DopplerBank::new(&parameters).unwrap();
        for v_mps in [0.0, 0.4, -12.0] {
            let block = block_of_echo(&parameters, &source, v_mps, 0.5, 0.7);
            bank.measure(&block, v_mps, &mut scratch, &mut intensity);
            let plain = localizer::reference::echo_intensity(&parameters, &block, v_mps);
            for (place, (fast, slow)) in intensity.iter().zip(&plain).enumerate() {
                assert!(
                    (f64::from(*fast) - slow).abs() < 2e-4,
                    "{place}: {fast} is not {slow} at {v_mps} m/s"
                );
            }
        }
    }
}
