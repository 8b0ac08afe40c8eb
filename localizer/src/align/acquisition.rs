//! The first sample of a period, and how fast one clock runs against the other, from a second of sound.

use rustfft::num_complex::Complex;

use super::replica::{Replica, line, median};
use super::resampler::Resampler;

/// Periods that are looked at together.
pub(super) const PERIODS: usize = 12;

/// Periods of them in which the code must be heard.
const LEAST_HEARD: usize = 4;

/// Least power of the code's strongest lag over the median of all lags where it is looked for again.
pub(super) const LEAST_RATIO: f64 = 12.0;

/// Logarithm of how seldom the strongest lag of another code may be taken for this one's.
const SELDOM: f64 = 12.0;

/// The direct wave is the first lag with so much of the strongest lag's power...
const LEAST_DIRECT: f64 = 0.16;

/// ... of those at most so long before it, in seconds.
const BEFORE_STRONGEST_S: f64 = 0.01;

/// Part of the usual height below which the direct wave is not there.
pub(super) const LEAST_HEIGHT: f64 = 0.5;

/// A clock as found: positions are samples of the input.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    /// Position of the first sample of the first period with the code.
    pub(super) start: f64,
    /// Input samples an output sample.
    pub(super) step: f64,
    /// Correlation with the direct wave there.
    pub(super) direct: Complex<f64>,
    /// Power of the strongest lag over the median of all.
    pub(super) ratio: f64,
}

/// Looks for the code in `input`. `step` is the nominal number of input samples an output sample, `shape`
/// the output's samples a period and its rate in Hz. None when it is not there.
pub(super) fn acquire(
    input: &[f32],
    step: f64,
    shape: (usize, f64),
    replica: &mut Replica,
    resampler: &Resampler,
) -> Option<Found> {
    let (length, rate_hz) = shape;
    let mut period = vec![0.0_f32; length];
    let mut power = vec![0.0; length];
    let mut correlations = Vec::with_capacity(PERIODS);
    for n in 0..PERIODS {
        resampler.fill(input, (n * length) as f64 * step, step, &mut period);
        let correlation = replica.correlate(&period);
        for (power, value) in power.iter_mut().zip(correlation) {
            *power += value.norm_sqr();
        }
        correlations.push(correlation.to_vec());
    }
    let strongest = (0..length).max_by(|&a, &b| power[a].total_cmp(&power[b]))?;
    let ratio = power[strongest] / median(power.iter().copied()).max(f64::MIN_POSITIVE);
    if !(ratio > least_ratio(&power) && power[strongest] > 0.0) {
        return None;
    }
    let around = |lag: usize, by: isize| (lag as isize + by).rem_euclid(length as isize) as usize;
    let reach = ((BEFORE_STRONGEST_S * rate_hz) as usize).min(length / 2) as isize;
    let is_peak =
        |lag: usize| power[lag] >= power[around(lag, -1)] && power[lag] >= power[around(lag, 1)];
    let direct = (-reach..=0)
        .map(|by| around(strongest, by))
        .find(|&lag| is_peak(lag) && power[lag] >= LEAST_DIRECT * power[strongest])?;
    // The clocks may part by a few samples in this time.
    let wide = (2.0 + 150e-6 * (PERIODS * length) as f64).ceil() as isize;
    let peaks: Vec<(f64, f64)> = correlations
        .iter()
        .map(|correlation| {
            let height = |by: isize| correlation[around(direct, by)].norm();
            let by = (-wide..=wide)
                .max_by(|&a, &b| height(a).total_cmp(&height(b)))
                .unwrap_or(0);
            let [before, here, after] = [by - 1, by, by + 1].map(height);
            let bend = before - 2.0 * here + after;
            let shift = if bend < 0.0 {
                0.5 * (before - after) / bend
            } else {
                0.0
            };
            (by as f64 + shift.clamp(-0.5, 0.5), here)
        })
        .collect();
    let highest = peaks
        .iter()
        .fold(0.0_f64, |highest, peak| highest.max(peak.1));
    let heard = |n: usize| peaks[n].1 > LEAST_HEIGHT * highest;
    let points: Vec<[f64; 2]> = (0..PERIODS)
        .filter(|&n| heard(n))
        .map(|n| [n as f64, peaks[n].0])
        .collect();
    if points.len() < LEAST_HEARD {
        return None;
    }
    let [offset, slope] = line(&points);
    let first = points[0][0];
    let place = first * length as f64 + direct as f64 + offset + slope * first - replica.direct_lag;
    let found = Found {
        start: place * step,
        step: step * (1.0 + slope / length as f64),
        direct: Complex::ZERO,
        ratio,
    };
    refine(input, found, shape, replica, resampler)
}

/// Least power of the strongest lag over the median of all, for it to be the code's.
///
/// What the code makes of another one repeats from period to period: its powers are distributed exponentially over the
/// lags, and the largest of n exceeds `(ln n + x) / ln 2` medians with a probability of `exp(-x)`. Noise differs from
/// period to period, and the mean of several is distributed more narrowly: by how much, the ninth decile tells.
fn least_ratio(power: &[f64]) -> f64 {
    let mut sorted = power.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| sorted[(share * sorted.len() as f64) as usize];
    let (middle, high) = (at(0.5).max(f64::MIN_POSITIVE), at(0.9));
    // The distance of the decile from the median, and of an exponential distribution in medians.
    let width = (high / middle - 1.0).min(5.0_f64.log2());
    let least = ((power.len() as f64).ln() + SELDOM) / std::f64::consts::LN_2;
    1.0 + (least - 1.0) * width / 5.0_f64.log2()
}

/// The same clock by the phases of the direct wave.
fn refine(
    input: &[f32],
    found: Found,
    shape: (usize, f64),
    replica: &Replica,
    resampler: &Resampler,
) -> Option<Found> {
    let (length, rate_hz) = shape;
    let mut period = vec![0.0_f32; length];
    let available = (input.len() as f64 - found.start) / (length as f64 * found.step);
    let values: Vec<Complex<f64>> = (0..(available.max(0.0) as usize).min(PERIODS))
        .map(|n| {
            let start = found.start + (n * length) as f64 * found.step;
            resampler.fill(input, start, found.step, &mut period);
            replica.direct(&period)
        })
        .collect();
    let usual = median(values.iter().map(|value| value.norm()));
    let mut phases = Vec::new();
    let mut before: Option<(Complex<f64>, f64)> = None;
    for (n, &value) in values.iter().enumerate() {
        if value.norm() < LEAST_HEIGHT * usual {
            continue;
        }
        let phase = match before {
            None => value.arg(),
            Some((last, phase)) => phase + (value / last).arg(),
        };
        before = Some((value, phase));
        phases.push([n as f64, phase]);
    }
    if phases.len() < LEAST_HEARD {
        return None;
    }
    let [phase, slope] = line(&phases);
    // A wave that comes later by one sample a period turns back by the phase of one sample.
    let samples = -slope / (std::f64::consts::TAU * replica.centroid_hz) * rate_hz;
    Some(Found {
        step: found.step * (1.0 + samples / length as f64),
        direct: Complex::from_polar(usual, phase),
        ..found
    })
}
