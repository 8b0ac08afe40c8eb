//! A place of known landmarks and a drive in it whose blocks hold their echoes with noise, and clutter: what learning
//! and filter are tested on.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::hypothesis::Seen;
use super::landmark::{Motion, Shape};
use super::peaks::Peak;
use super::sighting::{Sighting, cosine_sigma};
use crate::filter::motion_model::advance;
use crate::odometry::Odometry;
use crate::parameters::{Integration, Parameters};
use crate::pose::Pose;
use crate::random;

/// Standard deviation of the ranges in metres.
pub(crate) const RANGE_SIGMA_M: f64 = 0.001;

/// Three walls, no two of them parallel, and a corner.
pub(crate) fn shapes() -> Vec<Shape> {
    let wall = |degrees: f64, distance_m: f64| Shape::Wall {
        normal_rad: degrees.to_radians(),
        distance_m,
    };
    vec![
        wall(10.0, 2.6),
        wall(130.0, 2.2),
        wall(255.0, 1.9),
        Shape::Point {
            place_m: [1.9, -1.3],
        },
    ]
}

/// A drive: its blocks one by one.
pub(crate) struct Drive {
    pub(crate) parameters: Parameters,
    /// What turn rate the wheels report too much, in rad/s, and the share of speed.
    pub(crate) wheel_errors: [f64; 2],
    pose: Pose,
    shapes: Vec<Shape>,
    random: ChaCha8Rng,
    time: f64,
    rate: f64,
}

/// A block of a drive.
pub(crate) struct Block {
    pub(crate) truth: Pose,
    pub(crate) sighting: Sighting,
    /// The wheels' word on the block, and on the step to it.
    pub(crate) odometry: Odometry,
}

impl Block {
    pub(crate) fn seen<'a>(&'a self, parameters: &'a Parameters) -> Seen<'a> {
        Seen {
            peaks: &self.sighting.peaks,
            cosine_sigma: self.sighting.cosine_sigma,
            odometry: self.odometry,
            signal: &parameters.signal,
        }
    }
}

impl Drive {
    pub(crate) fn new(seed: u64, shapes: Vec<Shape>) -> Self {
        let mut parameters = Parameters::default();
        parameters.measurement.periods = super::PERIODS;
        let mut random = random::stream(seed, "simulated drive");
        let rate = random.random_range(0.25..0.6);
        Self {
            parameters,
            wheel_errors: [0.0; 2],
            pose: Pose {
                x_m: random.random_range(-0.5..0.5),
                y_m: random.random_range(-0.5..0.5),
                heading_rad: random.random_range(-3.0..3.0),
            },
            shapes,
            random,
            time: 0.0,
            rate,
        }
    }

    /// Carries the robot elsewhere without its wheels knowing.
    pub(crate) fn kidnap(&mut self, pose: Pose) {
        self.pose = pose;
    }

    pub(crate) fn pose(&self) -> Pose {
        self.pose
    }
}

impl Iterator for Drive {
    type Item = Block;

    /// Eights around where it began, at 0.3 m/s.
    fn next(&mut self) -> Option<Block> {
        let step_s = self.parameters.period_s();
        self.time += step_s;
        let turn = if (self.time * self.rate).rem_euclid(4.0) < 2.0 {
            0.9
        } else {
            -0.7
        };
        let true_motion = Odometry {
            v_mps: 0.3,
            omega_radps: turn,
        };
        self.pose = advance(&self.pose, true_motion, step_s, Integration::Midpoint);
        let sigma = cosine_sigma(&self.parameters, true_motion.v_mps);
        let motion = Motion::new(true_motion, &self.parameters.signal);
        let mut peaks = Vec::new();
        for shape in &self.shapes {
            let echo = shape.echo(&self.pose, &motion);
            // One in ten is hidden.
            if echo.range_m < 0.25 || self.random.random_bool(0.1) {
                continue;
            }
            let mut normal = |sigma: f64| sigma * self.random.sample::<f64, _>(StandardNormal);
            peaks.push(Peak {
                range_m: echo.range_m + normal(RANGE_SIGMA_M),
                cosine: (echo.cosine + normal(sigma)).clamp(-1.0, 1.0),
                amplitude: 0.1,
            });
        }
        for _ in 0..5 {
            peaks.push(Peak {
                range_m: self.random.random_range(0.3..8.0),
                cosine: self.random.random_range(-1.0..1.0),
                amplitude: 0.02,
            });
        }
        let [turn_error, speed_error] = self.wheel_errors;
        let odometry = Odometry {
            v_mps: true_motion.v_mps * (1.0 + speed_error),
            omega_radps: true_motion.omega_radps + turn_error,
        };
        Some(Block {
            truth: self.pose,
            sighting: Sighting {
                pose: self.pose,
                motion,
                cosine_sigma: sigma,
                peaks,
            },
            odometry,
        })
    }
}
