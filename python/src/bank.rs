//! The Doppler bank.

use localizer::echo::doppler_bank::{DopplerBank as Bank, DopplerScratch};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{contiguous, shape_error, slice};
use crate::error::of_library;
use crate::parameters::Parameters;

/// Delay and direction of the echoes in a block of M periods, eqs. (1)-(3) of the paper of 2024.
///
/// ``DopplerBank(parameters)``.
#[pyclass(module = "echolot")]
pub(crate) struct DopplerBank {
    bank: Bank,
    scratch: DopplerScratch,
    parameters: localizer::Parameters,
}

#[pymethods]
impl DopplerBank {
    #[new]
    fn new(parameters: &Parameters) -> PyResult<Self> {
        let bank = Bank::new(&parameters.0).map_err(of_library)?;
        Ok(Self {
            scratch: bank.scratch(),
            bank,
            parameters: parameters.0.clone(),
        })
    }

    /// The envelope of every direction and delay, float32 ``(directions, delays)``; 1 for an echo of amplitude 1.
    ///
    /// ``block``: float32 ``(block_length,)``, M periods from the start of one on. ``v``: mean speed along the heading
    /// in m/s.
    fn measure<'py>(
        &mut self,
        py: Python<'py>,
        block: &Bound<'py, PyAny>,
        v: f64,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let block = contiguous::<f32>(block, "block")?;
        if *block.shape() != [self.bank.block_length()] {
            let expected = format!("({},)", self.bank.block_length());
            return Err(shape_error("block", block.shape(), &expected));
        }
        let fastest = 0.1 * self.parameters.signal.speed_of_sound_mps;
        if !v.is_finite() || v.abs() > fastest {
            return Err(PyValueError::new_err(format!(
                "v: {v} m/s cannot be used; give at most {fastest} m/s"
            )));
        }
        let samples = slice(&block)?;
        if let Some(place) = samples.iter().position(|sample| !sample.is_finite()) {
            return Err(PyValueError::new_err(format!(
                "block: sample {place} is not finite; give finite samples"
            )));
        }
        let (bank, scratch) = (&self.bank, &mut self.scratch);
        let intensity = py.detach(|| {
            let mut intensity = bank.intensity();
            bank.measure(samples, v, scratch, &mut intensity);
            intensity
        });
        Ok(intensity.into_pyarray(py))
    }

    /// Samples of a block.
    #[getter]
    fn block_length(&self) -> usize {
        self.bank.block_length()
    }

    /// Angle of each direction from the heading in radians, 0 to pi.
    #[getter]
    fn angles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let directions = self.parameters.measurement.directions;
        let angle = |n: usize| std::f64::consts::PI * n as f64 / directions as f64;
        (0..=directions)
            .map(angle)
            .collect::<Vec<f64>>()
            .into_pyarray(py)
    }

    /// Range of each delay in metres.
    #[getter]
    fn ranges<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let signal = &self.parameters.signal;
        (0..self.parameters.delays())
            .map(|delay| signal.range_of_delay_m(delay as f64))
            .collect::<Vec<f64>>()
            .into_pyarray(py)
    }

    /// What eq. (3) makes of a speed (m/s) in a direction: the sampling ratio that cancels the Doppler effect, less 1.
    fn excess(&self, v: f64, direction: usize) -> PyResult<f64> {
        let directions = self.parameters.measurement.directions;
        if direction > directions {
            return Err(PyValueError::new_err(format!(
                "direction: {direction}; give 0 to {directions}"
            )));
        }
        Ok(self.bank.excess(v, direction))
    }
}
