//! Choices that the paper leaves open.

use serde::{Deserialize, Serialize};

/// How the pose is estimated.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Echo images resolved in range and bearing (the paper's method).
    #[default]
    Doppler,
    /// Echo images resolved in range only.
    ToaOnly,
    /// Wheel odometry alone.
    Odometry,
}

/// The instant of an M-period block to which its echo image and pose refer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TimeReference {
    /// The middle: the resampling leaves the delay that the echo has there.
    #[default]
    Centre,
    /// The first sample, as a plain copy of the block has it.
    Start,
}

/// Removal of the sound that reaches the microphone without a wall.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DirectWave {
    /// Nothing.
    Keep,
    /// Subtract the exponential average of the received periods; it also removes echoes whose delay does not change.
    #[default]
    RunningMean,
    /// Subtract only the part of that average whose delay lies below `min_range_m`.
    GatedMean,
    /// Subtract a recording of the same drive without walls.
    FreeField,
}

/// How the motion model integrates one step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Integration {
    /// Along the heading in the middle of the step.
    #[default]
    Midpoint,
    /// Along the heading at the start of the step, eq. (8) to the letter.
    Euler,
}

/// The intensity that stands for all directions in the range-only method.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToaImage {
    /// The mean over the directions.
    #[default]
    Mean,
    /// The strongest direction at every delay.
    Strongest,
}

/// How the next particles are drawn by their weights.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Resampling {
    /// By one comb over the cumulated weights, which adds the least chance.
    #[default]
    Systematic,
    /// Each by itself.
    Multinomial,
}
