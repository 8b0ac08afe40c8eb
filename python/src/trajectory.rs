//! Poses over time.

use std::path::PathBuf;

use experiments::data::estimate;
use experiments::data::place::Place;
use localizer::Trajectory as Track;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::arrays::{contiguous, of_pose, of_poses, pose, shape_error, slice};
use crate::error::{of_library, raised};

/// Poses at increasing times.
///
/// ``Trajectory(t, poses)``: times ``(n,)`` in seconds, poses ``(n, 3)``: x and y in metres, heading in radians.
#[pyclass(frozen, module = "echolot")]
pub(crate) struct Trajectory(pub(crate) Track);

#[pymethods]
impl Trajectory {
    #[new]
    fn new(t: &Bound<'_, PyAny>, poses: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (t, poses) = (
            contiguous::<f64>(t, "t")?,
            contiguous::<f64>(poses, "poses")?,
        );
        let (times, numbers) = (slice(&t)?, slice(&poses)?);
        let shape = poses.shape().to_vec();
        if shape != [times.len(), 3] {
            return Err(shape_error(
                "poses",
                &shape,
                "(n, 3): x, y, heading for each time",
            ));
        }
        let finite = times.iter().chain(numbers).all(|number| number.is_finite());
        if !finite || times.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err(PyValueError::new_err(
                "t, poses: are not finite, or times do not increase; give finite numbers in the order of time",
            ));
        }
        Ok(Self(Track {
            t_s: times.to_vec(),
            poses: numbers
                .chunks_exact(3)
                .map(|three| pose([three[0], three[1], three[2]]))
                .collect(),
        }))
    }

    /// Reads a TUM file (``t x y z qx qy qz qw``), as evo and ROS tools write it.
    #[classmethod]
    fn load(_: &Bound<'_, PyType>, file: PathBuf) -> PyResult<Self> {
        Ok(Self(Track::read_tum(&file).map_err(of_library)?))
    }

    /// Writes a TUM file, the bytes of ``echolot localize -o``. A file that this program did not write is replaced
    /// with ``force`` alone.
    #[pyo3(signature = (file, *, force = false))]
    fn save(&self, file: PathBuf, force: bool) -> PyResult<()> {
        Place::of(&file, force)
            .file(estimate::is_ours)
            .and_then(|()| estimate::write(&file, &self.0))
            .map_err(raised)
    }

    /// Times in seconds, ``(n,)``.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.t_s.clone().into_pyarray(py)
    }

    /// x and y in metres and the heading in radians, ``(n, 3)``.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        of_poses(py, self.0.poses.iter().copied())
    }

    /// The pose at a time in seconds, between two poses interpolated; ``None`` where the trajectory does not cover it.
    fn at(&self, t: f64) -> Option<[f64; 3]> {
        self.0.covered_pose_at(t).map(|pose| of_pose(&pose))
    }

    fn __len__(&self) -> usize {
        self.0.len()
    }

    fn __repr__(&self) -> String {
        match (self.0.t_s.first(), self.0.t_s.last()) {
            (Some(first), Some(last)) => {
                format!(
                    "Trajectory({} poses, {first:.3} to {last:.3} s)",
                    self.0.len()
                )
            }
            _ => "Trajectory(0 poses)".into(),
        }
    }
}
