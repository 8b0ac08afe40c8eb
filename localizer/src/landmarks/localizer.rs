//! The pose block by block, from echoes that are measured already or from samples as they come in.

use super::filter::{LandmarkFilter, Start, Status};
use super::hypothesis::{Noise, Seen};
use super::learn::cosine_sigma;
use super::map::LandmarkMap;
use super::peaks::{MOST_PEAKS, Peak, PeakFinder};
use crate::echo::{EchoBlock, EchoSequence};
use crate::filter::motion_model::advance;
use crate::odometry::{Odometry, mean_over_periods};
use crate::parameters::{Integration, Parameters};
use crate::pose::Pose;

/// The result of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Instant to which `pose` refers in seconds: the block's centre, or its start, by `time_reference`.
    pub t_s: f64,
    /// The pose.
    pub pose: Pose,
    /// Covariance of x, y (m) and heading (rad).
    pub covariance: [[f64; 3]; 3],
    /// `pose` carried by the wheels, less their errors, to the end of the block: the newest sample.
    pub latest: Pose,
    /// How far to trust it.
    pub status: Status,
    /// Share of the expected echoes found lately.
    pub fit: f64,
    /// Poses that are still possible.
    pub hypotheses: usize,
    /// What the wheels' turn rate lacks, in rad/s.
    pub turn_rate_error_radps: f64,
    /// What the wheels' speed lacks, as a part of it.
    pub speed_error: f64,
    /// Speed of sound in m/s.
    pub speed_of_sound_mps: f64,
}

/// Follows the blocks of one drive among landmarks.
pub struct LandmarkTracker {
    parameters: Parameters,
    noise: Noise,
    filter: LandmarkFilter,
    finder: PeakFinder,
    peaks: Vec<Peak>,
    started: bool,
}

impl LandmarkTracker {
    /// A tracker; `parameters` must pass [`Parameters::check`].
    pub fn new(parameters: &Parameters, start: &Start, noise: Noise) -> Self {
        Self {
            filter: LandmarkFilter::new(start, noise),
            finder: PeakFinder::new(parameters),
            peaks: Vec::with_capacity(MOST_PEAKS),
            parameters: parameters.clone(),
            noise,
            started: false,
        }
    }

    /// The filter.
    pub fn filter(&self) -> &LandmarkFilter {
        &self.filter
    }

    /// The peaks of the newest block.
    pub fn peaks(&self) -> &[Peak] {
        &self.peaks
    }

    /// Moves the hypotheses to the block's instant and holds them against its echoes. None while an unknown start has
    /// not seen a block of a moving robot.
    ///
    /// Blocks must be given one by one in their order. `recent` is the odometry of the block's M periods, preceded by
    /// that of the period before if there is one.
    pub fn update(
        &mut self,
        block: &EchoBlock,
        recent: &[Odometry],
        map: &LandmarkMap,
    ) -> Option<Estimate> {
        let here = self.predict(recent);
        if !block.stationary {
            let v_mps = block.odometry.v_mps;
            self.finder
                .find(block.intensity.view(), v_mps, &mut self.peaks);
            let seen = Seen {
                peaks: &self.peaks,
                cosine_sigma: cosine_sigma(&self.parameters, v_mps),
                odometry: block.odometry,
            };
            self.filter.update(&seen, map);
        }
        let best = self.filter.best()?;
        let rest = recent.len() as f64 - here;
        let onward = mean_over_periods(recent, here, recent.len() as f64);
        let onward = Odometry {
            v_mps: onward.v_mps * (1.0 + best.state[4]),
            omega_radps: onward.omega_radps + best.state[3],
        };
        let covariance = best.pose_covariance();
        Some(Estimate {
            t_s: block.t_s,
            pose: best.pose(),
            covariance: [0, 1, 2].map(|row| [0, 1, 2].map(|column| covariance[(row, column)])),
            latest: advance(
                &best.pose(),
                onward,
                rest * self.parameters.period_s(),
                Integration::Midpoint,
            ),
            status: self.filter.status(),
            fit: self.filter.fit(),
            hypotheses: self.filter.hypotheses().len(),
            turn_rate_error_radps: best.state[3],
            speed_error: best.state[4],
            speed_of_sound_mps: self.parameters.signal.speed_of_sound_mps * (1.0 + best.state[5]),
        })
    }

    /// From the previous block's instant, or from time 0, to this block's. Returns that instant in periods from the
    /// start of `recent`.
    fn predict(&mut self, recent: &[Odometry]) -> f64 {
        let reference = self.parameters.measurement.reference_periods();
        let period_s = self.parameters.period_s();
        let (mut from, to) = if self.started {
            (reference, reference + 1.0)
        } else {
            (0.0, reference)
        };
        self.started = true;
        // Pieces of at most a period, so that a turn is followed.
        while from < to {
            let end = (from.floor() + 1.0).min(to);
            self.filter.predict(
                mean_over_periods(recent, from, end),
                (end - from) * period_s,
            );
            from = end;
        }
        to
    }

    /// Standard deviations of motion and echoes.
    pub fn noise(&self) -> &Noise {
        &self.noise
    }
}

/// Estimates the pose at every block of a drive whose echoes are measured.
pub fn localize(
    echoes: &EchoSequence,
    map: &LandmarkMap,
    start: &Start,
    noise: Noise,
) -> Vec<Estimate> {
    let mut tracker = LandmarkTracker::new(&echoes.parameters, start, noise);
    echoes
        .blocks
        .iter()
        .enumerate()
        .filter_map(|(index, block)| tracker.update(block, echoes.recent_odometry(index), map))
        .collect()
}
