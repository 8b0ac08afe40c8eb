//! Maps.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::bail;
use experiments::data::manifest;
use experiments::data::place::Place;
use experiments::drive::Drive;
use experiments::mapping::{Map, MapKind, Mapping};
use experiments::trust::{Warnings, changed};
use localizer::landmarks::{self, LandmarkMap, Shape};
use localizer::{MapImage, Parameters as Base};
use ndarray::ArrayView2;
use pyo3::exceptions::{PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::arrays::to_python;
use crate::background;
use crate::error::raised;
use crate::parameters::Parameters;
use crate::recording::Recording;
use crate::view;

/// A map of a place: echo images on a grid (the papers'), or landmarks (walls and corners).
#[pyclass(frozen, module = "echolot")]
pub(crate) struct EchoMap {
    pub(crate) map: Arc<Map>,
}

/// Tells warnings of the libraries as Python's.
pub(crate) fn warn(py: Python<'_>, warnings: Warnings) -> PyResult<()> {
    let category = py.get_type::<PyUserWarning>();
    for line in warnings.lines() {
        let line = std::ffi::CString::new(line.replace('\0', " "))?;
        PyErr::warn(py, &category, &line, 2)?;
    }
    Ok(())
}

#[pymethods]
impl EchoMap {
    /// Builds a map of drives whose true poses are known. ``method`` is ``"images"`` or ``"landmarks"``.
    ///
    /// ``parameters`` may choose periods, directions, cells and ranges; ``periods`` alone is the number M of periods in
    /// a block (6 for images, 2 for landmarks unless given). Raises ``ValueError`` when a recording has no truth or
    /// holds no echoes; warns when its truth has outliers or gaps.
    #[classmethod]
    #[pyo3(signature = (recordings, method = "images", *, parameters = None, periods = None, progress = None))]
    fn build(
        cls: &Bound<'_, PyType>,
        recordings: Vec<PyRef<'_, Recording>>,
        method: &str,
        parameters: Option<&Parameters>,
        periods: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let kind = match method {
            "images" => MapKind::Images,
            "landmarks" => MapKind::Landmarks,
            _ => {
                let text = format!("method: {method:?} is not known; give 'images' or 'landmarks'");
                return Err(PyValueError::new_err(text));
            }
        };
        let mut own = parameters.map_or_else(Base::default, |given| given.0.clone());
        if parameters.is_none() && kind == MapKind::Landmarks {
            own.measurement.periods = landmarks::PERIODS;
        }
        own.measurement.periods = periods.unwrap_or(own.measurement.periods);
        let drives: Vec<(Arc<localizer::Recording>, PathBuf)> = recordings
            .iter()
            .map(|recording| (Arc::clone(&recording.recording), recording.name.clone()))
            .collect();
        drop(recordings);
        let (map, warnings) = background::run(cls.py(), progress, move |control| {
            let mut warnings = Warnings::default();
            let mut mapping = Mapping::new(kind, own);
            let all = drives.len() as u64;
            for (done, (recording, name)) in drives.iter().enumerate() {
                control.check()?;
                warnings.extend(changed(name));
                mapping.add(&Drive::loaded(recording, name), &mut warnings)?;
                control.set(done as u64 + 1, all);
            }
            Ok((mapping.finish()?.0, warnings))
        })?;
        warn(cls.py(), warnings)?;
        Ok(Self { map: Arc::new(map) })
    }

    /// Reads a map folder of either kind.
    #[classmethod]
    fn load(cls: &Bound<'_, PyType>, folder: PathBuf) -> PyResult<Self> {
        let map = cls.py().detach(|| read(&folder)).map_err(raised)?;
        warn(cls.py(), {
            let mut warnings = Warnings::default();
            warnings.extend(changed(&folder));
            warnings
        })?;
        Ok(Self { map: Arc::new(map) })
    }

    /// Writes a map folder, the one of ``echolot map -o``. What this program did not write is replaced with ``force``
    /// alone.
    #[pyo3(signature = (folder, *, force = false))]
    fn save(&self, folder: PathBuf, force: bool) -> PyResult<()> {
        let files = match *self.map {
            Map::Images(_) => MapKind::Images.files(),
            Map::Landmarks(_) => MapKind::Landmarks.files(),
        };
        Place::of(&folder, force)
            .files_in_folder(files)
            .and_then(|()| {
                manifest::put_into(&folder, |new| {
                    match self.map.as_ref() {
                        Map::Images(map) => map.write(new)?,
                        Map::Landmarks(map) => map.write(new)?,
                    }
                    Ok(())
                })
            })
            .map_err(raised)
    }

    /// ``"images"`` or ``"landmarks"``.
    #[getter]
    fn kind(&self) -> &'static str {
        match *self.map {
            Map::Images(_) => "images",
            Map::Landmarks(_) => "landmarks",
        }
    }

    /// The parameters with which it was made.
    #[getter]
    fn parameters(&self) -> Parameters {
        Parameters(match self.map.as_ref() {
            Map::Images(map) => map.parameters.clone(),
            Map::Landmarks(map) => map.parameters.clone(),
        })
    }

    /// The echo images added up, float32 ``(ny, nx)``: a read-only view. ``None`` of landmarks.
    #[getter]
    fn intensity<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyAny>>> {
        match slf.get().map.as_ref() {
            Map::Images(_) => view::of(slf, Self::layer).map(Some),
            Map::Landmarks(_) => Ok(None),
        }
    }

    /// Left, right, lower and upper edge of the image in metres, as matplotlib takes them; of landmarks those of the
    /// area in which they were learnt.
    #[getter]
    fn extent(&self) -> [f64; 4] {
        match self.map.as_ref() {
            Map::Images(map) => {
                let [x, y] = map.origin_m().map(|centre| centre - 0.5 * map.cell_m);
                let (rows, columns) = map.intensity.dim();
                [
                    x,
                    x + columns as f64 * map.cell_m,
                    y,
                    y + rows as f64 * map.cell_m,
                ]
            }
            Map::Landmarks(map) => {
                let [[x, right], [y, top]] = map.area_m;
                [x, right, y, top]
            }
        }
    }

    /// The landmarks, the most often seen first: dictionaries with ``kind`` (``"wall"`` or ``"point"``), ``ends`` of a
    /// wall's stretch that was seen or ``place`` of a point in metres, ``covariance`` of its two numbers, ``blocks`` in
    /// which it was seen, and ``is_image`` where it lies behind a wall: a mirror image. Empty of images.
    #[getter]
    fn landmarks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let Map::Landmarks(map) = self.map.as_ref() else {
            return to_python(py, &Vec::<u8>::new());
        };
        let all = map.landmarks.iter().map(|landmark| {
            let mut fields = serde_json::json!({
                "covariance": landmark.covariance,
                "range_sigma_m": landmark.range_sigma_m,
                "blocks": landmark.blocks,
                "is_image": map.is_image(landmark),
            });
            match landmark.shape {
                Shape::Wall { .. } => {
                    fields["kind"] = "wall".into();
                    fields["ends"] = serde_json::json!(landmark.ends_m());
                }
                Shape::Point { place_m } => {
                    fields["kind"] = "point".into();
                    fields["place"] = serde_json::json!(place_m);
                }
            }
            fields
        });
        to_python(py, &all.collect::<Vec<_>>())
    }

    /// Draws it; needs matplotlib (``pip install 'echolot[plot]'``). Returns the axes.
    #[pyo3(signature = (ax = None))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        ax: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let draw = slf.py().import("echolot._plot")?.getattr("echo_map")?;
        draw.call1((slf, ax))
    }

    fn __repr__(&self) -> String {
        match self.map.as_ref() {
            Map::Images(map) => {
                let (rows, columns) = map.intensity.dim();
                format!("EchoMap({columns} x {rows} cells of {} m)", map.cell_m)
            }
            Map::Landmarks(map) => format!("EchoMap({} landmarks)", map.landmarks.len()),
        }
    }
}

impl EchoMap {
    fn layer(&self) -> ArrayView2<'_, f32> {
        match self.map.as_ref() {
            Map::Images(map) => map.intensity.view(),
            Map::Landmarks(_) => ndarray::aview2::<f32, 0>(&[]),
        }
    }
}

/// Reads a map folder of the kind that it is.
fn read(folder: &Path) -> anyhow::Result<Map> {
    match (
        folder.join("landmarks.json").exists(),
        folder.join("map.json").exists(),
    ) {
        (true, true) => bail!(
            "{}: holds a map of images and one of landmarks; give each a folder of its own",
            folder.display()
        ),
        (true, false) => Ok(Map::Landmarks(LandmarkMap::read(folder)?)),
        (false, _) => Ok(Map::Images(MapImage::read(folder)?)),
    }
}
