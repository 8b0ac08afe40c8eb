//! Errors of the libraries as Python's: their words stay.

use anyhow::Error;
use experiments::run::interrupt::Interrupted;
use experiments::run::one_line;
use pyo3::PyErr;
use pyo3::exceptions::{PyKeyboardInterrupt, PyOSError, PyValueError};

/// `KeyboardInterrupt` of an interruption, `OSError` (or the subclass of its number) of a file that cannot be read or
/// written, else `ValueError`.
pub(crate) fn raised(error: Error) -> PyErr {
    if error.chain().any(|cause| cause.is::<Interrupted>()) {
        return PyKeyboardInterrupt::new_err(());
    }
    let text = one_line(&error);
    let of_system = error.chain().find_map(|cause| {
        let cause = cause.downcast_ref::<std::io::Error>()?;
        Some(cause.raw_os_error())
    });
    match of_system {
        Some(Some(number)) => PyOSError::new_err((number, text)),
        Some(None) => PyOSError::new_err(text),
        None => PyValueError::new_err(text),
    }
}

/// As [`raised`], of any error of the libraries.
pub(crate) fn of_library(error: impl Into<Error>) -> PyErr {
    raised(error.into())
}
