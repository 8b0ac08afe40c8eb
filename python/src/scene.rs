//! Scenes.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use experiments::data::atomic;
use experiments::data::place::Place;
use experiments::recordings::preflight;
use experiments::recordings::waveform::{parameters_of, source_waveform};
use fdtd::scene::{LayoutKind, random};
use localizer::{Parameters as Base, Pose, Trajectory as Track};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::arrays::{json_text, to_python};
use crate::error::{of_library, raised};
use crate::parameters::Parameters;
use crate::trajectory::Trajectory;

/// Medium, grid, walls, waveform, robot and named drive paths: the content of a scene file.
///
/// Scenes are checked when they are made and do not change; edit ``to_dict()`` and make another one. SI units,
/// radians; x right, y up, origin at the lower left corner of the domain.
#[pyclass(frozen, module = "echolot")]
pub(crate) struct Scene {
    pub(crate) scene: Arc<fdtd::scene::Scene>,
    /// Its text, and the file it came from: pose files of paths lie beside it.
    text: String,
    pub(crate) origin: PathBuf,
}

impl Scene {
    fn of_text(text: String, origin: PathBuf) -> PyResult<Self> {
        let scene = fdtd::scene::Scene::from_json(&text, &origin).map_err(of_library)?;
        preflight::check_scene(&scene, &origin.display().to_string()).map_err(raised)?;
        Ok(Self {
            scene: Arc::new(scene),
            text,
            origin,
        })
    }
}

#[pymethods]
impl Scene {
    /// Reads and checks a scene file.
    ///
    /// Raises ``OSError`` when it cannot be read, ``ValueError`` that names file, field and remedy otherwise.
    #[classmethod]
    fn load(_: &Bound<'_, PyType>, file: PathBuf) -> PyResult<Self> {
        let text = std::fs::read_to_string(&file)
            .map_err(|source| of_library(fdtd::Error::io(&file, source)))?;
        Self::of_text(text, file)
    }

    /// A scene from the fields of a scene file (``docs/reference/scene.md``). Files that it names are looked up in
    /// ``folder``.
    #[classmethod]
    #[pyo3(signature = (fields, folder = PathBuf::new()))]
    fn from_dict(
        _: &Bound<'_, PyType>,
        fields: &Bound<'_, PyDict>,
        folder: PathBuf,
    ) -> PyResult<Self> {
        Self::of_text(json_text(fields)?, folder.join("scene"))
    }

    /// Walls, air and two drives of 40 s (``mapping``, ``localization``) drawn at random. ``kind`` is ``"open"``
    /// (three to five single walls) or ``"room"``. Equal kinds and seeds give equal scenes.
    #[classmethod]
    #[pyo3(signature = (kind, seed))]
    fn random(_: &Bound<'_, PyType>, kind: &str, seed: u64) -> PyResult<Self> {
        let kind = [LayoutKind::Open, LayoutKind::Room]
            .into_iter()
            .find(|known| known.name() == kind)
            .ok_or_else(|| {
                PyValueError::new_err(format!(
                    "kind: {kind:?} is not known; give 'open' or 'room'"
                ))
            })?;
        let text = serde_json::to_string_pretty(&random::layout(kind, seed)).map_err(of_library)?;
        Self::of_text(text, PathBuf::from("scene"))
    }

    /// The fields of its scene file.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = self.text.trim_start_matches('\u{feff}');
        py.import("json")?.call_method1("loads", (text,))
    }

    /// Writes its scene file. A file that exists is replaced with ``force`` alone.
    #[pyo3(signature = (file, *, force = false))]
    fn save(&self, file: PathBuf, force: bool) -> PyResult<()> {
        Place::of(&file, force)
            .file(|bytes| bytes == self.text.as_bytes())
            .and_then(|()| atomic::write(&file, self.text.as_bytes()))
            .map_err(raised)
    }

    /// Short name, for titles.
    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    /// Speed of sound in m/s.
    #[getter]
    fn speed_of_sound(&self) -> f64 {
        self.scene.medium.c_mps
    }

    /// Cells of the grid, ``(ny, nx)``.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.scene.grid.ny, self.scene.grid.nx)
    }

    /// Cell width in metres.
    #[getter]
    fn dx(&self) -> f64 {
        self.scene.grid.dx_m
    }

    /// Time step in seconds.
    #[getter]
    fn dt(&self) -> f64 {
        self.scene.grid.dt_s
    }

    /// Width of the absorbing layer on each side in metres.
    #[getter]
    fn layer(&self) -> f64 {
        self.scene.layer_cells as f64 * self.scene.grid.dx_m
    }

    /// Rate of the microphone's signal in Hz.
    #[getter]
    fn sample_rate(&self) -> f64 {
        self.scene.sample_rate_hz
    }

    /// Duration of each drive path in seconds, by its name.
    #[getter]
    fn paths<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let paths = PyDict::new(py);
        for (name, path) in &self.scene.paths {
            paths.set_item(name, path.duration_s())?;
        }
        Ok(paths)
    }

    /// The middle line of each wall, ``(n, 2)`` in metres.
    #[getter]
    fn walls<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        (self.scene.walls.iter())
            .map(|wall| {
                let points: Vec<Vec<f64>> =
                    wall.points_m.iter().map(|point| point.to_vec()).collect();
                Ok(PyArray2::from_vec2(py, &points)?)
            })
            .collect()
    }

    /// The true poses of a drive, ``rate`` times a second.
    #[pyo3(signature = (path, rate = 50.0))]
    fn drive(&self, path: &str, rate: f64) -> PyResult<Trajectory> {
        let drive = self.scene.path(path).map_err(of_library)?;
        let count = drive.duration_s() * rate;
        if !(0.0..=1e8).contains(&count) {
            return Err(PyValueError::new_err(format!(
                "rate: {rate} Hz cannot be used; give a positive number"
            )));
        }
        let t_s: Vec<f64> = (0..=(count + 1e-9) as usize)
            .map(|k| k as f64 / rate)
            .collect();
        let poses = t_s.iter().map(|&t| {
            let state = drive.state_at(t);
            Pose {
                x_m: state.x_m,
                y_m: state.y_m,
                heading_rad: state.heading_rad,
            }
        });
        Ok(Trajectory(Track {
            poses: poses.collect(),
            t_s,
        }))
    }

    /// One period of the loudspeaker's sound at ``sample_rate``, amplitude 1, band-limited as it is emitted.
    fn waveform<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let waveform = source_waveform(&self.scene).map_err(raised)?;
        let count = (waveform.period_s() * self.scene.sample_rate_hz).round() as usize;
        let samples: Vec<f64> = (0..count)
            .map(|k| waveform.value(k as f64 / self.scene.sample_rate_hz))
            .collect();
        Ok(samples.into_pyarray(py))
    }

    /// The source strength in m^2/s that the loudspeaker of ``simulate`` has at these times (seconds): what a
    /// ``Field`` takes.
    fn source_strength<'py>(
        &self,
        py: Python<'py>,
        times: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let times = crate::arrays::contiguous::<f64>(times, "times")?;
        let times = crate::arrays::slice(&times)?;
        let waveform = source_waveform(&self.scene).map_err(raised)?;
        let strength = fdtd::simulation::SOURCE_STRENGTH_M2PS;
        let strengths: Vec<f64> = times
            .iter()
            .map(|&t| strength * waveform.value(t))
            .collect();
        Ok(strengths.into_pyarray(py))
    }

    /// The parameters of a localizer for its waveform, rate, air and robot; the others are those of ``base``.
    #[pyo3(signature = (base = None))]
    fn parameters(&self, base: Option<&Parameters>) -> Parameters {
        let default = Base::default();
        Parameters(parameters_of(
            &self.scene,
            base.map_or(&default, |base| &base.0),
        ))
    }

    /// The description of its medium, grid and waveform as numbers.
    fn medium<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let medium = self.scene.medium;
        to_python(
            py,
            &serde_json::json!({"c_mps": medium.c_mps, "rho_kgpm3": medium.rho_kgpm3}),
        )
    }

    /// Draws walls, drive paths and absorbing layer; needs matplotlib (``pip install 'echolot[plot]'``). Returns the
    /// axes.
    #[pyo3(signature = (ax = None))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        ax: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let draw = slf.py().import("echolot._plot")?.getattr("scene")?;
        draw.call1((slf, ax))
    }

    fn __repr__(&self) -> String {
        let [width, height] = self.scene.grid.size_m();
        format!(
            "Scene({:?}, {width:.2} x {height:.2} m, {} walls, paths {:?})",
            self.scene.name,
            self.scene.walls.len(),
            self.scene.paths.keys().collect::<Vec<_>>()
        )
    }
}

impl Scene {
    /// The name under which errors speak of it.
    pub(crate) fn display(&self) -> String {
        Path::display(&self.origin).to_string()
    }
}
