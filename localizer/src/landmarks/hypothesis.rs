//! One hypothesis of the pose: a Gaussian over pose, errors of the wheels and speed of sound, and its two steps.
//!
//! State, in this order: x and y in metres, heading in radians, what the wheels' turn rate lacks in rad/s, and, as
//! parts of one, what their speed lacks and what the set speed of sound lacks.

use nalgebra::{Matrix3, SMatrix, Vector6};

use super::expectation::{Expected, Match};
use super::landmark::Motion;
use super::map::LandmarkMap;
use super::peaks::{MOST_PEAKS, Peak};
use crate::odometry::Odometry;
use crate::parameters::SignalParameters;
use crate::pose::{Pose, wrap_angle};

/// Covariance of the state.
pub type Covariance = SMatrix<f64, 6, 6>;

/// Standard deviations of the robot's motion and of its echoes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// White noise of the speed as a density, metres per root second.
    pub way_m: f64,
    /// White noise of the turn rate as a density, radians per root second.
    pub turn_rad: f64,
    /// Wandering of the turn rate's error, rad/s per root second.
    pub turn_rate_drift_radps: f64,
    /// Wandering of the speed's error, parts per root second.
    pub speed_drift: f64,
    /// First uncertainty of the turn rate's error in rad/s.
    pub turn_rate_radps: f64,
    /// First uncertainty of the speed's error as a part of one.
    pub speed: f64,
    /// First uncertainty of the speed of sound as a part of one.
    pub sound: f64,
    /// What every range is uncertain by, beside its landmark's, in metres.
    pub range_m: f64,
    /// Blocks of which the errors are alike: they overlap, and interfering echoes stay beside each other.
    pub alike_blocks: f64,
}

impl Default for Noise {
    fn default() -> Self {
        Self {
            way_m: 0.001,
            turn_rad: 0.003,
            turn_rate_drift_radps: 0.02,
            speed_drift: 0.005,
            turn_rate_radps: 0.03,
            speed: 0.02,
            sound: 0.01,
            range_m: 0.0002,
            alike_blocks: 1.0,
        }
    }
}

/// One block as a filter takes it in.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    /// Its peaks, strongest first.
    pub peaks: &'a [Peak],
    /// Standard deviation of their cosines.
    pub cosine_sigma: f64,
    /// Odometry during the block.
    pub odometry: Odometry,
    /// Waveform, speed of sound and sensors of the drive.
    pub signal: &'a SignalParameters,
}

/// Squared Mahalanobis distance up to which a peak may belong to a landmark.
const GATE: f64 = 16.0;
/// Degrees of freedom of the residuals' heavy tails.
const TAILS: f64 = 4.0;
/// Times as many blocks count once in the weight of a hypothesis: what the map does not know makes errors that last.
const WEIGHT_BLOCKS: f64 = 4.0;
/// Part of a guess's blur that is left after a block.
const BLUR_KEPT: f64 = 0.75;
/// Blur in metres below which a guess has settled.
const SETTLED_M: f64 = 1e-3;
/// Steps to the best state of a block.
const ROUNDS: usize = 3;
/// Probability of being seen below which a landmark is not looked for.
const LEAST_VISIBLE: f64 = 0.02;
/// Peaks of no landmark to be expected, per metre of range and unit of cosine.
const CLUTTER: f64 = 0.8;

/// Echoes of landmarks that a hypothesis finds in a block.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Fit {
    /// Logarithm of the block's likelihood over that of a block of clutter.
    pub log_likelihood: f64,
    /// Landmarks that should have been seen (their probabilities, summed up).
    pub expected: f64,
    /// Those of them that were seen.
    pub found: f64,
}

/// A hypothesis.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// Mean of the state; the heading is in (-pi, pi].
    pub state: Vector6<f64>,
    /// Its covariance.
    pub covariance: Covariance,
    /// Logarithm of its weight.
    pub log_weight: f64,
    /// Uncertainty of all ranges, in metres, beside their own: a guess must not settle on the first echoes that are
    /// near.
    pub blur_m: f64,
}

impl Hypothesis {
    /// A hypothesis around a pose with standard deviations in metres and radians.
    pub fn new(pose: &Pose, sigma_m: f64, sigma_rad: f64, noise: &Noise) -> Self {
        let sigmas = [
            sigma_m,
            sigma_m,
            sigma_rad,
            noise.turn_rate_radps,
            noise.speed,
            noise.sound,
        ];
        Self {
            state: Vector6::new(pose.x_m, pose.y_m, pose.heading_rad, 0.0, 0.0, 0.0),
            covariance: Covariance::from_diagonal(&Vector6::from(
                sigmas.map(|sigma| sigma * sigma),
            )),
            log_weight: 0.0,
            blur_m: 0.0,
        }
    }

    /// The mean pose.
    pub fn pose(&self) -> Pose {
        Pose {
            x_m: self.state[0],
            y_m: self.state[1],
            heading_rad: self.state[2],
        }
    }

    /// The robot's motion during a block, less the errors of its wheels.
    fn motion(&self, seen: &Seen<'_>) -> Motion {
        let odometry = Odometry {
            v_mps: seen.odometry.v_mps * (1.0 + self.state[4]),
            omega_radps: seen.odometry.omega_radps + self.state[3],
        };
        Motion::new(odometry, seen.signal)
    }

    /// Covariance of the pose.
    pub fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into_owned()
    }

    /// Moves the robot by its wheels for `duration_s`, along the heading in the middle of the step (eq. (8) with the
    /// wheels' errors as states).
    pub fn predict(&mut self, odometry: Odometry, duration_s: f64, noise: &Noise) {
        let v_mps = odometry.v_mps * (1.0 + self.state[4]);
        let omega_radps = odometry.omega_radps + self.state[3];
        let (way_m, turn_rad) = (v_mps * duration_s, omega_radps * duration_s);
        let (sine, cosine) = (self.state[2] + 0.5 * turn_rad).sin_cos();
        self.state[0] += way_m * cosine;
        self.state[1] += way_m * sine;
        self.state[2] = wrap_angle(self.state[2] + turn_rad);
        let mut by_state = Covariance::identity();
        by_state[(0, 2)] = -way_m * sine;
        by_state[(1, 2)] = way_m * cosine;
        by_state[(0, 3)] = -0.5 * way_m * sine * duration_s;
        by_state[(1, 3)] = 0.5 * way_m * cosine * duration_s;
        by_state[(2, 3)] = duration_s;
        by_state[(0, 4)] = odometry.v_mps * duration_s * cosine;
        by_state[(1, 4)] = odometry.v_mps * duration_s * sine;
        self.covariance = by_state * self.covariance * by_state.transpose();
        let along = Vector6::new(cosine, sine, 0.0, 0.0, 0.0, 0.0) * noise.way_m;
        let turn = Vector6::new(
            -0.5 * way_m * sine,
            0.5 * way_m * cosine,
            1.0,
            0.0,
            0.0,
            0.0,
        ) * noise.turn_rad;
        self.covariance += (along * along.transpose() + turn * turn.transpose()) * duration_s;
        self.covariance[(3, 3)] += noise.turn_rate_drift_radps.powi(2) * duration_s;
        self.covariance[(4, 4)] += noise.speed_drift.powi(2) * duration_s;
    }

    /// Takes in the peaks of a block; the weight changes by the block's likelihood.
    pub fn update(&mut self, seen: &Seen<'_>, map: &LandmarkMap, noise: &Noise) -> Fit {
        let prior = (self.state, self.covariance);
        let Some(prior_information) = prior.1.cholesky().map(|root| root.inverse()) else {
            return Fit::default();
        };
        let mut fit = Fit::default();
        // A guess is blurred by more than what a step is not linear in.
        let rounds = if self.is_settled() { ROUNDS } else { 1 };
        for round in 0..rounds {
            let mut matches = [Match::default(); MOST_PEAKS];
            let (count, here) = self.associate(seen, map, noise, &mut matches);
            if round == 0 {
                fit = here;
            }
            let mut information = prior_information;
            let mut difference = self.state - prior.0;
            difference[2] = wrap_angle(difference[2]);
            let mut pull = -(prior_information * difference);
            for found in &matches[..count] {
                let weight = (TAILS + 2.0) / (TAILS + found.squares()) / noise.alike_blocks;
                for k in 0..2 {
                    let (by_state, weight) = (found.by_state[k], weight * found.weights[k]);
                    information += by_state.transpose() * by_state * weight;
                    pull += by_state.transpose() * (weight * found.residuals[k]);
                }
            }
            let Some(root) = information.cholesky() else {
                break;
            };
            self.state += root.solve(&pull);
            self.state[2] = wrap_angle(self.state[2]);
            self.covariance = root.inverse();
        }
        if !self.state.iter().all(|number| number.is_finite()) {
            (self.state, self.covariance) = prior;
            return Fit::default();
        }
        self.blur_m *= BLUR_KEPT;
        self.log_weight += fit.log_likelihood / (WEIGHT_BLOCKS * noise.alike_blocks);
        fit
    }

    /// Whether the ranges are no longer blurred.
    pub(super) fn is_settled(&self) -> bool {
        self.blur_m < SETTLED_M
    }

    /// Finds the landmark of each peak; returns how many were found, and how well the block fits.
    fn associate(
        &self,
        seen: &Seen<'_>,
        map: &LandmarkMap,
        noise: &Noise,
        matches: &mut [Match; MOST_PEAKS],
    ) -> (usize, Fit) {
        let (pose, motion) = (self.pose(), self.motion(seen));
        let mut fit = Fit::default();
        let mut count = 0;
        let mut taken = [false; MOST_PEAKS];
        for entry in &map.landmarks {
            let visible = entry.visibility.probability(entry.shape.aspect(&pose));
            if visible < LEAST_VISIBLE {
                continue;
            }
            let echo = entry.shape.echo(&pose, &motion);
            if echo.range_m <= 0.0 {
                continue;
            }
            let expected = Expected::new(self, entry, &echo, seen, noise);
            let mut best: Option<(usize, f64)> = None;
            for (number, peak) in seen.peaks.iter().enumerate().take(MOST_PEAKS) {
                if taken[number] {
                    continue;
                }
                let squares = expected.distance(expected.residuals(peak));
                if squares < GATE && best.is_none_or(|(_, least)| squares < least) {
                    best = Some((number, squares));
                }
            }
            fit.expected += visible;
            // What is missed counts less than what is found: echoes hide each other.
            let Some((number, squares)) = best else {
                fit.log_likelihood += (1.0 - 0.9 * visible).ln();
                continue;
            };
            taken[number] = true;
            fit.found += visible;
            let ratio = visible * expected.density() * (-0.5 * squares).exp() / CLUTTER;
            fit.log_likelihood += (0.1 + ratio).ln().max(-2.0);
            if count < matches.len() {
                let residuals = expected.residuals(&seen.peaks[number]);
                let probability = ratio / (1.0 - visible + ratio);
                matches[count] = Match {
                    residuals,
                    variances: expected.variances,
                    weights: [
                        expected.information(residuals[0], probability),
                        probability / expected.variances[1],
                    ],
                    by_state: expected.by_state,
                };
                count += 1;
            }
        }
        (count, fit)
    }
}
