//! The peaks of one block, and the pose and motion under which they were measured.

use super::landmark::Motion;
use super::peaks::{Peak, PeakFinder};
use crate::echo::EchoBlock;
use crate::parameters::Parameters;
use crate::pose::Pose;

/// The peaks of one block and the pose from which they were seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// The pose at the block's instant.
    pub pose: Pose,
    /// The robot's motion during the block.
    pub motion: Motion,
    /// Standard deviation of the peaks' cosines.
    pub cosine_sigma: f64,
    /// The peaks, strongest first.
    pub peaks: Vec<Peak>,
}

/// The standard deviation of a peak's cosine as a part of the Doppler resolution c/(2 f_c M T v).
const COSINE_SIGMA_WIDTHS: f64 = 0.3;

/// Standard deviation of the cosine of a peak at a speed.
pub fn cosine_sigma(parameters: &Parameters, v_mps: f64) -> f64 {
    let block_s = parameters.measurement.periods as f64 * parameters.period_s();
    let width = parameters.signal.speed_of_sound_mps
        / (2.0 * parameters.signal.carrier_hz * block_s * v_mps.abs().max(1e-6));
    (COSINE_SIGMA_WIDTHS * width).clamp(0.02, 1.0)
}

/// The peaks of a block, at a known pose; `finder` is that of its drive.
pub fn sighting(
    block: &EchoBlock,
    pose: Pose,
    parameters: &Parameters,
    finder: &mut PeakFinder,
) -> Sighting {
    let mut peaks = Vec::new();
    finder.find(block.intensity.view(), block.odometry.v_mps, &mut peaks);
    Sighting {
        pose,
        motion: Motion::new(block.odometry, &parameters.signal),
        cosine_sigma: cosine_sigma(parameters, block.odometry.v_mps),
        peaks,
    }
}
