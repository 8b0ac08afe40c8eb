//! Pose and speeds at one time, their ranges, and the origin of errors.

use crate::error::Error;

/// Longest drive that is accepted, in seconds.
pub const MAX_DURATION_S: f64 = 3600.0;
/// Fastest turn that is accepted, in rad/s.
pub const MAX_TURN_RADPS: f64 = 20.0;
/// Fastest drive that is accepted, in m/s. [`crate::scene::Scene::check`] allows less: half the speed of sound.
pub const MAX_SPEED_MPS: f64 = 1000.0;

/// Pose and speeds of the robot at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionState {
    /// Position of the robot's centre in metres.
    pub x_m: f64,
    /// Position of the robot's centre in metres.
    pub y_m: f64,
    /// Heading in radians, counter-clockwise from +x, continuous (not wrapped).
    pub heading_rad: f64,
    /// Speed along the heading in m/s.
    pub v_mps: f64,
    /// Turn rate in rad/s, counter-clockwise.
    pub omega_radps: f64,
}

impl MotionState {
    /// World point in metres of the robot-frame offset `[forward, left]` in metres.
    pub fn point(&self, offset_m: [f64; 2]) -> [f64; 2] {
        if offset_m == [0.0, 0.0] {
            return [self.x_m, self.y_m];
        }
        let (sin, cos) = self.heading_rad.sin_cos();
        [
            self.x_m + cos * offset_m[0] - sin * offset_m[1],
            self.y_m + sin * offset_m[0] + cos * offset_m[1],
        ]
    }
}

/// The same error said about another file, with `prefix` before the field's path.
pub(crate) fn relocate(error: Error, origin: impl std::fmt::Display, prefix: &str) -> Error {
    match error {
        Error::Invalid {
            field,
            problem,
            remedy,
            ..
        } => Error::invalid(origin, format!("{prefix}{field}"), problem, remedy),
        other => other,
    }
}
