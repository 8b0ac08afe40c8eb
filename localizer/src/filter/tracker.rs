//! One step of self-localization from measured echoes; the streaming and the offline localizer share it.

use crate::echo::echo_blocks::EchoBlock;
use crate::error::Error;
use crate::filter::motion_model::advance;
use crate::filter::particle_filter::ParticleFilter;
use crate::image::map_image::MapImage;
use crate::odometry::{Odometry, mean_over_periods};
use crate::parameters::{Method, Parameters};
use crate::pose::Pose;

/// The result of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Instant to which `pose` refers in seconds: the block's centre, or its start, by `time_reference`.
    pub t_s: f64,
    /// Expected pose, eq. (18).
    pub pose: Pose,
    /// Covariance of x, y (m) and heading (rad).
    pub covariance: [[f64; 3]; 3],
    /// Effective sample size of the particles.
    pub effective_sample_size: f64,
    /// `pose` carried by odometry to the end of the block, the newest sample.
    pub latest: Pose,
    /// True if the robot was too slow for bearings and the pose follows from odometry alone.
    pub stationary: bool,
}

/// A particle filter that follows the blocks of one drive.
pub struct Tracker {
    parameters: Parameters,
    filter: ParticleFilter,
    started: bool,
}

impl Tracker {
    /// A tracker with a known pose at time 0.
    ///
    /// # Errors
    /// Those of [`Parameters::check`], and [`Error::Invalid`] for a start that is not finite.
    pub fn new(parameters: &Parameters, start: Pose, seed: u64) -> Result<Self, Error> {
        parameters.check()?;
        if !start.is_finite() {
            return Err(Error::invalid(
                "start",
                "pose",
                "is not finite",
                "give finite numbers",
            ));
        }
        let mut parameters = parameters.clone();
        if parameters.filter.method == Method::Odometry {
            // Odometry alone is a single particle without noise that is never weighed.
            parameters.filter.particles = 1;
            (
                parameters.filter.sigma_v_mps,
                parameters.filter.sigma_omega_radps,
            ) = (0.0, 0.0);
            (
                parameters.filter.start_sigma_m,
                parameters.filter.start_sigma_rad,
            ) = (0.0, 0.0);
        }
        parameters.check_memory_of_filter()?;
        let filter = ParticleFilter::new(&parameters, start, seed);
        Ok(Self {
            parameters,
            filter,
            started: false,
        })
    }

    /// The particle filter.
    pub fn filter(&self) -> &ParticleFilter {
        &self.filter
    }

    /// Moves the particles to the block's instant, weighs them by its echoes, and draws the next ones.
    ///
    /// Blocks must be given one by one in their order. `recent` is the odometry of the block's M periods, preceded by
    /// that of the period before if there is one: see [`crate::EchoSequence::recent_odometry`].
    pub fn update(&mut self, block: &EchoBlock, recent: &[Odometry], map: &MapImage) -> Estimate {
        let here = self.predict(recent);
        if !block.stationary && self.parameters.filter.method != Method::Odometry {
            self.filter
                .weigh(block.polar(self.parameters.filter.method), map);
        }
        let expected = self.filter.expectation();
        self.filter.resample();
        let rest = recent.len() as f64 - here;
        let onward = mean_over_periods(recent, here, recent.len() as f64);
        Estimate {
            t_s: block.t_s,
            pose: expected.pose,
            covariance: expected.covariance,
            effective_sample_size: expected.effective_sample_size,
            latest: advance(
                &expected.pose,
                onward,
                rest * self.parameters.period_s(),
                self.parameters.filter.integration,
            ),
            stationary: block.stationary,
        }
    }

    /// Eq. (8) from the previous block's instant, or from time 0, to this block's. Returns that instant in periods
    /// from the start of `recent`.
    fn predict(&mut self, recent: &[Odometry]) -> f64 {
        let reference = self.parameters.measurement.reference_periods();
        let period_s = self.parameters.period_s();
        if self.started {
            self.filter.predict(
                mean_over_periods(recent, reference, reference + 1.0),
                period_s,
            );
            return reference + 1.0;
        }
        self.started = true;
        let mut start = 0.0;
        while start < reference {
            let end = (start + 1.0_f64).min(reference);
            self.filter.predict(
                mean_over_periods(recent, start, end),
                (end - start) * period_s,
            );
            start = end;
        }
        reference
    }
}
