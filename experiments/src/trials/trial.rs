//! A trial and its result.

use anyhow::{Context, Result};
use fdtd::scheme::Scheme;
use localizer::pose::wrap_angle;
use localizer::{Estimate, Parameters, Recording, random};
use serde::{Deserialize, Serialize};

use crate::metrics::{Accuracy, mean, rounded};
use crate::recordings::noise::Noise;

/// One run of the filter.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Scheme of the field; the scene's when `None`.
    pub scheme: Option<Scheme>,
    /// Parameters of the localizer.
    pub parameters: Parameters,
    /// Number of the filter's random stream. The same in every cell, so that cells differ by nothing else.
    pub trial: u64,
    /// Noise on the received signal.
    pub noise: Option<Noise>,
}

impl Trial {
    /// Seed of the filter's random stream.
    pub(super) fn seed(&self) -> u64 {
        random::trial_seed("filter", "", self.trial)
    }
}

/// Estimates of a trial and their errors, one entry per block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
}

impl TrialResult {
    /// Estimates of a filter beside the truth of their recording.
    ///
    /// # Errors
    /// When the recording has no truth.
    pub(super) fn of(recording: &Recording, estimates: &[Estimate]) -> Result<Self> {
        let truth = recording
            .truth
            .as_ref()
            .context("recording: truth.tum: is missing")?;
        let mut result = Self {
            t_s: Vec::new(),
            x_m: Vec::new(),
            y_m: Vec::new(),
            heading_rad: Vec::new(),
            error_m: Vec::new(),
            heading_error_rad: Vec::new(),
        };
        for estimate in estimates {
            let pose = estimate.pose;
            let true_pose = truth
                .pose_at(estimate.t_s)
                .context("recording: truth.tum: is empty")?;
            result.t_s.push(rounded(estimate.t_s));
            result.x_m.push(rounded(pose.x_m));
            result.y_m.push(rounded(pose.y_m));
            result.heading_rad.push(rounded(pose.heading_rad));
            result.error_m.push(rounded(pose.distance_m(&true_pose)));
            result.heading_error_rad.push(rounded(wrap_angle(
                pose.heading_rad - true_pose.heading_rad,
            )));
        }
        Ok(result)
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
