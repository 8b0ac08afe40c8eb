//! A robot followed period by period.

use experiments::localization::{Stream, Told};
use experiments::mapping::Map;
use localizer::Odometry;
use numpy::{IntoPyArray, PyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{contiguous, of_pose, shape_error, slice};
use crate::error::of_library;
use crate::map::EchoMap;
use crate::parameters::Parameters;
use crate::start::{StartArgument, check_sigma, landmark_start, method_of};

/// The pose after one period of sound.
#[pyclass(frozen, module = "echolot")]
pub(crate) struct Estimate(Told);

#[pymethods]
impl Estimate {
    /// Instant of ``pose`` in seconds: the middle of the newest block of periods.
    #[getter]
    fn t(&self) -> f64 {
        self.0.t_s
    }

    /// x and y in metres and the heading in radians.
    #[getter]
    fn pose(&self) -> [f64; 3] {
        of_pose(&self.0.pose)
    }

    /// Covariance of x, y (m) and heading (rad), ``(3, 3)``.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        ndarray::arr2(&self.0.covariance).into_pyarray(py)
    }

    /// Instant of the newest sample in seconds.
    #[getter]
    fn latest_t(&self) -> f64 {
        self.0.latest_s
    }

    /// The pose carried to the newest sample by the wheels.
    #[getter]
    fn latest(&self) -> [f64; 3] {
        of_pose(&self.0.latest)
    }

    /// Among landmarks how far to trust it, ``"sure"``, ``"converging"`` or ``"lost"``; by images what it rests on,
    /// ``"echoes"``, ``"slow"`` (too slow for bearings) or ``"wheels"``.
    #[getter]
    fn status(&self) -> &'static str {
        self.0.status
    }

    /// Among landmarks the share of the expected echoes that were found lately; by images the effective share of the
    /// particles.
    #[getter]
    fn fit(&self) -> f64 {
        self.0.fit
    }

    fn __repr__(&self) -> String {
        let [x, y, heading] = of_pose(&self.0.pose);
        format!(
            "Estimate(t={:.3}, x={x:.4}, y={y:.4}, heading={heading:.4}, {:?})",
            self.0.t_s, self.0.status
        )
    }
}

/// Follows a robot in a known map, period by period.
///
/// ``Localizer(map, start=(x, y, heading), parameters=...)``: ``method`` is ``"doppler"``, ``"toa-only"`` or
/// ``"odometry"`` in a map of images, ``"landmarks"`` in one of landmarks, where ``start`` may be ``"unknown"``.
/// ``parameters`` are the map's unless given; those of another waveform, rate or air come from
/// ``Parameters.of_recording``.
#[pyclass(module = "echolot")]
pub(crate) struct Localizer {
    stream: Stream,
    parameters: localizer::Parameters,
}

#[pymethods]
impl Localizer {
    #[new]
    #[pyo3(signature = (map, *, start, method = None, start_sigma = None, parameters = None, seed = 0))]
    fn new(
        map: &EchoMap,
        start: StartArgument,
        method: Option<&str>,
        start_sigma: Option<[f64; 2]>,
        parameters: Option<&Parameters>,
        seed: u64,
    ) -> PyResult<Self> {
        check_sigma(start_sigma)?;
        let start = start.pose()?;
        let method = method_of(&map.map, method)?;
        let mut own = match (parameters, map.map.as_ref()) {
            (Some(given), _) => given.0.clone(),
            (None, Map::Images(map)) => map.parameters.clone(),
            (None, Map::Landmarks(map)) => map.parameters.clone(),
        };
        let stream = match map.map.as_ref() {
            Map::Landmarks(map) => {
                Stream::among_landmarks(&own, map.clone(), &landmark_start(start, start_sigma))
            }
            Map::Images(map) => {
                let Some(start) = start else {
                    return Err(PyValueError::new_err(
                        "start: 'unknown' needs a map of landmarks; give (x, y, heading)",
                    ));
                };
                own.filter.method = method.unwrap_or_default();
                if let Some([m, rad]) = start_sigma {
                    (own.filter.start_sigma_m, own.filter.start_sigma_rad) = (m, rad);
                }
                Stream::by_images(own.clone(), map.clone(), start, seed)
            }
        };
        Ok(Self {
            stream: stream.map_err(of_library)?,
            parameters: own,
        })
    }

    /// Takes in one period of samples and the mean speed (m/s) and turn rate (rad/s) during it.
    ///
    /// ``samples``: float32 ``(samples_per_period,)``. With ``heard=False`` they are a gap of the sound: the estimate
    /// follows from odometry alone until M whole periods have come in again. Returns ``None`` until M periods have
    /// come in and, from an unknown start, until the robot moves.
    #[pyo3(signature = (samples, v, omega, *, heard = true))]
    fn step(
        &mut self,
        py: Python<'_>,
        samples: &Bound<'_, PyAny>,
        v: f64,
        omega: f64,
        heard: bool,
    ) -> PyResult<Option<Estimate>> {
        let samples = contiguous::<f32>(samples, "samples")?;
        let samples = slice(&samples)?;
        let odometry = Odometry {
            v_mps: v,
            omega_radps: omega,
        };
        let stream = &mut self.stream;
        let told = py
            .detach(|| stream.step(samples, heard, odometry))
            .map_err(of_library)?;
        Ok(told.map(Estimate))
    }

    /// As ``step`` for many periods at a time: ``samples`` float32 ``(periods * samples_per_period,)``, ``odometry``
    /// ``(periods, 2)`` of speed and turn rate. Returns one item a period: an estimate or ``None``.
    fn run(
        &mut self,
        py: Python<'_>,
        samples: &Bound<'_, PyAny>,
        odometry: &Bound<'_, PyAny>,
    ) -> PyResult<Vec<Option<Estimate>>> {
        let samples = contiguous::<f32>(samples, "samples")?;
        let odometry = contiguous::<f64>(odometry, "odometry")?;
        let period = self.parameters.samples_per_period();
        let periods = samples.len() / period;
        if *odometry.shape() != [periods, 2] {
            let expected = format!("({periods}, 2): one row for each period of the samples");
            return Err(shape_error("odometry", odometry.shape(), &expected));
        }
        let (samples, odometry) = (slice(&samples)?, slice(&odometry)?);
        let mut estimates = Vec::with_capacity(periods);
        let pairs = samples.chunks_exact(period).zip(odometry.chunks_exact(2));
        for (samples, odometry) in pairs {
            py.check_signals()?;
            let odometry = Odometry {
                v_mps: odometry[0],
                omega_radps: odometry[1],
            };
            let stream = &mut self.stream;
            let told = py
                .detach(|| stream.step(samples, true, odometry))
                .map_err(of_library)?;
            estimates.push(told.map(Estimate));
        }
        Ok(estimates)
    }

    /// Samples of one period.
    #[getter]
    fn samples_per_period(&self) -> usize {
        self.parameters.samples_per_period()
    }

    /// Duration of one period in seconds.
    #[getter]
    fn period(&self) -> f64 {
        self.parameters.period_s()
    }
}
