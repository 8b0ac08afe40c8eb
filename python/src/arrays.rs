//! From what Python calls an array to slices, and back.

use localizer::Pose;
use ndarray::Array2;
use numpy::{Element, IntoPyArray, PyArray2, PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;

/// Element types by their name in NumPy.
pub(crate) trait Named: Element {
    const NAME: &'static str;
}

impl Named for f32 {
    const NAME: &'static str = "float32";
}

impl Named for f64 {
    const NAME: &'static str = "float64";
}

/// Anything that NumPy takes for an array, contiguous and of this element type; what already is so is not copied.
pub(crate) fn contiguous<'py, T: Named>(
    given: &Bound<'py, PyAny>,
    name: &str,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let py = given.py();
    let options = [("dtype", T::NAME)].into_py_dict(py)?;
    let array = py
        .import("numpy")?
        .call_method("ascontiguousarray", (given,), Some(&options))
        .map_err(|error| {
            PyValueError::new_err(format!(
                "{name}: is no array of numbers: {}",
                error.value(py)
            ))
        })?;
    let array = array
        .cast_into::<PyArrayDyn<T>>()
        .map_err(|error| PyValueError::new_err(format!("{name}: {error}")))?;
    Ok(numpy::PyArrayMethods::readonly(&array))
}

/// The numbers of a contiguous array.
pub(crate) fn slice<'a, T: Element>(array: &'a PyReadonlyArrayDyn<'_, T>) -> PyResult<&'a [T]> {
    array
        .as_slice()
        .map_err(|error| PyValueError::new_err(error.to_string()))
}

/// Refuses an array of another shape; `expected` says which one is taken, as in `(n, 3)`.
pub(crate) fn shape_error(name: &str, shape: &[usize], expected: &str) -> PyErr {
    PyValueError::new_err(format!("{name}: has shape {shape:?}; give {expected}"))
}

/// Poses as an array `[n, 3]` of x and y in metres and the heading in radians.
pub(crate) fn of_poses<'py>(
    py: Python<'py>,
    poses: impl ExactSizeIterator<Item = Pose>,
) -> Bound<'py, PyArray2<f64>> {
    let count = poses.len();
    let numbers: Vec<f64> = poses
        .flat_map(|pose| [pose.x_m, pose.y_m, pose.heading_rad])
        .collect();
    Array2::from_shape_vec((count, 3), numbers)
        .unwrap_or_default()
        .into_pyarray(py)
}

/// A pose from three numbers.
pub(crate) fn pose([x_m, y_m, heading_rad]: [f64; 3]) -> Pose {
    Pose {
        x_m,
        y_m,
        heading_rad,
    }
}

/// Three numbers of a pose.
pub(crate) fn of_pose(pose: &Pose) -> [f64; 3] {
    [pose.x_m, pose.y_m, pose.heading_rad]
}

/// A value as Python's dictionaries, lists and numbers.
pub(crate) fn to_python<'py>(
    py: Python<'py>,
    value: &impl serde::Serialize,
) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(crate::error::of_library)?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Python's dictionaries, lists and numbers as JSON.
pub(crate) fn json_text(value: &Bound<'_, PyAny>) -> PyResult<String> {
    let py = value.py();
    let options = [("allow_nan", false)].into_py_dict(py)?;
    py.import("json")?
        .call_method("dumps", (value,), Some(&options))?
        .extract()
}
