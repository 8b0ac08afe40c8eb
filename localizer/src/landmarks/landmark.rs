//! Landmarks: what gives one echo each, as a function of the pose.

use nalgebra::RowVector3;

use crate::filter::motion_model::advance;
use crate::odometry::Odometry;
use crate::parameters::{Integration, SignalParameters};
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

/// How the robot moves while an echo arrives, and where it carries its loudspeaker and microphone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Speed and turn rate.
    pub odometry: Odometry,
    /// Speed of sound in m/s.
    pub c_mps: f64,
    /// The middle between loudspeaker and microphone, `[forward, left]` of the robot's pose in metres.
    pub middle_m: [f64; 2],
    /// The microphone's place less the loudspeaker's, `[forward, left]` in metres.
    pub baseline_m: [f64; 2],
}

impl Motion {
    /// The motion in a block of a drive with these parameters.
    pub fn new(odometry: Odometry, signal: &SignalParameters) -> Self {
        Self {
            odometry,
            c_mps: signal.speed_of_sound_mps,
            middle_m: signal.sensor_offset_m,
            baseline_m: signal.sensor_baseline_m,
        }
    }
}

/// Speed in m/s below which a Doppler shift is not divided by it.
const LEAST_SPEED_MPS: f64 = 1e-3;

impl Shape {
    /// The echo that a moving robot receives at a pose; the range counts from the middle between its transducers.
    ///
    /// Sound that arrives now was sent 2 r/c ago. Half its path is the range from where the robot was in the middle
    /// of that time, r/c ago, to first order in v/c (a robot's is 0.001); so is its Doppler shift. A turn moves
    /// transducers ahead of the axle sideways, which shifts the frequency of echoes from the side. Derivatives leave
    /// out parts of the order of v/c and of the baseline over the range.
    pub fn echo(&self, pose: &Pose, motion: &Motion) -> Prediction {
        let Motion {
            odometry,
            c_mps,
            middle_m: [forward_m, left_m],
            baseline_m,
        } = *motion;
        let way_s = self.predict(&pose.carried(motion.middle_m)).range_m / c_mps;
        let robot = advance(pose, odometry, -way_s, Integration::Midpoint);
        let middle = robot.carried(motion.middle_m);
        let mut echo = self.predict(&middle);
        // The middle goes around the robot's pose as the heading turns.
        let (sine, cosine) = robot.heading_rad.sin_cos();
        let turning = [
            -sine * forward_m - cosine * left_m,
            cosine * forward_m - sine * left_m,
        ];
        echo.range_by_pose[2] +=
            echo.range_by_pose[0] * turning[0] + echo.range_by_pose[1] * turning[1];
        // The path to a wall and back spans the baseline's part along the wall, too.
        if let Self::Wall { normal_rad, .. } = *self {
            let (ny, nx) = normal_rad.sin_cos();
            let [ahead_m, aside_m] = baseline_m;
            let along_m = ahead_m * (nx * sine - ny * cosine) + aside_m * (nx * cosine + ny * sine);
            if echo.range_m > 0.0 {
                echo.range_m = echo.range_m.hypot(0.5 * along_m);
            }
        }
        let v_mps = odometry.v_mps;
        if v_mps.abs() > LEAST_SPEED_MPS {
            let toward = (v_mps - odometry.omega_radps * left_m) / v_mps;
            let aside = odometry.omega_radps * forward_m / v_mps;
            let [here, across] = [echo.cosine, echo.cosine_by_pose[2]];
            echo.cosine = toward * here + aside * across;
            echo.cosine_by_pose[2] = toward * across - aside * here;
        }
        echo
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

    /// Half the path of sound that is sent by the loudspeaker and arrives at the microphone at the time 0, and the
    /// rate at which it grows, by the mirror image in the wall x = 0 and a search for the time of sending.
    fn half_path_m(pose: &Pose, motion: &Motion, t_s: f64) -> f64 {
        let at = |t_s: f64, sign: f64| {
            let robot = advance(pose, motion.odometry, t_s, Integration::Midpoint);
            let place = [0, 1].map(|k| motion.middle_m[k] + 0.5 * sign * motion.baseline_m[k]);
            robot.carried(place)
        };
        let microphone = at(t_s, 1.0);
        let path_m = |sent_s: f64| {
            let loudspeaker = at(sent_s, -1.0);
            (microphone.x_m + loudspeaker.x_m).hypot(microphone.y_m - loudspeaker.y_m)
        };
        let mut sent_s = t_s;
        for _ in 0..50 {
            sent_s = t_s - path_m(sent_s) / motion.c_mps;
        }
        0.5 * path_m(sent_s)
    }

    proptest! {
        #[test]
        fn half_the_path_and_its_rate_are_those_of_the_mirrored_loudspeaker(
            x in -4.0..-0.5, y in -1.0..1.0, heading in -3.0..3.0, v in 0.1..0.5, omega in -0.8..0.8,
            forward in -0.2..0.2, left in -0.2..0.2, ahead in -0.2..0.2, c in 330.0..350.0,
        ) {
            let pose = Pose { x_m: x, y_m: y, heading_rad: heading };
            let motion = Motion {
                odometry: Odometry { v_mps: v, omega_radps: omega },
                c_mps: c,
                middle_m: [forward, left],
                baseline_m: [ahead, 0.0],
            };
            let wall = Shape::Wall { normal_rad: 0.0, distance_m: 0.0 };
            let echo = wall.echo(&pose, &motion);
            let exact_m = half_path_m(&pose, &motion, 0.0);
            prop_assert!((echo.range_m - exact_m).abs() < 2e-4, "{} {exact_m}", echo.range_m);
            let step_s = 1e-3;
            let rate_mps = (half_path_m(&pose, &motion, step_s) - half_path_m(&pose, &motion, -step_s)) / (2.0 * step_s);
            // An approach at the whole speed has the cosine 1.
            prop_assert!((echo.cosine + rate_mps / v).abs() < 0.05, "{} {}", echo.cosine, -rate_mps / v);
        }
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
