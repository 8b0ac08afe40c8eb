//! The extended Kalman filter (2021, eqs. (1) and (6)).

use super::arrivals::ArrivalBlock;
use super::{association::associate, prediction::Predictor};
use crate::odometry::Odometry;
use crate::pose::{Pose, wrap_angle};
use crate::trajectory::Trajectory;

/// Noise of the wheels and of the arrival times, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Speed in m/s.
    pub v_mps: f64,
    /// Turning rate in rad/s.
    pub omega_radps: f64,
    /// Arrival time in seconds.
    pub time_s: f64,
    /// Largest innovation that is used, in seconds.
    pub gate_s: f64,
}

/// Pose and covariance.
#[derive(Debug, Clone)]
pub struct Ekf {
    pose: Pose,
    covariance: [[f64; 3]; 3],
    noise: Noise,
}

impl Ekf {
    /// Starts at a known pose.
    pub fn new(start: Pose, noise: Noise) -> Self {
        Self {
            pose: start,
            covariance: [[0.0; 3]; 3],
            noise,
        }
    }

    /// The present estimate.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// Processes (i) to (iv) of Fig. 1.
    pub fn step(
        &mut self,
        speeds: Odometry,
        dt_s: f64,
        measured_s: &[f64],
        predictor: &Predictor,
    ) -> Pose {
        self.advance(speeds, dt_s);
        let innovations = associate(
            measured_s,
            &predictor.predict(&self.pose),
            self.noise.gate_s,
        );
        let mut change = [0.0; 3];
        for innovation in innovations {
            self.correct(innovation.error_s, innovation.jacobian, &mut change);
        }
        self.pose.x_m += change[0];
        self.pose.y_m += change[1];
        self.pose.heading_rad = wrap_angle(self.pose.heading_rad + change[2]);
        self.pose
    }

    /// Eq. (1) along the heading in the middle of the step, which does not lag in turns as the printed form does;
    /// covariance `F P F' + G Q G'`.
    fn advance(&mut self, speeds: Odometry, dt_s: f64) {
        let turn_rad = speeds.omega_radps * dt_s;
        let (sin, cos) = (self.pose.heading_rad + 0.5 * turn_rad).sin_cos();
        let step_m = speeds.v_mps * dt_s;
        let f = [
            [1.0, 0.0, -step_m * sin],
            [0.0, 1.0, step_m * cos],
            [0.0, 0.0, 1.0],
        ];
        let (along, turn) = (self.noise.v_mps * dt_s, self.noise.omega_radps * dt_s);
        let g = [
            [cos * along, -0.5 * step_m * sin * turn],
            [sin * along, 0.5 * step_m * cos * turn],
            [0.0, turn],
        ];
        let p = self.covariance;
        self.covariance = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let carried: f64 = (0..9)
                    .map(|k| f[i][k / 3] * p[k / 3][k % 3] * f[j][k % 3])
                    .sum();
                carried + g[i][0] * g[j][0] + g[i][1] * g[j][1]
            })
        });
        self.pose.x_m += step_m * cos;
        self.pose.y_m += step_m * sin;
        self.pose.heading_rad = wrap_angle(self.pose.heading_rad + turn_rad);
    }

    /// Eq. (6) for one arrival: with independent noise, one after the other equals all at once.
    fn correct(&mut self, error_s: f64, h: [f64; 3], change: &mut [f64; 3]) {
        let p = self.covariance;
        let ph: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| p[i][j] * h[j]).sum());
        let variance = self.noise.time_s.powi(2) + (0..3).map(|i| h[i] * ph[i]).sum::<f64>();
        let left_s = error_s - (0..3).map(|i| h[i] * change[i]).sum::<f64>();
        for i in 0..3 {
            change[i] += ph[i] / variance * left_s;
        }
        self.covariance =
            std::array::from_fn(|i| std::array::from_fn(|j| p[i][j] - ph[i] * ph[j] / variance));
    }
}

/// Follows the blocks of a recording from a known start at time 0: the start and one pose for each block.
pub fn follow(
    blocks: &[ArrivalBlock],
    predictor: &Predictor,
    noise: Noise,
    start: Pose,
) -> Trajectory {
    let mut ekf = Ekf::new(start, noise);
    let mut trajectory = Trajectory {
        t_s: vec![0.0],
        poses: vec![start],
    };
    for block in blocks {
        let pose = ekf.step(block.odometry, block.step_s, &block.times_s, predictor);
        trajectory.t_s.push(block.t_s);
        trajectory.poses.push(pose);
    }
    trajectory
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::multipath::planes::tests::room;
    use crate::multipath::prediction::Model;

    /// Domain: 4 m x 5 m x 2.5 m, exact arrival times, wheels 10 % fast; tolerance 0.02 m where odometry is 0.1 m off.
    #[test]
    fn exact_times_correct_wheels_that_slip() {
        let planes = room([1., 0., 0.]);
        let predictor = Predictor::new(&planes, Model::Spatial, [0.3, 0.4], 346.0);
        let mut truth = Pose {
            x_m: 1.1,
            y_m: 1.7,
            heading_rad: 0.5,
        };
        let noise = Noise {
            v_mps: 0.05,
            omega_radps: 0.02,
            time_s: 2e-5,
            gate_s: 2e-4,
        };
        let mut ekf = Ekf::new(truth, noise);
        for _ in 0..50 {
            truth.x_m += 0.02 * truth.heading_rad.cos();
            truth.y_m += 0.02 * truth.heading_rad.sin();
            let times: Vec<f64> = predictor.predict(&truth).iter().map(|a| a.time_s).collect();
            ekf.step(
                Odometry {
                    v_mps: 0.22,
                    omega_radps: 0.0,
                },
                0.1,
                &times,
                &predictor,
            );
        }
        assert!(
            ekf.pose().distance_m(&truth) < 0.02,
            "{:?} {truth:?}",
            ekf.pose()
        );
    }
}
