//! The method written down plainly and slowly: the oracle of the tests.
//!
//! Everything here follows the printed equations sample by sample in double precision, without FFT, tables or
//! shortcuts.

use std::f64::consts::PI;

use ndarray::{Array2, ArrayView2};

use crate::parameters::{Parameters, TimeReference};
use crate::pose::wrap_angle;
use crate::signal::time_scale::{HALF_WIDTH, kernel};
use crate::signal::waveform;

/// Eq. (2) and the sum over the periods of eq. (1): the block, zero beyond its ends, at
/// `origin + (1 + excess) (k - origin)`, folded to one period.
pub fn resample_and_fold(block: &[f32], origin: f64, excess: f64, period: usize) -> Vec<f64> {
    let mut folded = vec![0.0; period];
    for k in 0..block.len() {
        let position = origin + (1.0 + excess) * (k as f64 - origin);
        let nearest = position.round() as i64;
        let reach = HALF_WIDTH as i64;
        for n in (nearest - reach).max(0)..=(nearest + reach).min(block.len() as i64 - 1) {
            folded[k % period] += f64::from(block[n as usize]) * kernel(position - n as f64);
        }
    }
    folded
}

/// Eq. (3): the sampling ratio that cancels the Doppler effect of direction n.
pub fn sampling_ratio(parameters: &Parameters, v_mps: f64, direction: usize) -> f64 {
    let approach = v_mps * (PI * direction as f64 / parameters.measurement.directions as f64).cos();
    (parameters.signal.speed_of_sound_mps - approach)
        / (parameters.signal.speed_of_sound_mps + approach)
}

/// Eqs. (1)-(3) and the envelope: intensity `[direction, delay]` of one block of M periods, 1 for an echo of
/// amplitude 1.
///
/// The circular correlation is a double sum, the Hilbert transform a naive Fourier sum.
pub fn echo_intensity(parameters: &Parameters, block: &[f32], v_mps: f64) -> Array2<f64> {
    let replica = waveform::transmitted(parameters);
    let period = replica.len();
    let energy: f64 = replica.iter().map(|sample| sample * sample).sum();
    let origin = match parameters.measurement.time_reference {
        TimeReference::Centre => 0.5 * (parameters.measurement.periods * period) as f64,
        TimeReference::Start => 0.0,
    };
    let delays = parameters.delays();
    let mut intensity = Array2::zeros((parameters.measurement.directions + 1, delays));
    for direction in 0..=parameters.measurement.directions {
        let excess = sampling_ratio(parameters, v_mps, direction) - 1.0;
        let folded = resample_and_fold(block, origin, excess, period);
        let correlation: Vec<f64> = (0..period)
            .map(|lag| {
                let sum: f64 = (0..period)
                    .map(|k| folded[(k + lag) % period] * replica[k])
                    .sum();
                sum / (energy * parameters.measurement.periods as f64)
            })
            .collect();
        for (delay, value) in envelope(&correlation).into_iter().take(delays).enumerate() {
            intensity[[direction, delay]] = value;
        }
    }
    intensity
}

/// Magnitude of the analytic signal of a periodic signal.
pub fn envelope(signal: &[f64]) -> Vec<f64> {
    let length = signal.len();
    let spectrum: Vec<(f64, f64)> = (1..length.div_ceil(2))
        .map(|line| {
            signal
                .iter()
                .enumerate()
                .fold((0.0, 0.0), |(re, im), (k, value)| {
                    let phase = 2.0 * PI * ((line * k) % length) as f64 / length as f64;
                    (re + value * phase.cos(), im - value * phase.sin())
                })
        })
        .collect();
    (0..length)
        .map(|k| {
            let (mut re, mut im) = (0.0, 0.0);
            for (index, (a, b)) in spectrum.iter().enumerate() {
                let phase = 2.0 * PI * (((index + 1) * k) % length) as f64 / length as f64;
                re += a * phase.cos() - b * phase.sin();
                im += a * phase.sin() + b * phase.cos();
            }
            2.0 / length as f64 * re.hypot(im)
        })
        .collect()
}

/// Eqs. (4)-(6) and (14)-(16): the echo image `[my + N_W, mx + N_W]` of one block for a heading.
pub fn echo_image(
    parameters: &Parameters,
    intensity: ArrayView2<'_, f32>,
    heading_rad: f64,
    half_cells: usize,
) -> Array2<f32> {
    let half = half_cells as i64;
    let width = 2 * half_cells + 1;
    Array2::from_shape_fn((width, width), |(row, column)| {
        let x_m = (column as i64 - half) as f64 * parameters.measurement.cell_m;
        let y_m = (row as i64 - half) as f64 * parameters.measurement.cell_m;
        let range_m = x_m.hypot(y_m);
        let delay = parameters.signal.delay_of_range(range_m);
        if range_m < parameters.measurement.min_range_m || delay >= intensity.ncols() {
            return 0.0;
        }
        let bearing = wrap_angle(y_m.atan2(x_m) - wrap_angle(heading_rad)).abs();
        let directions = intensity.nrows() - 1;
        intensity[[(directions as f64 / PI * bearing).round() as usize, delay]]
    })
}

/// Eqs. (9)-(12): mutual information in nats of two images of bin numbers.
pub fn mutual_information(first: &[u8], second: &[u8]) -> f64 {
    let total = first.len() as f64;
    let mut joint = vec![[0.0; 256]; 256];
    for (&a, &b) in first.iter().zip(second) {
        joint[usize::from(a)][usize::from(b)] += 1.0 / total;
    }
    let rows: Vec<f64> = joint.iter().map(|row| row.iter().sum()).collect();
    let columns: Vec<f64> = (0..256)
        .map(|b| joint.iter().map(|row| row[b]).sum())
        .collect();
    let mut information = 0.0;
    for (a, row) in joint.iter().enumerate() {
        for (b, &p) in row.iter().enumerate() {
            if p > 0.0 {
                information += p * (p / (rows[a] * columns[b])).ln();
            }
        }
    }
    information
}

/// Eqs. (13) and (14): bin numbers floor(K value / max) of an image.
pub fn quantize(image: &[f32], bins: usize) -> Vec<u8> {
    let largest = image.iter().copied().fold(0.0_f32, f32::max);
    image
        .iter()
        .map(|&value| {
            if largest > 0.0 {
                (value / largest * bins as f32).floor() as u8
            } else {
                0
            }
        })
        .collect()
}
