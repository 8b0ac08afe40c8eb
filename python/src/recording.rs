//! Recordings.

use std::path::PathBuf;
use std::sync::Arc;

use experiments::data::place::Place;
use experiments::recordings::recording::write;
use experiments::recordings::robot::Robot;
use localizer::io::json;
use localizer::io::recording_source::{ReadOptions, RecordingSource};
use localizer::odometry::OdometrySample;
use localizer::recording::RecordingMeta;
use ndarray::{Array2, ArrayView1};
use numpy::{IntoPyArray, PyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::arrays::{contiguous, json_text, of_pose, shape_error, slice, to_python};
use crate::background;
use crate::error::{of_library, raised};
use crate::trajectory::Trajectory;
use crate::view;

/// Microphone signal, wheel odometry and, if known, true poses of one drive.
///
/// Time 0 is the first sample, which is also the first of a period of the loudspeaker's sound.
#[pyclass(frozen, module = "echolot")]
pub(crate) struct Recording {
    pub(crate) recording: Arc<localizer::Recording>,
    /// The folder it came from, or another name for errors.
    pub(crate) name: PathBuf,
    /// What the clock of its estimates shows at time 0 in seconds.
    pub(crate) reading_s: f64,
    /// The robot of a simulated drive, and the name of the drive: its sound card is put on when it is written.
    pub(crate) robot: Option<(Robot, String)>,
    /// How it was aligned.
    pub(crate) notes: Vec<String>,
}

impl Recording {
    /// A recording that was computed.
    pub(crate) fn of(recording: localizer::Recording, name: &str) -> Self {
        Self {
            recording: Arc::new(recording),
            name: PathBuf::from(name),
            reading_s: 0.0,
            robot: None,
            notes: Vec::new(),
        }
    }
}

#[pymethods]
impl Recording {
    /// Reads a recording folder (``docs/reference/recording.md``) and finds what its ``recording.json`` leaves out of
    /// rate, first period, drift and clocks; ``late`` is in seconds, ``drift`` in ppm. ``notes`` says what was found.
    #[classmethod]
    #[pyo3(signature = (folder, *, channel = None, late = None, drift = None, odometry_clock = None,
        truth_clock = None, transmitted = None))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn load(
        cls: &Bound<'_, PyType>,
        folder: PathBuf,
        channel: Option<usize>,
        late: Option<f64>,
        drift: Option<f64>,
        odometry_clock: Option<f64>,
        truth_clock: Option<f64>,
        transmitted: Option<PathBuf>,
    ) -> PyResult<Self> {
        let options = ReadOptions {
            channel,
            late_s: late,
            drift_ppm: drift,
            odometry_clock_s: odometry_clock,
            truth_clock_s: truth_clock,
            transmitted,
            aligned: false,
        };
        background::run(cls.py(), None, move |_| {
            let source = RecordingSource::open(&folder, &options)?;
            let reading_s = match (&source.truth, source.alignment.truth) {
                (Some(_), clock) => clock.map_or(0.0, |clock| clock.reading_s),
                (None, _) => source.alignment.odometry.reading_s,
            };
            let notes = source.alignment.told();
            Ok(Self {
                recording: Arc::new(source.load()?),
                name: folder,
                reading_s,
                robot: None,
                notes,
            })
        })
    }

    /// A recording from arrays: ``signal`` ``(n,)``, ``odometry`` ``(k, 3)`` of time (s), speed (m/s) and turn rate
    /// (rad/s), and ``meta``, the fields of ``recording.json``. The first sample must be the first of a period, and
    /// logs must be on the sound's clock; a folder with a WAV is aligned by ``load``.
    #[classmethod]
    #[pyo3(signature = (signal, odometry, meta, *, truth = None, direct = None))]
    fn from_arrays(
        _: &Bound<'_, PyType>,
        signal: &Bound<'_, PyAny>,
        odometry: &Bound<'_, PyAny>,
        meta: &Bound<'_, PyDict>,
        truth: Option<&Trajectory>,
        direct: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let samples = |given: &Bound<'_, PyAny>, name: &str| -> PyResult<Vec<f32>> {
            let array = contiguous::<f32>(given, name)?;
            if array.ndim() != 1 {
                return Err(shape_error(name, array.shape(), "(n,)"));
            }
            Ok(slice(&array)?.to_vec())
        };
        let odometry = contiguous::<f64>(odometry, "odometry")?;
        if !matches!(odometry.shape(), [_, 3]) {
            return Err(shape_error("odometry", odometry.shape(), "(k, 3)"));
        }
        let text = json_text(meta)?;
        let meta: RecordingMeta = json::parse(&text).map_err(|(field, problem)| {
            let remedy = "see docs/reference/recording.md";
            of_library(localizer::Error::invalid("meta", field, problem, remedy))
        })?;
        let meta = RecordingMeta {
            late_s: meta.late_s.or(Some(0.0)),
            drift_ppm: meta.drift_ppm.or(Some(0.0)),
            odometry_clock_s: meta.odometry_clock_s.or(Some(0.0)),
            truth_clock_s: meta.truth_clock_s.or(Some(0.0)),
            ..meta
        };
        let recording = localizer::Recording {
            signal: samples(signal, "signal")?,
            direct: direct.map(|direct| samples(direct, "direct")).transpose()?,
            odometry: slice(&odometry)?
                .chunks_exact(3)
                .map(|three| OdometrySample {
                    t_s: three[0],
                    v_mps: three[1],
                    omega_radps: three[2],
                })
                .collect(),
            truth: truth.map(|truth| truth.0.clone()),
            unheard: Vec::new(),
            meta,
        };
        recording.check("recording").map_err(of_library)?;
        Ok(Self::of(recording, "recording"))
    }

    /// Writes a recording folder, the one of ``echolot simulate -o``. What this program did not write is replaced with
    /// ``force`` alone.
    #[pyo3(signature = (folder, *, force = false))]
    fn save(&self, py: Python<'_>, folder: PathBuf, force: bool) -> PyResult<()> {
        let robot = self
            .robot
            .as_ref()
            .map(|(robot, path)| (robot, path.as_str()));
        let place = Place {
            bytes: 4 * self.recording.signal.len() as u64,
            ..Place::of(&folder, force)
        };
        py.detach(|| {
            place
                .whole_folder()
                .and_then(|()| write(&self.recording, robot, &folder))
        })
        .map_err(raised)
    }

    /// The microphone's signal, ``(n,)`` of float32: a read-only view.
    #[getter]
    fn signal<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        view::of(slf, |own| ArrayView1::from(&own.recording.signal))
    }

    /// The same drive without walls, a read-only view, or ``None``.
    #[getter]
    fn direct<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyAny>>> {
        if slf.get().recording.direct.is_none() {
            return Ok(None);
        }
        let none: &[f32] = &[];
        view::of(slf, |own| {
            ArrayView1::from(own.recording.direct.as_deref().unwrap_or(none))
        })
        .map(Some)
    }

    /// Rate of the signal in Hz.
    #[getter]
    fn sample_rate(&self) -> f64 {
        self.recording.meta.sample_rate_hz
    }

    /// Duration in seconds.
    #[getter]
    fn duration(&self) -> f64 {
        self.recording.duration_s()
    }

    /// The wheels' log: time (s), speed (m/s) and turn rate (rad/s), ``(k, 3)``.
    #[getter]
    fn odometry<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let samples = &self.recording.odometry;
        let numbers: Vec<f64> = samples
            .iter()
            .flat_map(|sample| [sample.t_s, sample.v_mps, sample.omega_radps])
            .collect();
        Array2::from_shape_vec((samples.len(), 3), numbers)
            .unwrap_or_default()
            .into_pyarray(py)
    }

    /// Mean speed (m/s) and turn rate (rad/s) of every period of the code, ``(periods, 2)``: what
    /// ``Localizer.step`` takes.
    fn odometry_per_period<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let parameters = localizer::Parameters::default().for_recording(&self.recording.meta);
        let periods = self.recording.signal.len() / parameters.samples_per_period();
        let means = self
            .recording
            .odometry_per_period(parameters.period_s(), periods);
        let numbers: Vec<f64> = means
            .iter()
            .flat_map(|mean| [mean.v_mps, mean.omega_radps])
            .collect();
        Array2::from_shape_vec((means.len(), 2), numbers)
            .unwrap_or_default()
            .into_pyarray(py)
    }

    /// The true poses, or ``None``.
    #[getter]
    fn truth(&self) -> Option<Trajectory> {
        self.recording.truth.clone().map(Trajectory)
    }

    /// The pose at time 0, where truth or ``recording.json`` tell it.
    #[getter]
    fn start(&self) -> Option<[f64; 3]> {
        self.recording.known_start().map(|pose| of_pose(&pose))
    }

    /// The fields of its ``recording.json``.
    #[getter]
    fn meta<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.recording.meta)
    }

    /// How rate, first period, drift and clocks were found.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// As plain arrays: ``signal``, ``t``, ``odometry``, ``truth`` and ``meta``.
    fn to_dict<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py()
            .import("echolot.interchange")?
            .call_method1("recording_to_dict", (slf,))
    }

    /// As an ``xarray.Dataset``; needs xarray (``pip install 'echolot[xarray]'``).
    fn to_xarray<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py()
            .import("echolot.interchange")?
            .call_method1("recording_to_xarray", (slf,))
    }

    fn __repr__(&self) -> String {
        format!(
            "Recording({:.2} s at {} Hz, {}truth)",
            self.recording.duration_s(),
            self.recording.meta.sample_rate_hz,
            match self.recording.truth {
                Some(_) => "with ",
                None => "without ",
            }
        )
    }
}
