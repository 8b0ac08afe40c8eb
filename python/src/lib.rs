//! The compiled part of the Python package `echolot`: classes and functions over the libraries, with their words and
//! their bytes.
//!
//! What Python sees is described in `lib/echolot/_echolot.pyi`; what takes long runs in [`background`], what is large
//! is lent by [`view`].
#![deny(unsafe_code)]

mod arrays;
mod background;
mod bank;
mod error;
mod field;
mod localization;
mod map;
mod metrics;
mod parameters;
mod recording;
mod scene;
mod simulate;
mod start;
mod stream;
mod study;
mod trajectory;
mod view;

use pyo3::prelude::*;

/// Compiled part of the package ``echolot``; use that.
#[pymodule]
fn _echolot(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<bank::DopplerBank>()?;
    module.add_class::<stream::Estimate>()?;
    module.add_class::<localization::Localization>()?;
    module.add_class::<stream::Localizer>()?;
    module.add_class::<map::EchoMap>()?;
    module.add_class::<parameters::Parameters>()?;
    module.add_class::<recording::Recording>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<study::Study>()?;
    module.add_class::<field::Field>()?;
    module.add_class::<trajectory::Trajectory>()?;
    module.add_function(wrap_pyfunction!(metrics::associated, module)?)?;
    module.add_function(wrap_pyfunction!(metrics::errors, module)?)?;
    module.add_function(wrap_pyfunction!(localization::localize, module)?)?;
    module.add_function(wrap_pyfunction!(localization::slam, module)?)?;
    module.add_function(wrap_pyfunction!(simulate::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(simulate::transmit, module)?)?;
    Ok(())
}
