//! Landmarks: what gives one echo each, as a function of the pose.

use nalgebra::RowVector3;

use crate::filter::motion_model::advance;
use crate::odometry::Odometry;
use crate::parameters::Integration;
use crate::pose::Pose;

/// What an echo comes from, in the world frame.
///
/// Loudspeaker and microphone are taken to be in one place. The image of the robot in a wall, and in a wall seen in
/// another wall, gives the echo of a [`Shape::Wall`]; a reflector without extent and a closed right-angled corner,
/// whose image moves as a point reflector's does, give that of a [`Shape::Point`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// The line of all points q with `normal . q = distance`.
    Wall {
        /// Direction of the normal in radians, from the robot's side to the wall.
        normal_rad: f64,
        /// Signed distance of the line from the origin along the normal, in metres.
        distance_m: f64,
    },
    /// A place `[x, y]` in metres.
    Point {
        /// The place.
        place_m: [f64; 2],
    },
}

/// The echo of a landmark at a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Half the length of the path in metres.
    pub range_m: f64,
    /// Cosine of the angle between the heading and the direction of the echo.
    pub cosine: f64,
    /// Derivatives of the range by x, y (m/m) and heading (m/rad).
    pub range_by_pose: RowVector3<f64>,
    /// Derivatives of the cosine by x, y (1/m) and heading (1/rad).
    pub cosine_by_pose: RowVector3<f64>,
    /// Derivatives of the range by the two numbers of the landmark: normal and distance, or x and y.
    pub range_by_shape: [f64; 2],
    /// Derivatives of the cosine by the two numbers of the landmark.
    pub cosine_by_shape: [f64; 2],
}

/// How the robot moves while it hears an echo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Speed and turn rate.
    pub odometry: Odometry,
    /// Speed of sound in m/s.
    pub c_mps: f64,
}

impl Shape {
    /// The echo that a moving robot hears at a pose.
    ///
    /// Sound that arrives now was sent 2 r/c ago. Half its path is the range from where the robot was in the middle
    /// of that time, r/c ago, to first order in v/c (a robot's is 0.001); so is its Doppler shift. Derivatives are
    /// those at rest: they differ by parts of v/c.
    pub fn echo(&self, pose: &Pose, motion: &Motion) -> Prediction {
        let way_s = self.predict(pose).range_m / motion.c_mps;
        let earlier = advance(pose, motion.odometry, -way_s, Integration::Midpoint);
        self.predict(&earlier)
    }

    /// Range and bearing of the echo for a robot at rest at a pose, with all derivatives.
    ///
    /// A wall behind the robot has a negative range: it gives no echo there. At a point itself the derivatives are
    /// those of a direction along the heading.
    pub fn predict(&self, pose: &Pose) -> Prediction {
        let (sine, cosine) = pose.heading_rad.sin_cos();
        match *self {
            Self::Wall {
                normal_rad,
                distance_m,
            } => {
                let (ny, nx) = normal_rad.sin_cos();
                let toward = nx * cosine + ny * sine;
                let across = ny * cosine - nx * sine;
                Prediction {
                    range_m: distance_m - nx * pose.x_m - ny * pose.y_m,
                    cosine: toward,
                    range_by_pose: RowVector3::new(-nx, -ny, 0.0),
                    cosine_by_pose: RowVector3::new(0.0, 0.0, across),
                    range_by_shape: [ny * pose.x_m - nx * pose.y_m, 1.0],
                    cosine_by_shape: [-across, 0.0],
                }
            }
            Self::Point { place_m } => {
                let (dx, dy) = (place_m[0] - pose.x_m, place_m[1] - pose.y_m);
                let range_m = dx.hypot(dy);
                let (ux, uy) = if range_m > 0.0 {
                    (dx / range_m, dy / range_m)
                } else {
                    (cosine, sine)
                };
                let toward = ux * cosine + uy * sine;
                let across = uy * cosine - ux * sine;
                // The direction turns by what lies across it, over the range.
                let near = range_m.max(1e-3);
                let by_place = [(cosine - toward * ux) / near, (sine - toward * uy) / near];
                Prediction {
                    range_m,
                    cosine: toward,
                    range_by_pose: RowVector3::new(-ux, -uy, 0.0),
                    cosine_by_pose: RowVector3::new(-by_place[0], -by_place[1], across),
                    range_by_shape: [ux, uy],
                    cosine_by_shape: by_place,
                }
            }
        }
    }

    /// The same landmark with its two numbers changed: normal and distance, or x and y.
    #[must_use]
    pub fn moved(&self, change: [f64; 2]) -> Self {
        match *self {
            Self::Wall {
                normal_rad,
                distance_m,
            } => Self::Wall {
                normal_rad: normal_rad + change[0],
                distance_m: distance_m + change[1],
            },
            Self::Point { place_m } => Self::Point {
                place_m: [place_m[0] + change[0], place_m[1] + change[1]],
            },
        }
    }

    /// Where along the landmark a pose sees it: metres along the wall (its foot point), or the direction in radians
    /// from the point to the pose.
    pub fn aspect(&self, pose: &Pose) -> f64 {
        match *self {
            Self::Wall { normal_rad, .. } => {
                let (ny, nx) = normal_rad.sin_cos();
                nx * pose.y_m - ny * pose.x_m
            }
            Self::Point { place_m } => (pose.y_m - place_m[1]).atan2(pose.x_m - place_m[0]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn derivatives_are_those_of_finite_differences(
            x in -5.0..5.0, y in -5.0..5.0, heading in -4.0..4.0,
            first in -4.0..4.0, second in -4.0..4.0, wall: bool,
        ) {
            let shape = if wall {
                Shape::Wall { normal_rad: first, distance_m: second }
            } else {
                Shape::Point { place_m: [first, second] }
            };
            let pose = Pose { x_m: x, y_m: y, heading_rad: heading };
            let here = shape.predict(&pose);
            prop_assume!(wall || here.range_m > 0.1);
            let step = 1e-6;
            let by_pose = |k: usize| {
                let moved = |sign: f64| {
                    let mut numbers = [x, y, heading];
                    numbers[k] += sign * step;
                    let [x_m, y_m, heading_rad] = numbers;
                    shape.predict(&Pose { x_m, y_m, heading_rad })
                };
                (moved(1.0), moved(-1.0))
            };
            for k in 0..3 {
                let (after, before) = by_pose(k);
                let range = (after.range_m - before.range_m) / (2.0 * step);
                let cosine = (after.cosine - before.cosine) / (2.0 * step);
                prop_assert!((range - here.range_by_pose[k]).abs() < 1e-6);
                prop_assert!((cosine - here.cosine_by_pose[k]).abs() < 1e-6);
            }
            for k in 0..2 {
                let moved = |sign: f64| {
                    let mut change = [0.0; 2];
                    change[k] = sign * step;
                    shape.moved(change).predict(&pose)
                };
                let (after, before) = (moved(1.0), moved(-1.0));
                let range = (after.range_m - before.range_m) / (2.0 * step);
                let cosine = (after.cosine - before.cosine) / (2.0 * step);
                prop_assert!((range - here.range_by_shape[k]).abs() < 1e-6);
                prop_assert!((cosine - here.cosine_by_shape[k]).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_straight_drive_at_a_wall_measures_half_the_path_of_its_sound() {
        // The wall x = 5, approached at 20 m/s: sound sent at x1 arrives at x = 1 a time (5 - x1 + 5 - 1)/c later.
        let wall = Shape::Wall {
            normal_rad: 0.0,
            distance_m: 5.0,
        };
        let (v_mps, c_mps) = (20.0_f64, 340.0_f64);
        let path_m: f64 = 2.0 * 4.0 / (1.0 - v_mps / c_mps);
        assert!((path_m - (4.0 + v_mps * path_m / c_mps) - 4.0).abs() < 1e-12);
        let motion = Motion {
            odometry: Odometry {
                v_mps,
                omega_radps: 0.0,
            },
            c_mps,
        };
        let pose = Pose {
            x_m: 1.0,
            ..Pose::default()
        };
        let mut echo = wall.echo(&pose, &motion);
        // First order in v/c, which is 0.06 here and 0.001 for a robot.
        assert!((echo.range_m - 0.5 * path_m).abs() < 4.0 * (v_mps / c_mps).powi(2));
        echo = wall.echo(
            &pose,
            &Motion {
                c_mps: 3e5,
                ..motion
            },
        );
        assert!((echo.range_m - 4.0 / (1.0 - v_mps / 3e5)).abs() < 1e-7);
    }

    #[test]
    fn a_pose_in_front_of_a_wall_sees_its_foot_point() {
        // The wall x = 3, seen from (1, 2).
        let wall = Shape::Wall {
            normal_rad: 0.0,
            distance_m: 3.0,
        };
        let pose = Pose {
            x_m: 1.0,
            y_m: 2.0,
            heading_rad: 0.0,
        };
        let echo = wall.predict(&pose);
        assert_eq!((echo.range_m, echo.cosine), (2.0, 1.0));
        assert_eq!(wall.aspect(&pose), 2.0);
    }
}
