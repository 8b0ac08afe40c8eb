//! From a scene and one of its drives to a recording.

use std::path::PathBuf;

use anyhow::{Result, bail};
use experiments::recordings::preflight;
use experiments::recordings::recording::{Extras, record};
use experiments::recordings::robot::Robot;
use experiments::recordings::simulate::{image_signal, prepare};
use experiments::recordings::spec::{Engine, IMAGE_ORDER, RecordingSpec};
use experiments::run::interrupt::Interrupted;
use fdtd::simulation::{Flow, Outcome};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde::de::DeserializeOwned;

use crate::background::{self, Control};
use crate::error::{of_library, raised};
use crate::recording::Recording;
use crate::scene::Scene;

/// A choice by its name in files.
pub(crate) fn named<T: DeserializeOwned>(name: &str, text: &str) -> PyResult<T> {
    serde_json::from_value(serde_json::Value::String(text.to_string()))
        .map_err(|error| PyValueError::new_err(format!("{name}: {error}")))
}

/// Most reflections of an image source's echo.
const MOST_REFLECTIONS: u8 = 6;

/// Simulates a drive of a scene. The Python function around it gives progress a default.
#[pyfunction]
#[pyo3(signature = (scene, path, *, engine, image_order, scheme, spread, walls, free_field, whole_domain,
    with_direct, absorption, odometry_bias, robot, threads, progress))]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn simulate(
    py: Python<'_>,
    scene: &Scene,
    path: &str,
    engine: &str,
    image_order: Option<u8>,
    scheme: Option<&str>,
    spread: Option<&str>,
    walls: Option<&str>,
    free_field: bool,
    whole_domain: bool,
    with_direct: bool,
    absorption: bool,
    odometry_bias: f64,
    robot: Option<PathBuf>,
    threads: usize,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Recording> {
    let refuse = |text: &str| Err(PyValueError::new_err(text.to_string()));
    let engine: Engine = named("engine", engine)?;
    match (engine, image_order) {
        (Engine::Fdtd, Some(_)) => {
            return refuse(
                "image_order: is for image sources, the field has all reflections; leave it out, or give \
                 engine='image-source'",
            );
        }
        (_, Some(order)) if !(1..=MOST_REFLECTIONS).contains(&order) => {
            return refuse("image_order: give 1 to 6");
        }
        _ => {}
    }
    if !odometry_bias.is_finite() {
        return refuse("odometry_bias: is not finite; give a number in rad/s");
    }
    if free_field && (with_direct || robot.is_some()) {
        return refuse(
            "free_field: has neither a direct wave nor a robot of its own; leave one out",
        );
    }
    let spec = RecordingSpec {
        image_order: usize::from(image_order.unwrap_or(IMAGE_ORDER)),
        scheme: scheme.map(|name| named("scheme", name)).transpose()?,
        spread: spread.map(|name| named("spread", name)).transpose()?,
        wall_model: walls.map(|name| named("walls", name)).transpose()?,
        free_field,
        whole_domain,
        odometry_bias_radps: odometry_bias,
        ..RecordingSpec::of(path, engine)
    };
    let mut own = fdtd::scene::Scene::clone(&scene.scene);
    own.scheme = spec.scheme.unwrap_or(own.scheme);
    own.spread = spec.spread.unwrap_or(own.spread);
    own.wall_model = spec.wall_model.unwrap_or(own.wall_model);
    own.check(&scene.display()).map_err(of_library)?;
    let air = match (absorption, own.air) {
        (false, _) => None,
        (true, Some(air)) => Some(air),
        (true, None) => {
            return refuse(
                "absorption: the medium of the scene has no temperature and humidity; give both in the scene",
            );
        }
    };
    let robot = robot
        .map(|file| Robot::read(&file))
        .transpose()
        .map_err(raised)?;
    preflight::check(&own, &scene.display(), &spec, robot.as_ref()).map_err(raised)?;
    let name = format!("{}, {}", own.name, spec.path);
    let with_robot = robot.clone().map(|robot| (robot, spec.path.clone()));
    let recording = background::run(py, progress, move |control| {
        let extras = Extras {
            air: air.as_ref(),
            with_direct,
            robot: robot.as_ref(),
        };
        record(&own, &spec, &extras, &mut |spec| {
            signal(&own, spec, threads, control)
        })
    })?;
    Ok(Recording {
        robot: with_robot,
        ..Recording::of(recording, &name)
    })
}

/// The signal of one drive.
fn signal(
    scene: &fdtd::scene::Scene,
    spec: &RecordingSpec,
    threads: usize,
    control: &Control,
) -> Result<Vec<f32>> {
    if spec.engine == Engine::ImageSource {
        return image_signal(scene, spec);
    }
    let mut simulation = prepare(scene, spec, threads)?;
    let outcome = simulation.run(&mut |progress, _| {
        control.set(progress.step, progress.steps_total);
        match control.stopped() {
            true => Flow::Stop,
            false => Flow::Continue,
        }
    })?;
    match outcome {
        Outcome::Finished => Ok(simulation.signal()),
        Outcome::Stopped => bail!(Interrupted),
    }
}

/// The sound that a loudspeaker plays; see the Python function around it.
#[pyfunction]
#[pyo3(signature = (seconds, rate, level, code, carrier, chips, file, bits, force))]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn transmit<'py>(
    py: Python<'py>,
    seconds: f64,
    rate: u32,
    level: f64,
    code: usize,
    carrier: f64,
    chips: f64,
    file: Option<PathBuf>,
    bits: u16,
    force: bool,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    use experiments::transmission::{Transmission, check_place};
    use numpy::IntoPyArray;

    let transmission = Transmission {
        seconds,
        rate_hz: rate,
        level_db: level,
        code_length: code,
        carrier_hz: carrier,
        chip_rate_hz: chips,
    };
    // The command's options are this function's keywords.
    let in_python = |error: anyhow::Error| match error.to_string().strip_prefix("--") {
        Some(text) => PyValueError::new_err(text.replace("--", "")),
        None => raised(error),
    };
    let (samples, description) = py
        .detach(|| -> Result<_> {
            transmission.check()?;
            if let Some(file) = &file {
                check_place(file, bits, force)?;
            }
            let sound = transmission.sound()?;
            let samples: Vec<f32> = sound.samples.iter().map(|x| x * sound.scale).collect();
            let description = match &file {
                Some(file) => sound.write(file, bits)?,
                None => sound.description,
            };
            Ok((samples, description))
        })
        .map_err(in_python)?;
    let description = crate::arrays::to_python(py, &description)?;
    Ok((samples.into_pyarray(py).into_any(), description))
}
