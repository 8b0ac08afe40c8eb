//! A field that is stepped by hand.

use std::sync::{Mutex, MutexGuard, PoisonError};

use fdtd::grid::Grid;
use fdtd::simulation::{Places, SimulationOptions, SteppedField};
use ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyWeakrefMethods, PyWeakrefReference};

use crate::arrays::{contiguous, shape_error, slice};
use crate::error::of_library;
use crate::scene::Scene;
use crate::simulate::named;

/// Steps between two looks at signals.
const LOOK: usize = 256;

/// The silent sound field of a scene, to be stepped by hand with any number of moving sources and receivers.
///
/// ``Field(scene)``. Of the scene medium, grid, absorbing layer, walls, scheme and spreading count; its drives do not.
/// ``engine`` is ``"fast"`` or ``"reference"``, which give the same bytes.
#[pyclass(frozen, module = "echolot")]
pub(crate) struct Field {
    field: Mutex<SteppedField>,
    grid: Grid,
    /// The array that views of the pressure are of, which lives as long as one of them.
    shown: Mutex<Option<Py<PyWeakrefReference>>>,
}

impl Field {
    /// The array that views are of; none where nobody has a view.
    fn shown<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        let shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        match &*shown {
            Some(shown) => Ok(shown.bind(py).upgrade_as::<PyArray2<f32>>()?),
            None => Ok(None),
        }
    }

    /// Brings what views show up to date, where there are any.
    fn show(&self, py: Python<'_>) -> PyResult<()> {
        if let Some(shown) = self.shown(py)? {
            let pressure = py.detach(|| self.locked().pressure());
            let mut array = shown.try_readwrite()?;
            array.as_slice_mut()?.copy_from_slice(&pressure);
        }
        Ok(())
    }

    /// The field; one thread at a time has it, and none holds it while it waits for the interpreter.
    fn locked(&self) -> MutexGuard<'_, SteppedField> {
        self.field.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Points of an argument: as many for every step, or the same for all.
struct Points {
    places: Vec<[f64; 2]>,
    moving: Option<usize>,
}

impl Points {
    fn of(given: &Bound<'_, PyAny>, name: &str, steps: usize, alone: bool) -> PyResult<Self> {
        let array = contiguous::<f64>(given, name)?;
        let shape = array.shape().to_vec();
        let moving = match shape[..] {
            [2] => None,
            [count, 2] if alone && count == steps && steps != 1 => Some(1),
            [_, 2] => None,
            [count, points, 2] if count == steps => Some(points),
            _ => {
                let expected = format!(
                    "(2,) for one point, (points, 2) for several, ({steps}, points, 2) for moving ones"
                );
                return Err(shape_error(name, &shape, &expected));
            }
        };
        let places = slice(&array)?.chunks_exact(2).map(|two| [two[0], two[1]]);
        Ok(Self {
            places: places.collect(),
            moving,
        })
    }

    /// Those of some steps.
    fn of_steps(&self, steps: std::ops::Range<usize>) -> Places<'_> {
        match self.moving {
            None => Places::Fixed(&self.places),
            Some(count) => {
                Places::Moving(&self.places[steps.start * count..steps.end * count], count)
            }
        }
    }

    fn count(&self) -> usize {
        self.moving.unwrap_or(self.places.len())
    }
}

#[pymethods]
impl Field {
    #[new]
    #[pyo3(signature = (scene, *, scheme = None, spread = None, engine = "fast", threads = 0))]
    fn new(
        scene: &Scene,
        scheme: Option<&str>,
        spread: Option<&str>,
        engine: &str,
        threads: usize,
    ) -> PyResult<Self> {
        let reference_engine = match engine {
            "fast" => false,
            "reference" => true,
            _ => {
                let text = format!("engine: {engine:?} is not known; give 'fast' or 'reference'");
                return Err(PyValueError::new_err(text));
            }
        };
        let options = SimulationOptions {
            scheme: scheme.map(|name| named("scheme", name)).transpose()?,
            spread: spread.map(|name| named("spread", name)).transpose()?,
            threads,
            reference_engine,
            ..SimulationOptions::default()
        };
        let field = SteppedField::new(&scene.scene, &options).map_err(of_library)?;
        Ok(Self {
            grid: field.domain().grid,
            field: Mutex::new(field),
            shown: Mutex::new(None),
        })
    }

    /// Takes as many steps as there are strengths; returns the pressure at the receivers after each, in Pa.
    ///
    /// ``strengths``: ``(steps,)`` for one source or ``(steps, sources)``, source strengths in m^2/s at the instants
    /// that the steps lead to, the first ``dt`` after ``time``. ``sources`` and ``receivers``: places in metres,
    /// ``(2,)``, ``(points, 2)``, or ``(steps, points, 2)`` of moving ones; for one source ``(steps, 2)`` too. Sources
    /// are the same ones from call to call.
    ///
    /// ``callback(field)`` is called after every ``every`` steps, for example to look at ``pressure``.
    ///
    /// Returns float32 ``(steps, receivers)``, or ``(steps,)`` for a single receiver ``(2,)``. One source with one
    /// receiver gives the bytes of ``simulate``, many steps at a time; more of them are slower.
    #[pyo3(signature = (strengths, sources, receivers = None, *, callback = None, every = 0))]
    fn run<'py>(
        slf: &Bound<'py, Self>,
        strengths: &Bound<'py, PyAny>,
        sources: &Bound<'py, PyAny>,
        receivers: Option<&Bound<'py, PyAny>>,
        callback: Option<&Bound<'py, PyAny>>,
        every: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        if callback.is_some() != (every > 0) {
            return Err(PyValueError::new_err(
                "callback, every: belong together; give a function and a number of steps",
            ));
        }
        let strengths = contiguous::<f64>(strengths, "strengths")?;
        let (steps, count) = match *strengths.shape() {
            [steps] => (steps, 1),
            [steps, count] => (steps, count),
            _ => {
                let expected = "(steps,) or (steps, sources)";
                return Err(shape_error("strengths", strengths.shape(), expected));
            }
        };
        let sources = Points::of(sources, "sources", steps, count == 1)?;
        if sources.count() != count {
            return Err(PyValueError::new_err(format!(
                "sources: are {}, and there are strengths for {count}; give a place for each source",
                sources.count()
            )));
        }
        let (ears, single) = match receivers {
            Some(given) => {
                let array = contiguous::<f64>(given, "receivers")?;
                let single = array.ndim() == 1;
                (Points::of(given, "receivers", steps, false)?, single)
            }
            None => (
                Points {
                    places: Vec::new(),
                    moving: None,
                },
                false,
            ),
        };
        let strengths = slice(&strengths)?;
        let mut received: Vec<f32> = Vec::with_capacity(steps * ears.count());
        let own = slf.get();
        let mut first = 0;
        let mut advance = || -> PyResult<()> {
            while first < steps {
                py.check_signals()?;
                let mut end = steps.min(first + LOOK);
                if let Some(looks) = first.checked_div(every) {
                    end = end.min((looks + 1) * every);
                }
                let part = py.detach(|| {
                    own.locked().run(
                        &strengths[first * count..end * count],
                        sources.of_steps(first..end),
                        ears.of_steps(first..end),
                    )
                });
                received.extend(part.map_err(of_library)?);
                if let Some(callback) = callback.filter(|_| end.is_multiple_of(every.max(1))) {
                    own.show(py)?;
                    callback.call1((slf,))?;
                }
                first = end;
            }
            Ok(())
        };
        // Interrupted or refused, the field is where it is, and views show it.
        let advanced = advance();
        own.show(py)?;
        advanced?;
        if single {
            return Ok(received.into_pyarray(py).into_any());
        }
        let array = Array2::from_shape_vec((steps, ears.count()), received)
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(array.into_pyarray(py).into_any())
    }

    /// The newest pressure in Pa, float32 ``(ny, nx)``: a read-only view that follows the field.
    ///
    /// All views are of one array, which ``run`` keeps up to date before it calls ``callback`` and at its end, for as
    /// long as there is a view; take a ``copy()`` of what is to stay. Looking costs nothing. Keeping it costs one pass
    /// over the cells: the engine has rows in an order that suits vectors, which no strides describe.
    #[getter]
    fn pressure<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let array = match self.shown(py)? {
            Some(array) => array,
            None => {
                let pressure = py.detach(|| self.locked().pressure());
                let array = Array2::from_shape_vec((self.grid.ny, self.grid.nx), pressure)
                    .map_err(|error| PyValueError::new_err(error.to_string()))?
                    .into_pyarray(py);
                let weak = PyWeakrefReference::new(&array)?.unbind();
                *self.shown.lock().unwrap_or_else(PoisonError::into_inner) = Some(weak);
                array
            }
        };
        let view = array.call_method0("view")?;
        view.call_method1("setflags", (false,))?;
        Ok(view)
    }

    /// Time of the newest pressure in seconds.
    #[getter]
    fn time(&self, py: Python<'_>) -> f64 {
        py.detach(|| self.locked().time_s())
    }

    /// Steps taken so far.
    #[getter]
    fn steps(&self, py: Python<'_>) -> u64 {
        py.detach(|| self.locked().steps())
    }

    /// Time step in seconds.
    #[getter]
    fn dt(&self) -> f64 {
        self.grid.dt_s
    }

    /// Cell width in metres; the middle of cell ``[iy, ix]`` lies at ``((ix + 0.5) dx, (iy + 0.5) dx)``.
    #[getter]
    fn dx(&self) -> f64 {
        self.grid.dx_m
    }

    /// Cells, ``(ny, nx)``.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.grid.ny, self.grid.nx)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let (ny, nx) = self.shape();
        format!("Field({nx} x {ny} cells, {:.6} s)", self.time(py))
    }
}
