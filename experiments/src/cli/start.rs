//! The start of a drive as the command line says it.

use localizer::Pose;
use localizer::landmarks::Start;
use localizer::pose::wrap_angle;

use crate::localization::START_SIGMA;

/// Largest number of a start.
const FARTHEST: f64 = 1e5;

/// Start of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum StartArgument {
    Pose(Pose),
    Unknown,
}

/// Reads `X,Y,DEG` or `unknown`.
pub(super) fn start(text: &str) -> Result<StartArgument, String> {
    if text == "unknown" {
        return Ok(StartArgument::Unknown);
    }
    let numbers: Vec<f64> = text
        .split(',')
        .filter_map(|part| part.trim().parse().ok())
        .collect();
    match numbers[..] {
        [x_m, y_m, degrees]
            if text.split(',').count() == 3 && numbers.iter().all(|x| x.abs() <= FARTHEST) =>
        {
            Ok(StartArgument::Pose(Pose {
                x_m,
                y_m,
                heading_rad: wrap_angle(degrees.to_radians()),
            }))
        }
        _ => Err("give three numbers as in 1.5,2,90, or unknown".into()),
    }
}

/// Reads `M,DEG` as metres and radians.
pub(super) fn start_sigma(text: &str) -> Result<[f64; 2], String> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|part| part.trim().parse().ok())
        .collect();
    match numbers.as_deref() {
        Some(&[metres, degrees])
            if (0.0..=100.0).contains(&metres) && (0.0..=180.0).contains(&degrees) =>
        {
            Ok([metres, degrees.to_radians()])
        }
        _ => Err("give two numbers as in 0.1,5: at most 100 m and 180 degrees".into()),
    }
}

/// The start among landmarks: what was given, or a pose that the recording knows.
pub(super) fn among_landmarks(
    given: Option<StartArgument>,
    sigma: Option<[f64; 2]>,
    known: Pose,
) -> Start {
    let pose = match given {
        Some(StartArgument::Unknown) => return Start::Unknown,
        Some(StartArgument::Pose(pose)) => pose,
        None => known,
    };
    let [sigma_m, sigma_rad] = sigma.unwrap_or(START_SIGMA);
    Start::Known {
        pose,
        sigma_m,
        sigma_rad,
    }
}
