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
    /// Whether a person walks around there, whose echo moves by itself and who hides what is behind.
    pub(crate) person: bool,
    /// Middle and radius of a round pillar, m: it mirrors at its near side.
    pub(crate) pillar: Option<([f64; 2], f64)>,
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
            person: false,
            pillar: None,
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

    /// Place (m) and velocity (m/s) of the person: 1.4 m from where the drive began on average, near and far, at a
    /// walking pace.
    fn person_at(&self) -> [[f64; 2]; 2] {
        let place = |t_s: f64| {
            let (angle, radius_m) = (0.45 * t_s, 1.4 + 0.5 * (0.31 * t_s).sin());
            [radius_m * angle.cos(), radius_m * angle.sin()]
        };
        let (here, soon) = (place(self.time), place(self.time + 1e-3));
        [here, [0, 1].map(|k| (soon[k] - here[k]) / 1e-3)]
    }

    /// Whether the person stands in the way to a landmark.
    fn is_hidden(&self, shape: &Shape) -> bool {
        let [place, _] = self.person_at();
        let pose = &self.pose;
        let towards = match *shape {
            Shape::Wall { normal_rad, .. } => [normal_rad.cos(), normal_rad.sin()],
            Shape::Point { place_m: [x, y] } => {
                let (dx, dy) = (x - pose.x_m, y - pose.y_m);
                let range_m = dx.hypot(dy).max(1e-9);
                [dx / range_m, dy / range_m]
            }
        };
        let [dx, dy] = [place[0] - pose.x_m, place[1] - pose.y_m];
        let (along, across) = (
            dx * towards[0] + dy * towards[1],
            dy * towards[0] - dx * towards[1],
        );
        along > 0.0 && across.abs() < 0.25
    }

    /// Range and cosine of the person's echo: of a walking one Doppler says another cosine than of what stands.
    fn echo_of_person(&self, v_mps: f64) -> (f64, f64) {
        let [place, velocity] = self.person_at();
        let [dx, dy] = [place[0] - self.pose.x_m, place[1] - self.pose.y_m];
        let range_m = dx.hypot(dy).max(1e-9);
        let (sine, cosine) = self.pose.heading_rad.sin_cos();
        let own = v_mps * (dx * cosine + dy * sine) / range_m;
        let approach = own - (velocity[0] * dx + velocity[1] * dy) / range_m;
        (range_m, approach / v_mps)
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
            if self.person && self.is_hidden(shape) {
                continue;
            }
            let mut normal = |sigma: f64| sigma * self.random.sample::<f64, _>(StandardNormal);
            peaks.push(Peak {
                range_m: echo.range_m + normal(RANGE_SIGMA_M),
                cosine: (echo.cosine + normal(sigma)).clamp(-1.0, 1.0),
                amplitude: 0.1,
            });
        }
        let mut others = Vec::new();
        if self.person {
            others.push(self.echo_of_person(true_motion.v_mps));
        }
        if let Some((place_m, radius_m)) = self.pillar {
            let echo = Shape::Point { place_m }.echo(&self.pose, &motion);
            others.push((echo.range_m - radius_m, echo.cosine));
        }
        for (range_m, cosine) in others {
            let mut normal = |sigma: f64| sigma * self.random.sample::<f64, _>(StandardNormal);
            let (range_m, cosine) = (range_m + normal(RANGE_SIGMA_M), cosine + normal(sigma));
            // The bank has no directions beyond straight ahead and back.
            if range_m > 0.25 && cosine.abs() <= 1.0 {
                peaks.push(Peak {
                    range_m,
                    cosine,
                    amplitude: 0.1,
                });
            }
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
