//! How the robot drives: a pose and its speeds at any time, smooth enough to drive a sound source.

mod samples;
mod state;
mod velocity_commands;

pub use samples::PoseSample;
pub(crate) use state::relocate;
pub use state::{MAX_DURATION_S, MAX_SPEED_MPS, MAX_TURN_RADPS, MotionState};
pub use velocity_commands::{DriveLimits, VelocityCommand};

use crate::error::Error;
use std::path::Path;

/// A drive: from time 0 to [`DrivePath::duration_s`] the robot has a pose that is C1 smooth in time.
#[derive(Debug, Clone)]
pub struct DrivePath {
    course: Course,
}

#[derive(Debug, Clone)]
enum Course {
    Commands(velocity_commands::CommandedCourse),
    Samples(samples::SampledCourse),
}

impl DrivePath {
    /// A drive from `start` through `commands`, each with a commanded speed and turn rate that the robot approaches
    /// with limited accelerations.
    ///
    /// `start` holds the speeds at time 0 too: zeros for a robot that starts at rest.
    ///
    /// # Errors
    /// [`Error::Invalid`] with origin `path` when there is no command, a number is not finite or out of range, or the
    /// commands last longer than [`MAX_DURATION_S`] together.
    pub fn from_commands(
        start: MotionState,
        commands: &[VelocityCommand],
        limits: DriveLimits,
    ) -> Result<Self, Error> {
        let course = velocity_commands::CommandedCourse::new(start, commands, limits)?;
        Ok(Self {
            course: Course::Commands(course),
        })
    }

    /// A drive with the constant speed and turn rate of `start`: rest, a straight line or a circle.
    ///
    /// # Errors
    /// As [`DrivePath::from_commands`].
    pub fn uniform(start: MotionState, duration_s: f64) -> Result<Self, Error> {
        let command = VelocityCommand {
            duration_s,
            v_mps: start.v_mps,
            omega_radps: start.omega_radps,
        };
        Self::from_commands(start, &[command], DriveLimits::default())
    }

    /// A drive through measured poses, joined by cubic splines; time 0 is the first sample.
    ///
    /// # Errors
    /// [`Error::Invalid`] with origin `path` when there are fewer than two samples, a number is not finite or the times
    /// do not increase.
    pub fn from_samples(samples: &[PoseSample]) -> Result<Self, Error> {
        let course = samples::SampledCourse::new(samples)?;
        Ok(Self {
            course: Course::Samples(course),
        })
    }

    /// Reads a drive from a file of poses: `*.csv` with the header `t_s,x_m,y_m,heading_rad`, anything else as TUM
    /// trajectory (`t x y z qx qy qz qw`, `#` starts a comment).
    ///
    /// # Errors
    /// [`Error::Io`] when the file cannot be read, [`Error::Invalid`] naming the file and line otherwise.
    pub fn read(file: &Path) -> Result<Self, Error> {
        Self::from_samples(&samples::read(file)?)
            .map_err(|error| relocate(error, file.display(), ""))
    }

    /// A drive from the text of such a file: CSV with a header, or a TUM trajectory; errors name `origin`.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the line.
    pub fn from_text(text: &str, is_csv: bool, origin: &str) -> Result<Self, Error> {
        samples::parse(text, is_csv)
            .and_then(|samples| Self::from_samples(&samples))
            .map_err(|error| relocate(error, origin, ""))
    }

    /// Length of the drive in seconds.
    pub fn duration_s(&self) -> f64 {
        match &self.course {
            Course::Commands(course) => course.duration_s(),
            Course::Samples(course) => course.duration_s(),
        }
    }

    /// Pose and speeds at time `t_s`, which is clamped to the drive; the position is exact to better than 1 um.
    pub fn state_at(&self, t_s: f64) -> MotionState {
        let t_s = t_s.clamp(0.0, self.duration_s());
        match &self.course {
            Course::Commands(course) => course.state_at(t_s),
            Course::Samples(course) => course.state_at(t_s),
        }
    }

    /// World point in metres, at time `t_s`, of the robot-frame offset `[forward, left]` in metres.
    pub fn point_at(&self, t_s: f64, offset_m: [f64; 2]) -> [f64; 2] {
        self.state_at(t_s).point(offset_m)
    }

    /// A bound on the speed in m/s of any point of the robot within `radius_m` of its centre.
    pub fn max_speed_mps(&self, radius_m: f64) -> f64 {
        match &self.course {
            Course::Commands(course) => course.max_speed_mps(radius_m),
            Course::Samples(course) => course.max_speed_mps(radius_m),
        }
    }
}
