//! Parameters of the method.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::arrays::{json_text, to_python};
use crate::error::of_library;
use crate::recording::Recording;

/// Every choice of the method; those that are not given have the values of the paper's Table I.
///
/// ``Parameters(periods=4, particles=200)``; names and meanings are those of ``docs/reference/parameters.md``. What
/// belongs to the signal (``sample_rate_hz``, ``code_length``, ``speed_of_sound_mps``, ...) is taken from recordings
/// where there is one.
#[pyclass(frozen, module = "echolot")]
#[derive(Clone)]
pub(crate) struct Parameters(pub(crate) localizer::Parameters);

#[pymethods]
impl Parameters {
    #[new]
    #[pyo3(signature = (**choices))]
    fn new(choices: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let Some(choices) = choices else {
            return Ok(Self(localizer::Parameters::default()));
        };
        let text = json_text(choices)?;
        let parameters: localizer::Parameters = serde_json::from_str(&text)
            .map_err(|error| PyValueError::new_err(format!("parameters: {error}")))?;
        parameters.check().map_err(of_library)?;
        Ok(Self(parameters))
    }

    /// Those of a recording's waveform, rate, air and sensors; the others are those of ``base``.
    #[classmethod]
    #[pyo3(signature = (recording, base = None))]
    fn of_recording(_: &Bound<'_, PyType>, recording: &Recording, base: Option<&Self>) -> Self {
        let default = localizer::Parameters::default();
        let base = base.map_or(&default, |base| &base.0);
        Self(base.for_recording(&recording.recording.meta))
    }

    /// All of them by name.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0)
    }

    /// Samples of one period of the code.
    #[getter]
    fn samples_per_period(&self) -> usize {
        self.0.samples_per_period()
    }

    /// Duration of one period of the code in seconds.
    #[getter]
    fn period(&self) -> f64 {
        self.0.period_s()
    }

    fn __repr__(&self) -> PyResult<String> {
        let text = serde_json::to_string(&self.0).map_err(of_library)?;
        Ok(format!("Parameters({text})"))
    }
}
