//! The direct wave followed from period to period.

use std::f64::consts::TAU;

use rustfft::num_complex::Complex;

use super::acquisition::{self, LEAST_HEIGHT, LEAST_RATIO};
use super::replica::{Replica, median};
use super::report::{Gap, SoundReport};
use super::resampler::Position;

/// Periods over which a drift is averaged.
const MEMORY: f64 = 100.0;

/// Largest turn of the direct wave's phase from one period to the next, in radians.
const LARGEST_TURN: f64 = 1.2;

/// Periods without the direct wave after which it is looked for at all lags.
const LOST_PERIODS: usize = 3;

/// Periods that count after the direct wave was lost and found.
const KNOWN_AGAIN: f64 = 6.0;

/// Shift in samples from which on samples are missing.
const LEAST_GAP: f64 = 2.0;

/// Largest difference of two clocks, as a share.
pub(super) const LARGEST_DRIFT: f64 = 300e-6;

/// Where the input is read, steered by the direct wave.
pub(super) struct Follower {
    /// Position of the next period's first sample in the whole input.
    pub(super) start: Position,
    /// Input samples an output sample in the next period: the clock's and a correction.
    pub(super) steered: f64,
    /// The same by the clock alone, and by its nominal rate.
    step: f64,
    nominal_step: f64,
    /// Rate of the output in Hz.
    rate_hz: f64,
    /// The direct wave; none when the clock is given.
    direct: Option<Complex<f64>>,
    /// Periods that the clock rests on.
    known: f64,
    /// Periods without the direct wave since the last with it, and the power of all their lags.
    lost: usize,
    power: Vec<f64>,
    /// Sum of the squares of the direct wave's times less what was foreseen, and their number.
    squares: f64,
    heard: f64,
}

impl Follower {
    /// From `start` on with `steps` of the clock and nominal, for an output of `rate_hz`.
    pub(super) fn new(
        start: Position,
        steps: [f64; 2],
        rate_hz: f64,
        direct: Option<Complex<f64>>,
    ) -> Self {
        Self {
            start,
            steered: steps[0],
            step: steps[0],
            nominal_step: steps[1],
            rate_hz,
            direct,
            known: acquisition::PERIODS as f64,
            lost: 0,
            power: Vec::new(),
            squares: 0.0,
            heard: 0.0,
        }
    }

    /// Goes on by a period of `length` samples.
    pub(super) fn advance(&mut self, length: usize) {
        self.start = self.start.plus(length as f64 * self.steered);
        self.steered = self.step;
    }

    /// Compares the direct wave of the period that was read last with what was foreseen, and steers the next. False
    /// when it is not there.
    pub(super) fn judge(
        &mut self,
        period: &[f32],
        replica: &mut Replica,
        report: &mut SoundReport,
    ) -> bool {
        let Some(direct) = self.direct else {
            return true;
        };
        let value = replica.direct(period);
        let turn = (value / direct).arg();
        if !(value.norm() > LEAST_HEIGHT * direct.norm() && turn.abs() < LARGEST_TURN) {
            self.look_around(direct, period, replica, report);
            return false;
        }
        self.lost = 0;
        self.power.clear();
        let late_s = -turn / (TAU * replica.centroid_hz);
        // As a share of a period, and in input samples an output sample.
        let late = late_s * self.rate_hz / period.len() as f64 * self.step;
        self.known = (self.known + 1.0).min(MEMORY);
        let n = self.known;
        let [gain, drift_gain] = [2.0 * (2.0 * n - 1.0), 6.0].map(|x| x / (n * (n + 1.0)));
        let limits = [1.0 - LARGEST_DRIFT, 1.0 + LARGEST_DRIFT].map(|x| x * self.nominal_step);
        self.step = (self.step + drift_gain * late).clamp(limits[0], limits[1]);
        self.steered = self.step + gain * late;
        self.squares += late_s * late_s;
        self.heard += 1.0;
        report.jitter_s = (self.squares / self.heard).sqrt();
        report.drift_ppm = 1e6 * (self.step / self.nominal_step - 1.0);
        true
    }

    /// Looks for a direct wave that was lost at all lags.
    fn look_around(
        &mut self,
        direct: Complex<f64>,
        period: &[f32],
        replica: &mut Replica,
        report: &mut SoundReport,
    ) {
        self.lost += 1;
        if self.lost == 1 {
            // The period in which samples are missing belongs to two places.
            return;
        }
        self.power.resize(period.len(), 0.0);
        for (sum, value) in self.power.iter_mut().zip(replica.correlate(period)) {
            *sum += value.norm_sqr();
        }
        if self.lost < LOST_PERIODS {
            return;
        }
        let power = &self.power;
        let least = (LEAST_HEIGHT * direct.norm()).powi(2) * (self.lost - 1) as f64;
        let least = least.max(LEAST_RATIO * median(power.iter().copied()));
        let strongest = (0..power.len()).max_by(|&a, &b| power[a].total_cmp(&power[b]));
        let Some(lag) = strongest.filter(|&lag| power[lag] > least) else {
            if self.lost > 2 * LOST_PERIODS {
                // What was summed up may be of several places: begin anew.
                self.lost = 1;
                self.power.fill(0.0);
            }
            return;
        };
        self.lost = 1;
        self.power.clear();
        let (half, length) = (0.5 * period.len() as f64, period.len() as f64);
        let shift = (lag as f64 - replica.direct_lag + half).rem_euclid(length) - half;
        self.start = self.start.plus(shift * self.step);
        self.steered = self.step;
        self.known = self.known.min(KNOWN_AGAIN);
        if shift.abs() > LEAST_GAP {
            report.gaps.push(Gap {
                period: report.periods + 1,
                samples: -shift * self.step,
            });
        }
    }
}
