//! Studies.

use std::path::PathBuf;

use experiments::data::place::Place;
use experiments::figures;
use experiments::recordings::spec::{Engine, IMAGE_ORDER};
use experiments::run::interrupt;
use experiments::session::Workspace;
use experiments::study::cells::Cell;
use experiments::study::{self, StudySummary};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::arrays::{json_text, to_python};
use crate::background;
use crate::error::raised;
use crate::simulate::named;

/// A study: scenes, robots, methods and what varies, run over many draws (``docs/reference/study.md``).
#[pyclass(frozen, module = "echolot")]
pub(crate) struct Study {
    text: String,
    origin: PathBuf,
}

impl Study {
    fn read(&self, engine: Option<&str>, image_order: Option<u8>) -> PyResult<study::Study> {
        let mut own = study::Study::parse(&self.text, &self.origin).map_err(raised)?;
        if let Some(engine) = engine {
            let engine: Engine = named("engine", engine)?;
            own.set_engine(engine, image_order.unwrap_or(IMAGE_ORDER))
                .map_err(raised)?;
        }
        Ok(own)
    }
}

#[pymethods]
impl Study {
    /// Reads and checks a study file.
    #[classmethod]
    fn load(_: &Bound<'_, PyType>, file: PathBuf) -> PyResult<Self> {
        let text = std::fs::read_to_string(&file).map_err(|error| {
            raised(anyhow::Error::new(error).context(file.display().to_string()))
        })?;
        let own = Self { text, origin: file };
        own.read(None, None)?;
        Ok(own)
    }

    /// A study from the fields of a study file; scenes and robots that it names are looked up in ``folder``.
    #[classmethod]
    #[pyo3(signature = (fields, folder = PathBuf::new()))]
    fn from_dict(
        _: &Bound<'_, PyType>,
        fields: &Bound<'_, PyDict>,
        folder: PathBuf,
    ) -> PyResult<Self> {
        let own = Self {
            text: json_text(fields)?,
            origin: folder.join("study"),
        };
        own.read(None, None)?;
        Ok(own)
    }

    /// Its name.
    #[getter]
    fn name(&self) -> PyResult<String> {
        Ok(self.read(None, None)?.file.name.clone())
    }

    /// The names of its cells.
    #[getter]
    fn cells(&self) -> PyResult<Vec<String>> {
        Ok(self
            .read(None, None)?
            .cells
            .iter()
            .map(Cell::name)
            .collect())
    }

    /// Runs it: simulations, trials, results. What is in the cache is not computed again, so that the same call goes
    /// on after Ctrl-C; several processes with one cache share the work.
    ///
    /// Writes data, summary and, with ``figures``, figures into ``results/<name>`` and returns the summary as
    /// dictionaries. ``engine="image-source"`` replaces the field by image sources; ``only`` chooses cells by name.
    #[pyo3(signature = (results = PathBuf::from("results"), *, cache = None, only = Vec::new(), engine = None,
        image_order = None, figures = true, force = false))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn run<'py>(
        &self,
        py: Python<'py>,
        results: PathBuf,
        cache: Option<PathBuf>,
        only: Vec<String>,
        engine: Option<&str>,
        image_order: Option<u8>,
        figures: bool,
        force: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let own = self.read(engine, image_order)?;
        let cache = cache.unwrap_or_else(|| results.join("cache"));
        let results = results.join(&own.file.name);
        Place {
            inputs: vec![self.origin.clone()],
            ..Place::of(results.join("summary.json"), force)
        }
        .file(|bytes| serde_json::from_slice::<StudySummary>(bytes).is_ok())
        .map_err(raised)?;
        let (done, wait) = std::sync::mpsc::channel();
        let summary = background::run(py, None, move |_| {
            let workspace = Workspace::new(&cache, None);
            let run = || -> anyhow::Result<StudySummary> {
                let plan = study::Plan::new(&own, &only, &workspace)?;
                eprint!("{}", plan.text(&own, &workspace)?);
                let summary = study::run(&own, &plan, &workspace, &results)?;
                if figures {
                    figures::study::draw(&own, &results)?;
                }
                Ok(summary)
            };
            let summary = run();
            // Somebody waits only after Ctrl-C.
            let _ = done.send(());
            summary
        });
        let summary = summary.inspect_err(|error| {
            if !error.is_instance_of::<PyKeyboardInterrupt>(py) {
                return;
            }
            // The study ends soon, with what is done in the cache; then another one may begin.
            interrupt::request();
            py.detach(move || {
                let _ = wait.recv();
            });
            interrupt::clear();
        })?;
        to_python(py, &summary)
    }

    fn __repr__(&self) -> PyResult<String> {
        let own = self.read(None, None)?;
        Ok(format!(
            "Study({:?}, {} cells)",
            own.file.name,
            own.cells.len()
        ))
    }
}
