//! Motion model of a two-wheel robot: eq. (8) without its noise, and dead reckoning.

use crate::odometry::Odometry;
use crate::parameters::{Integration, Parameters};
use crate::pose::{Pose, wrap_angle};
use crate::recording::Recording;
use crate::trajectory::Trajectory;

/// The pose after `duration_s` seconds at constant speeds, eq. (8) without noise.
///
/// `Euler` is eq. (8) as printed; `Midpoint` moves along the heading in the middle of the step, which removes the
/// half step by which the printed form lags behind in a turn.
///
/// ```
/// use localizer::filter::motion_model::advance;
/// use localizer::{Integration, Odometry, Pose};
///
/// let odometry = Odometry { v_mps: 0.5, omega_radps: 0.0 };
/// let pose = advance(&Pose::default(), odometry, 2.0, Integration::Midpoint);
/// assert_eq!((pose.x_m, pose.y_m), (1.0, 0.0));
/// ```
pub fn advance(pose: &Pose, odometry: Odometry, duration_s: f64, integration: Integration) -> Pose {
    let turn_rad = odometry.omega_radps * duration_s;
    let course_rad = match integration {
        Integration::Midpoint => pose.heading_rad + 0.5 * turn_rad,
        Integration::Euler => pose.heading_rad,
    };
    let way_m = odometry.v_mps * duration_s;
    Pose {
        x_m: pose.x_m + way_m * course_rad.cos(),
        y_m: pose.y_m + way_m * course_rad.sin(),
        heading_rad: wrap_angle(pose.heading_rad + turn_rad),
    }
}

/// Dead reckoning: poses by wheel odometry alone at the start and end of every whole period of a recording, from
/// `start` at time 0.
pub fn dead_reckon(recording: &Recording, parameters: &Parameters, start: Pose) -> Trajectory {
    let period_s = parameters.period_s();
    let count = (recording.duration_s() / period_s) as usize;
    let mut trajectory = Trajectory {
        t_s: vec![0.0],
        poses: vec![start],
    };
    let mut pose = start;
    for (n, odometry) in recording
        .odometry_per_period(period_s, count)
        .into_iter()
        .enumerate()
    {
        pose = advance(&pose, odometry, period_s, parameters.filter.integration);
        trajectory.t_s.push((n + 1) as f64 * period_s);
        trajectory.poses.push(pose);
    }
    trajectory
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_closes() {
        let odometry = Odometry {
            v_mps: 0.3,
            omega_radps: 0.5,
        };
        let steps = 200;
        let step_s = std::f64::consts::TAU / 0.5 / f64::from(steps);
        for integration in [Integration::Midpoint, Integration::Euler] {
            let mut pose = Pose {
                x_m: 1.0,
                y_m: 2.0,
                heading_rad: 0.3,
            };
            let mut farthest_m: f64 = 0.0;
            for _ in 0..steps {
                pose = advance(&pose, odometry, step_s, integration);
                farthest_m = farthest_m.max(pose.distance_m(&Pose {
                    x_m: 1.0,
                    y_m: 2.0,
                    heading_rad: 0.0,
                }));
            }
            assert!(
                pose.distance_m(&Pose {
                    x_m: 1.0,
                    y_m: 2.0,
                    heading_rad: 0.3
                }) < 1e-9
            );
            assert!((pose.heading_rad - 0.3).abs() < 1e-9);
            assert!((farthest_m - 1.2).abs() < 1e-3, "diameter {farthest_m}");
        }
    }

    #[test]
    fn the_printed_form_lags_half_a_step() {
        let odometry = Odometry {
            v_mps: 1.0,
            omega_radps: 1.0,
        };
        let euler = advance(&Pose::default(), odometry, 0.1, Integration::Euler);
        assert_eq!((euler.x_m, euler.y_m), (0.1, 0.0));
        let midpoint = advance(&Pose::default(), odometry, 0.1, Integration::Midpoint);
        // The exact arc: (sin 0.1, 1 - cos 0.1).
        assert!((midpoint.x_m - 0.1_f64.sin()).abs() < 1e-4);
        assert!((midpoint.y_m - (1.0 - 0.1_f64.cos())).abs() < 1e-5);
    }
}
