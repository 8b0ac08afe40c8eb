//! Poses in the plane.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

/// Position and heading in the world frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Position to the right in metres.
    pub x_m: f64,
    /// Position upwards in metres.
    pub y_m: f64,
    /// Heading in radians, counter-clockwise from +x.
    pub heading_rad: f64,
}

impl Pose {
    /// Distance between two positions in metres.
    pub fn distance_m(&self, other: &Self) -> f64 {
        (self.x_m - other.x_m).hypot(self.y_m - other.y_m)
    }

    /// The pose of a point that the robot carries at `[forward, left]` metres from its own.
    pub fn carried(&self, offset_m: [f64; 2]) -> Self {
        let (sine, cosine) = self.heading_rad.sin_cos();
        let [forward, left] = offset_m;
        Self {
            x_m: self.x_m + cosine * forward - sine * left,
            y_m: self.y_m + sine * forward + cosine * left,
            heading_rad: self.heading_rad,
        }
    }

    /// True when no component is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite() && self.heading_rad.is_finite()
    }
}

/// The same angle in (-pi, pi].
pub fn wrap_angle(angle_rad: f64) -> f64 {
    if angle_rad > -PI && angle_rad <= PI {
        return angle_rad;
    }
    let turned = angle_rad.rem_euclid(2.0 * PI);
    if turned > PI {
        turned - 2.0 * PI
    } else {
        turned
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_carried_point_turns_with_the_robot() {
        let pose = Pose {
            x_m: 1.0,
            y_m: 2.0,
            heading_rad: 0.5 * PI,
        };
        let carried = pose.carried([0.3, 0.1]);
        assert!((carried.x_m - 0.9).abs() < 1e-12 && (carried.y_m - 2.3).abs() < 1e-12);
        assert_eq!(carried.heading_rad, pose.heading_rad);
    }

    #[test]
    fn angles_wrap_into_the_half_open_turn() {
        assert_eq!(wrap_angle(PI), PI);
        assert_eq!(wrap_angle(-PI), PI);
        assert_eq!(wrap_angle(0.0), 0.0);
        for k in -5..=5 {
            let angle = 1.25 + 2.0 * PI * f64::from(k);
            assert!((wrap_angle(angle) - 1.25).abs() < 1e-12);
            assert!((wrap_angle(-angle) + 1.25).abs() < 1e-12);
        }
    }
}
