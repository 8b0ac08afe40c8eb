//! A trial and its result.

use anyhow::{Context, Result};
use fdtd::scheme::Scheme;
use localizer::pose::wrap_angle;
use localizer::{Parameters, Pose, Recording, landmarks, random};
use serde::{Deserialize, Serialize};

use crate::ape_rpe;
use crate::metrics::{Accuracy, mean, rounded};
use crate::recordings::noise::Noise;

/// Error in metres from which on an estimate that says `sure` is wrong.
const WRONG_M: f64 = 0.1;

/// What a trial finds poses by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Approach {
    /// Echo images in a map image, or wheels alone: the method is that of the filter's parameters.
    #[default]
    Images,
    /// Peaks among the landmarks learnt from the mapping drive.
    Landmarks,
    /// Drive and landmarks together, without map.
    Slam,
    /// Arrival times at given walls, Tsuchiya et al. (2021).
    Arrivals,
}

/// One run of a method over a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Scheme of the field; the scene's when `None`.
    pub scheme: Option<Scheme>,
    /// What poses are found by.
    pub approach: Approach,
    /// Parameters of the localizer.
    pub parameters: Parameters,
    /// Number of the filter's random stream. The same in every cell, so that cells differ by nothing else.
    pub trial: u64,
    /// Noise on the received signal.
    pub noise: Option<Noise>,
    /// Whether the mapping drive has noise of the same level too.
    pub noisy_mapping: bool,
}

impl Trial {
    /// A trial of the filter without noise, with the scene's scheme.
    pub fn new(parameters: Parameters, trial: u64) -> Self {
        Self {
            scheme: None,
            approach: Approach::default(),
            parameters,
            trial,
            noise: None,
            noisy_mapping: false,
        }
    }

    /// Seed of the filter's random stream.
    pub(super) fn seed(&self) -> u64 {
        random::trial_seed("filter", "", self.trial)
    }
}

/// Estimates of a trial and their errors, one entry per block.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TrialResult {
    /// Times of the estimates, seconds.
    pub t_s: Vec<f64>,
    /// Estimated position, metres.
    pub x_m: Vec<f64>,
    /// Estimated position, metres.
    pub y_m: Vec<f64>,
    /// Estimated heading, radians.
    pub heading_rad: Vec<f64>,
    /// Distance from the true position, metres.
    pub error_m: Vec<f64>,
    /// Difference from the true heading, radians.
    pub heading_error_rad: Vec<f64>,
    /// Mean distance of the pose at the newest sample from the true one, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latest_mae_m: Option<f64>,
    /// Share of the estimates that say they are sure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sure: Option<f64>,
    /// Share of the estimates that say they are sure and are off by more than 0.1 m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sure_and_wrong: Option<f64>,
    /// Mean squared error of the position over its covariance, by two degrees of freedom.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nees: Option<f64>,
    /// Root mean square of the distance after the best rigid motion, metres: `evo_ape --align`.
    #[serde(default)]
    pub aligned_rmse_m: f64,
    /// Root mean square error of the way from one estimate to the next, metres: `evo_rpe`.
    #[serde(default)]
    pub rpe_m: f64,
    /// The reason why there are no estimates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

/// An estimate of any method.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    t_s: f64,
    pose: Pose,
    latest: Option<(f64, Pose)>,
    covariance: Option<[[f64; 3]; 3]>,
    sure: Option<bool>,
}

impl From<&localizer::Estimate> for Found {
    fn from(estimate: &localizer::Estimate) -> Self {
        Self {
            covariance: Some(estimate.covariance),
            ..Self::at(estimate.t_s, estimate.pose)
        }
    }
}

impl From<&landmarks::Estimate> for Found {
    fn from(estimate: &landmarks::Estimate) -> Self {
        Self {
            latest: Some((estimate.latest_s, estimate.latest)),
            covariance: Some(estimate.covariance),
            sure: Some(estimate.status == landmarks::Status::Sure),
            ..Self::at(estimate.t_s, estimate.pose)
        }
    }
}

impl Found {
    /// A pose of which nothing else is known.
    pub(super) fn at(t_s: f64, pose: Pose) -> Self {
        Self {
            t_s,
            pose,
            latest: None,
            covariance: None,
            sure: None,
        }
    }

    /// Squared error of the position over its covariance, by two degrees of freedom; `None` where it has none.
    fn nees(&self, truth: &Pose) -> Option<f64> {
        let [[xx, xy, _], [_, yy, _], _] = self.covariance?;
        let determinant = xx * yy - xy * xy;
        let (x, y) = (self.pose.x_m - truth.x_m, self.pose.y_m - truth.y_m);
        let squared = (yy * x * x - 2.0 * xy * x * y + xx * y * y) / determinant;
        (determinant > 0.0 && squared.is_finite()).then_some(0.5 * squared)
    }
}

impl TrialResult {
    /// Estimates of a method beside the truth of their recording.
    ///
    /// # Errors
    /// When the recording has no truth.
    pub(super) fn of(recording: &Recording, estimates: &[Found]) -> Result<Self> {
        let truth = recording
            .truth
            .as_ref()
            .context("recording: truth.tum: is missing")?;
        let true_pose = |t_s: f64| truth.pose_at(t_s).context("recording: truth.tum: is empty");
        let mut result = Self::default();
        let (mut true_poses, mut latest, mut nees) = (Vec::new(), Vec::new(), Vec::new());
        let mut wrong = 0;
        for found in estimates {
            let pose = found.pose;
            let truth = true_pose(found.t_s)?;
            let error_m = rounded(pose.distance_m(&truth));
            result.t_s.push(rounded(found.t_s));
            result.x_m.push(rounded(pose.x_m));
            result.y_m.push(rounded(pose.y_m));
            result.heading_rad.push(rounded(pose.heading_rad));
            result.error_m.push(error_m);
            result
                .heading_error_rad
                .push(rounded(wrap_angle(pose.heading_rad - truth.heading_rad)));
            if let Some((t_s, pose)) = found.latest {
                latest.push(pose.distance_m(&true_pose(t_s)?));
            }
            nees.extend(found.nees(&truth));
            wrong += usize::from(found.sure == Some(true) && error_m > WRONG_M);
            true_poses.push(truth);
        }
        if estimates.is_empty() {
            result.failure = Some("the method gave no pose".to_string());
            return Ok(result);
        }
        let share = |count: usize| rounded(count as f64 / estimates.len() as f64);
        let poses: Vec<Pose> = estimates.iter().map(|found| found.pose).collect();
        let told: Vec<bool> = estimates.iter().filter_map(|found| found.sure).collect();
        result.latest_mae_m = (!latest.is_empty()).then(|| rounded(mean(&latest)));
        result.nees = (!nees.is_empty()).then(|| rounded(mean(&nees)));
        if !told.is_empty() {
            result.sure = Some(share(told.iter().filter(|sure| **sure).count()));
            result.sure_and_wrong = Some(share(wrong));
        }
        result.aligned_rmse_m = rounded(ape_rpe::aligned_rmse_m(&poses, &true_poses));
        result.rpe_m = rounded(ape_rpe::relative_rmse_m(&poses, &true_poses));
        Ok(result)
    }

    /// The result of a method that gave no estimates.
    pub(super) fn failed(reason: String) -> Self {
        Self {
            failure: Some(reason),
            ..Self::default()
        }
    }

    /// Mean distance from the true position, metres.
    pub fn mae_m(&self) -> f64 {
        mean(&self.error_m)
    }
}

/// Accuracy over trials.
pub fn accuracy(results: &[TrialResult]) -> Accuracy {
    let errors: Vec<(&[f64], &[f64])> = results
        .iter()
        .map(|result| {
            (
                result.error_m.as_slice(),
                result.heading_error_rad.as_slice(),
            )
        })
        .collect();
    Accuracy::over(&errors)
}
