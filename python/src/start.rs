//! Where a drive begins, and by which method a map is used.

use experiments::localization::START_SIGMA;
use experiments::mapping::Map;
use localizer::landmarks::Start;
use localizer::{Method, Pose};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::pose;

/// Where a drive begins: a pose, or nothing known.
#[derive(FromPyObject)]
pub(crate) enum StartArgument {
    Pose([f64; 3]),
    Word(String),
}

impl StartArgument {
    /// The pose; ``None`` when nothing is known.
    pub(crate) fn pose(&self) -> PyResult<Option<Pose>> {
        match self {
            Self::Pose(numbers) if numbers.iter().all(|number| number.abs() <= 1e5) => {
                Ok(Some(pose(*numbers)))
            }
            Self::Word(word) if word == "unknown" => Ok(None),
            _ => Err(PyValueError::new_err(
                "start: give (x, y, heading) in metres and radians, or 'unknown'",
            )),
        }
    }
}

/// A start among landmarks.
pub(crate) fn landmark_start(start: Option<Pose>, sigma: Option<[f64; 2]>) -> Start {
    let [sigma_m, sigma_rad] = sigma.unwrap_or(START_SIGMA);
    match start {
        None => Start::Unknown,
        Some(pose) => Start::Known {
            pose,
            sigma_m,
            sigma_rad,
        },
    }
}

/// Refuses standard deviations of a start that cannot be.
pub(crate) fn check_sigma(sigma: Option<[f64; 2]>) -> PyResult<()> {
    match sigma {
        Some([m, rad]) if !((0.0..=100.0).contains(&m) && (0.0..=3.2).contains(&rad)) => {
            Err(PyValueError::new_err(
                "start_sigma: give two numbers as in (0.1, 0.05): at most 100 m and pi rad",
            ))
        }
        _ => Ok(()),
    }
}

/// The method that suits a map, or the one that is asked for.
pub(crate) fn method_of(map: &Map, method: Option<&str>) -> PyResult<Option<Method>> {
    let refuse = |text: String| Err(PyValueError::new_err(format!("method: {text}")));
    let of_images = matches!(map, Map::Images(_));
    let found = match method {
        None if of_images => Some(Method::Doppler),
        None | Some("landmarks") => None,
        Some("doppler") => Some(Method::Doppler),
        Some("toa-only") => Some(Method::ToaOnly),
        Some("odometry") => Some(Method::Odometry),
        Some(other) => {
            return refuse(format!(
                "{other:?} is not known; give 'doppler', 'toa-only', 'odometry' or 'landmarks'"
            ));
        }
    };
    match (found, of_images) {
        (None, true) => refuse("'landmarks' needs a map built with method='landmarks'".into()),
        (Some(_), false) => refuse("the map is one of landmarks; leave the method out".into()),
        (found, _) => Ok(found),
    }
}
