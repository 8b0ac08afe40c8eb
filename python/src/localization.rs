//! The poses of a whole drive, in a known map or without one.

use std::path::PathBuf;
use std::sync::Arc;

use experiments::data::estimate;
use experiments::data::place::Place;
use experiments::drive::Drive;
use experiments::localization::{self, Told};
use experiments::mapping::Map;
use experiments::scores::Scores;
use experiments::trust::{Warnings, changed, contradictions};
use localizer::landmarks;
use localizer::{Pose, Trajectory as Track};
use ndarray::Array3;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{of_poses, to_python};
use crate::background;
use crate::error::raised;
use crate::map::{EchoMap, warn};
use crate::parameters::Parameters;
use crate::recording::Recording;
use crate::start::{StartArgument, check_sigma, landmark_start, method_of};
use crate::trajectory::Trajectory;

/// The poses of a whole drive.
#[pyclass(frozen, module = "echolot")]
pub(crate) struct Localization {
    told: Vec<Told>,
    /// Whether each is to be trusted.
    sure: Vec<bool>,
    fit: Vec<f64>,
    scores: Option<Scores>,
    coverage: Option<f64>,
    reading_s: f64,
    map: Option<Arc<Map>>,
    wheel_errors: Option<[f64; 2]>,
}

impl Localization {
    fn of(recording: &Recording, told: Vec<Told>, sure: Vec<bool>, fit: Vec<f64>) -> Self {
        let poses: Vec<(f64, Pose)> = told.iter().map(|told| (told.t_s, told.pose)).collect();
        let truth = recording.recording.truth.as_ref();
        let found = truth.map(|truth| Scores::of(&poses, truth));
        Self {
            told,
            sure,
            fit,
            coverage: found.as_ref().map(|(_, coverage)| *coverage),
            scores: found.and_then(|(scores, _)| scores),
            reading_s: recording.reading_s,
            map: None,
            wheel_errors: None,
        }
    }

    fn track(&self, clock_s: f64) -> Track {
        Track {
            t_s: self.told.iter().map(|told| told.t_s + clock_s).collect(),
            poses: self.told.iter().map(|told| told.pose).collect(),
        }
    }
}

#[pymethods]
impl Localization {
    /// Instants of the poses in seconds since the first sample, ``(n,)``.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let times: Vec<f64> = self.told.iter().map(|told| told.t_s).collect();
        times.into_pyarray(py)
    }

    /// x and y in metres and the heading in radians, ``(n, 3)``.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        of_poses(py, self.told.iter().map(|told| told.pose))
    }

    /// Covariance of x, y and heading, ``(n, 3, 3)``.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f64>> {
        let numbers = self.told.iter().flat_map(|told| told.covariance);
        let numbers: Vec<f64> = numbers.flatten().collect();
        Array3::from_shape_vec((self.told.len(), 3, 3), numbers)
            .unwrap_or_default()
            .into_pyarray(py)
    }

    /// The poses carried by the wheels to the newest sample of each block, and these instants.
    #[getter]
    fn latest<'py>(
        &self,
        py: Python<'py>,
    ) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>) {
        let times: Vec<f64> = self.told.iter().map(|told| told.latest_s).collect();
        let poses = of_poses(py, self.told.iter().map(|told| told.latest));
        (times.into_pyarray(py), poses)
    }

    /// What each pose rests on, or how far to trust it: see ``Estimate.status``.
    #[getter]
    fn status(&self) -> Vec<&'static str> {
        self.told.iter().map(|told| told.status).collect()
    }

    /// Whether each pose can be relied on, ``(n,)`` of bool.
    #[getter]
    fn sure<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.sure.clone().into_pyarray(py)
    }

    /// How well the echoes fit the map, ``(n,)``: by images in standard deviations over poses around, among landmarks
    /// the share of the expected echoes that were found.
    #[getter]
    fn fit<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.fit.clone().into_pyarray(py)
    }

    /// Errors against the recording's truth: ``mae_m``, ``interpolated_mae_m``, ``rmse_m``, ``p90_m``, ``max_m``,
    /// ``final_m``, ``heading_mae_rad``; ``None`` without truth.
    #[getter]
    fn scores<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.scores
            .as_ref()
            .map(|scores| to_python(py, scores))
            .transpose()
    }

    /// Share of the poses that the truth covers; ``None`` without truth.
    #[getter]
    fn coverage(&self) -> Option<f64> {
        self.coverage
    }

    /// The poses as a trajectory on the recording's own clock.
    #[getter]
    fn trajectory(&self) -> Trajectory {
        Trajectory(self.track(0.0))
    }

    /// The map that ``slam`` made, in the frame of the start; ``None`` of ``localize``, or where no landmark was found.
    #[getter]
    fn map(&self) -> Option<EchoMap> {
        self.map.as_ref().map(|map| EchoMap {
            map: Arc::clone(map),
        })
    }

    /// What the wheels' turn rate (rad/s) and speed (part of it) always lack, by ``slam``.
    #[getter]
    fn wheel_errors(&self) -> Option<[f64; 2]> {
        self.wheel_errors
    }

    /// Writes the trajectory (TUM), the bytes of ``echolot localize -o``: on the clock of the recording's truth, else
    /// of its wheels.
    #[pyo3(signature = (file, *, force = false))]
    fn save(&self, file: PathBuf, force: bool) -> PyResult<()> {
        Place::of(&file, force)
            .file(estimate::is_ours)
            .and_then(|()| estimate::write(&file, &self.track(self.reading_s)))
            .map_err(raised)
    }

    /// Draws path and truth over the map; needs matplotlib. Returns the axes.
    #[pyo3(signature = (map = None, truth = None, ax = None))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        map: Option<Bound<'py, EchoMap>>,
        truth: Option<Bound<'py, Trajectory>>,
        ax: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let draw = slf.py().import("echolot._plot")?.getattr("localization")?;
        draw.call1((slf, map, truth, ax))
    }

    fn __len__(&self) -> usize {
        self.told.len()
    }

    fn __repr__(&self) -> String {
        let sure = self.sure.iter().filter(|&&sure| sure).count() as f64;
        let share = 100.0 * sure / self.sure.len().max(1) as f64;
        let error = self.scores.as_ref().map_or(String::new(), |scores| {
            format!(", mean error {:.4} m", scores.mae_m)
        });
        format!(
            "Localization({} poses, sure {share:.0} %{error})",
            self.told.len()
        )
    }
}

/// Localizes a whole drive, as ``echolot localize``.
///
/// ``start`` is ``(x, y, heading)``, ``"unknown"`` (landmarks only) or, unless given, the truth at time 0, the start
/// of ``recording.json``, or the origin. ``parameters`` are the map's unless given. Raises ``ValueError`` when the
/// recording holds no echoes; warns when what it says of itself is doubtful.
#[pyfunction]
#[pyo3(signature = (recording, map, *, method = None, start = None, start_sigma = None, parameters = None,
    periods = None, particles = None, window = None, seed = 0))]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn localize(
    py: Python<'_>,
    recording: &Recording,
    map: &EchoMap,
    method: Option<&str>,
    start: Option<StartArgument>,
    start_sigma: Option<[f64; 2]>,
    parameters: Option<&Parameters>,
    periods: Option<usize>,
    particles: Option<usize>,
    window: Option<f64>,
    seed: u64,
) -> PyResult<Localization> {
    check_sigma(start_sigma)?;
    let method = method_of(&map.map, method)?;
    let known = recording.recording.known_start();
    let start = match &start {
        Some(start) => start.pose()?,
        None => Some(known.unwrap_or_default()),
    };
    let base = parameters.map(|given| given.0.clone());
    let (own, shared, name) = (
        Arc::clone(&recording.recording),
        Arc::clone(&map.map),
        recording.name.clone(),
    );
    let mut warnings = Warnings::default();
    warnings.extend(changed(&name));
    if method.is_none() && (particles.is_some() || window.is_some()) {
        return Err(PyValueError::new_err(
            "particles, window: are for maps of images; leave them out",
        ));
    }
    if method.is_some() && start.is_none() {
        return Err(PyValueError::new_err(
            "start: 'unknown' needs a map of landmarks; give (x, y, heading)",
        ));
    }
    let (told, sure, fit, warnings) = background::run(py, None, move |_| {
        let drive = Drive::loaded(&own, &name);
        match shared.as_ref() {
            Map::Images(map) => {
                let mut parameters = localization::image_parameters(
                    base.as_ref(),
                    map,
                    &drive,
                    method.unwrap_or_default(),
                );
                let filter = &mut parameters.filter;
                filter.particles = particles.unwrap_or(filter.particles);
                filter.window_half_width_m = window.unwrap_or(filter.window_half_width_m);
                if let Some([m, rad]) = start_sigma {
                    (filter.start_sigma_m, filter.start_sigma_rad) = (m, rad);
                }
                let measurement = &mut parameters.measurement;
                measurement.periods = periods.unwrap_or(measurement.periods);
                parameters.check()?;
                warnings.extend(contradictions(&map.parameters, &parameters));
                let begin = (start.unwrap_or_default(), seed);
                let found = localization::by_images(
                    &drive,
                    map,
                    &parameters,
                    begin,
                    &mut warnings,
                    &mut |_, _| (),
                )?;
                let told = found.estimates.iter();
                Ok((
                    told.map(|one| Told::of_images(one, &parameters)).collect(),
                    found.fits.iter().map(|fit| fit.sure).collect(),
                    found.fits.iter().map(|fit| fit.fit).collect(),
                    warnings,
                ))
            }
            Map::Landmarks(map) => {
                let base = base.as_ref().unwrap_or(&map.parameters);
                let mut parameters = base.for_recording(drive.meta());
                let measurement = &mut parameters.measurement;
                measurement.periods = periods.unwrap_or(measurement.periods);
                parameters.check()?;
                let start = landmark_start(start, start_sigma);
                let found = localization::among_landmarks(
                    &drive,
                    map,
                    &parameters,
                    &start,
                    &mut warnings,
                    &mut |_, _| (),
                )?;
                Ok((
                    found.iter().map(Told::from).collect::<Vec<_>>(),
                    found
                        .iter()
                        .map(|one| one.status == landmarks::Status::Sure)
                        .collect::<Vec<_>>(),
                    found.iter().map(|one| one.fit).collect::<Vec<_>>(),
                    warnings,
                ))
            }
        }
    })?;
    warn(py, warnings)?;
    Ok(Localization::of(recording, told, sure, fit))
}

/// Estimates a drive and a map of landmarks at once, without map and truth, as ``echolot slam``.
///
/// The map's frame is that of the start: ``start``, the truth at time 0, the start of ``recording.json``, or the
/// origin. Truth serves nothing else but ``scores``. Poses that are not to be trusted are ``"lost"``.
#[pyfunction]
#[pyo3(signature = (recording, *, start, periods, parameters, progress))]
pub(crate) fn slam(
    py: Python<'_>,
    recording: &Recording,
    start: Option<[f64; 3]>,
    periods: Option<usize>,
    parameters: Option<&Parameters>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Localization> {
    let mut own = parameters.map_or_else(localizer::Parameters::default, |given| given.0.clone());
    if parameters.is_none() {
        own.measurement.periods = landmarks::PERIODS;
    }
    own.measurement.periods = periods.unwrap_or(own.measurement.periods);
    let own = own.for_recording(&recording.recording.meta);
    let start = match start {
        Some(numbers) => StartArgument::Pose(numbers).pose()?.unwrap_or_default(),
        None => recording.recording.start_pose(),
    };
    let (sound, name) = (Arc::clone(&recording.recording), recording.name.clone());
    let (drive, warnings) = background::run(py, progress, move |control| {
        let mut warnings = Warnings::default();
        let drive = Drive::loaded(&sound, &name);
        let mut each = |[done, all]: [u64; 2], _: &_, _: &_| {
            control.set(done, all);
            Ok(control.check()?)
        };
        let found = localization::without_map(&drive, &own, start, &mut warnings, &mut each)?;
        Ok((found, warnings))
    })?;
    warn(py, warnings)?;
    let estimates = &drive.estimates;
    let sure = estimates
        .iter()
        .map(|one| one.status == landmarks::Status::Sure);
    let found = Localization::of(
        recording,
        estimates.iter().map(Told::from).collect(),
        sure.collect(),
        estimates.iter().map(|one| one.fit).collect(),
    );
    Ok(Localization {
        map: drive.map.map(|map| Arc::new(Map::Landmarks(map))),
        wheel_errors: Some(drive.wheel_errors),
        ..found
    })
}
