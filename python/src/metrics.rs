//! Errors of trajectories.

use localizer::Pose;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::of_poses;
use crate::trajectory::Trajectory;

/// Pairs of estimated and true poses at the estimates' times.
fn pairs(estimate: &Trajectory, truth: &Trajectory) -> Vec<(Pose, Pose)> {
    let track = &estimate.0;
    let times = track.t_s.iter().copied();
    let poses: Vec<(f64, Pose)> = times.zip(track.poses.iter().copied()).collect();
    experiments::scores::associated(&poses, &truth.0)
}

/// Pairs of estimated and true poses at the estimates' times, each ``(n, 3)``.
#[pyfunction]
pub(crate) fn associated<'py>(
    py: Python<'py>,
    estimate: &Trajectory,
    truth: &Trajectory,
) -> (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>) {
    let pairs = pairs(estimate, truth);
    (
        of_poses(py, pairs.iter().map(|pair| pair.0)),
        of_poses(py, pairs.iter().map(|pair| pair.1)),
    )
}

/// Errors of pairs of poses in metres: distances, those after alignment, or of the ways from pose to pose.
#[pyfunction]
pub(crate) fn errors<'py>(
    py: Python<'py>,
    kind: &str,
    estimate: &Trajectory,
    truth: &Trajectory,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    use experiments::ape_rpe::{aligned_errors_m, relative_errors_m};
    let pairs = pairs(estimate, truth);
    if pairs.len() < 2 {
        return Err(PyValueError::new_err(format!(
            "truth: covers {} of {} poses; give trajectories on the same clock",
            pairs.len(),
            estimate.0.poses.len()
        )));
    }
    let (ours, theirs): (Vec<Pose>, Vec<Pose>) = pairs.into_iter().unzip();
    let errors = match kind {
        "aligned" => aligned_errors_m(&ours, &theirs),
        "relative" => relative_errors_m(&ours, &theirs),
        _ => ours
            .iter()
            .zip(&theirs)
            .map(|(a, b)| a.distance_m(b))
            .collect(),
    };
    Ok(errors.into_pyarray(py))
}
