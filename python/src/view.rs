//! NumPy arrays over memory of the libraries: what is large is not copied.
#![expect(
    unsafe_code,
    reason = "numpy offers no safe way to borrow memory of an object"
)]

use ndarray::{ArrayView, Dimension};
use numpy::{Element, PyArray, PyArrayMethods};
use pyo3::prelude::*;

/// A class whose instances never change, and so neither does memory that they own.
///
/// # Safety
/// No method may change, move or free memory that a view was made of while the instance lives.
pub(crate) unsafe trait Unchanging:
    pyo3::PyClass<Frozen = pyo3::pyclass::boolean_struct::True> + Sync
{
}

// SAFETY: recordings are behind an `Arc` that only frees them with the last instance, and no method has them mutable.
unsafe impl Unchanging for crate::recording::Recording {}
// SAFETY: as recordings.
unsafe impl Unchanging for crate::map::EchoMap {}

/// A read-only array over memory that `owner` owns, and that lives as long as the array.
pub(crate) fn of<'py, C: Unchanging, T: Element, D: Dimension>(
    owner: &Bound<'py, C>,
    memory: impl FnOnce(&C) -> ArrayView<'_, T, D>,
) -> PyResult<Bound<'py, PyAny>> {
    let view = memory(owner.get());
    // SAFETY: the memory belongs to `owner`, which the array keeps alive and which never changes.
    let array = unsafe { PyArray::borrow_from_array(&view, owner.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    Ok(array.into_any())
}
