//! Constants of the multipath study, and paths with their errors: shared by room and scene.

use anyhow::{Context, Result};
use localizer::pose::wrap_angle;
use localizer::{Recording, Trajectory};

use crate::data::table::{Table, cell};
use crate::metrics::{Accuracy, rounded};

/// Number of blocks from one estimate in the data file to the next.
const EVERY: usize = 2;
/// Errors of a trajectory at its own times.
pub(super) struct Errors {
    /// Distances from the true position, metres.
    pub(super) position_m: Vec<f64>,
    /// Differences from the true heading, radians.
    pub(super) heading_rad: Vec<f64>,
}

/// Compares a trajectory with the truth of its recording, the start left out.
pub(super) fn errors(trajectory: &Trajectory, recording: &Recording) -> Result<Errors> {
    let truth = recording
        .truth
        .as_ref()
        .context("recording: truth.tum: is missing")?;
    let mut errors = Errors {
        position_m: Vec::new(),
        heading_rad: Vec::new(),
    };
    for (t_s, pose) in trajectory.t_s.iter().zip(&trajectory.poses).skip(1) {
        let true_pose = truth
            .pose_at(*t_s)
            .context("recording: truth.tum: is empty")?;
        errors.position_m.push(rounded(pose.distance_m(&true_pose)));
        let turned = wrap_angle(pose.heading_rad - true_pose.heading_rad);
        errors.heading_rad.push(rounded(turned));
    }
    Ok(errors)
}

/// Accuracy over trials.
pub(super) fn accuracy(trials: &[Errors]) -> Accuracy {
    let pairs: Vec<(&[f64], &[f64])> = trials
        .iter()
        .map(|errors| (errors.position_m.as_slice(), errors.heading_rad.as_slice()))
        .collect();
    Accuracy::over(&pairs)
}

/// Adds rows of a trajectory: method, trial, time, position and error.
pub(super) fn write_path(
    table: &mut Table,
    method: &str,
    trial: u64,
    trajectory: &Trajectory,
    errors: &Errors,
) {
    let rows = trajectory.t_s.iter().zip(&trajectory.poses).skip(1);
    for ((t_s, pose), error_m) in rows.zip(&errors.position_m).step_by(EVERY) {
        table.push([
            method.to_string(),
            trial.to_string(),
            cell(*t_s, 3),
            cell(pose.x_m, 3),
            cell(pose.y_m, 3),
            cell(*error_m, 4),
        ]);
    }
}

/// Columns of the files of paths.
pub(super) const COLUMNS: [&str; 6] = ["method", "trial", "t_s", "x_m", "y_m", "error_m"];
