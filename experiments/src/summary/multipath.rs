//! Numbers of the multipath study.

use serde::{Deserialize, Serialize};

use crate::metrics::Accuracy;

/// Positions from multipath arrival times (Tsuchiya et al., 2021).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Multipath {
    /// Model (a): single reflections.
    pub single: FollowedPath,
    /// Model (b): single and double reflections in the plane.
    pub planar: FollowedPath,
    /// Model (c): with ceiling and floor.
    pub spatial: FollowedPath,
    /// Wheel odometry alone.
    pub odometry: FollowedPath,
    /// Mean errors over the width of the gate.
    pub gates: Vec<MultipathGate>,
    /// On the localization drive of the studies' scene.
    pub scene: MultipathScene,
}

/// Accuracy of a followed drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FollowedPath {
    /// Mean over the trials of the error at the end of the drive, metres.
    pub final_m: f64,
    /// Accuracy over the whole drive.
    #[serde(flatten)]
    pub accuracy: Accuracy,
}

/// Two methods on one recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultipathScene {
    /// Model (b) with the scene's finite walls.
    pub planar: Accuracy,
    /// The Doppler method's particle filter.
    pub doppler: Accuracy,
    /// Wheel odometry alone.
    pub odometry: Accuracy,
}

/// Mean errors of the three models at one gate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultipathGate {
    /// Largest difference of round trips that is associated, metres.
    pub gate_m: f64,
    /// Model (a), metres.
    pub single_m: f64,
    /// Model (b), metres.
    pub planar_m: f64,
    /// Model (c), metres.
    pub spatial_m: f64,
}
