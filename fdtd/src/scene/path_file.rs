//! A drive as a scene file has it: start and legs, or a file of poses.

use crate::error::Error;
use crate::motion::{DriveLimits, DrivePath, MotionState, VelocityCommand, relocate};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A drive: either `start` and `legs`, or `file`.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Path")]
pub(super) struct PathFile {
    /// Pose (and speeds, by default zero) at time 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    start: Option<StartFile>,
    /// Commands, one after the other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    legs: Option<Vec<LegFile>>,
    /// How fast the speed follows its commands, in m/s^2 (default 0.5).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    acceleration_mps2: Option<f64>,
    /// How fast the turn rate follows its commands, in rad/s^2 (default 1.0).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    angular_acceleration_radps2: Option<f64>,
    /// File of poses beside the scene file: `*.csv` with the header `t_s,x_m,y_m,heading_rad`, or a TUM trajectory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    file: Option<String>,
}

/// Where a drive begins.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Start")]
struct StartFile {
    /// Position in metres.
    x_m: f64,
    /// Position in metres.
    y_m: f64,
    /// Heading in radians, counter-clockwise from +x.
    heading_rad: f64,
    /// Speed at time 0 in m/s.
    #[serde(default)]
    v_mps: f64,
    /// Turn rate at time 0 in rad/s.
    #[serde(default)]
    omega_radps: f64,
}

/// A command: drive at this speed and turn rate for this long.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Leg")]
struct LegFile {
    /// Duration in seconds, including the time to reach the commanded speeds.
    duration_s: f64,
    /// Commanded speed along the heading in m/s.
    v_mps: f64,
    /// Commanded turn rate in rad/s, counter-clockwise.
    omega_radps: f64,
}

impl PathFile {
    /// The drive `paths.name` of the scene file `origin`.
    pub(super) fn into_path(self, name: &str, origin: &Path) -> Result<DrivePath, Error> {
        let plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-';
        if name.is_empty() || !name.chars().all(plain) {
            let problem = format!("{name:?} is not a name for a path");
            return Err(Error::invalid(
                origin.display(),
                "paths",
                problem,
                "use letters, digits, `_` and `-`",
            ));
        }
        let refuse = |problem: &str| {
            let remedy = "give `start` and `legs`, or `file` alone";
            Err(Error::invalid(
                origin.display(),
                format!("paths.{name}"),
                problem,
                remedy,
            ))
        };
        let limited =
            self.acceleration_mps2.is_some() || self.angular_acceleration_radps2.is_some();
        match (self.start, self.legs, self.file) {
            (None, None, Some(file)) if !limited => DrivePath::read(&origin.with_file_name(file)),
            (Some(start), Some(legs), None) => {
                let legs: Vec<VelocityCommand> = legs.iter().map(LegFile::leg).collect();
                let usual = DriveLimits::default();
                let limits = DriveLimits {
                    acceleration_mps2: self.acceleration_mps2.unwrap_or(usual.acceleration_mps2),
                    angular_acceleration_radps2: self
                        .angular_acceleration_radps2
                        .unwrap_or(usual.angular_acceleration_radps2),
                };
                DrivePath::from_commands(start.state(), &legs, limits)
                    .map_err(|error| relocate(error, origin.display(), &format!("paths.{name}.")))
            }
            (_, _, Some(_)) => refuse("`file` stands beside fields of a commanded drive"),
            (None, _, None) => refuse("`start` is missing"),
            (Some(_), None, None) => refuse("`legs` is missing"),
        }
    }
}

impl StartFile {
    fn state(&self) -> MotionState {
        MotionState {
            x_m: self.x_m,
            y_m: self.y_m,
            heading_rad: self.heading_rad,
            v_mps: self.v_mps,
            omega_radps: self.omega_radps,
        }
    }
}

impl LegFile {
    fn leg(&self) -> VelocityCommand {
        VelocityCommand {
            duration_s: self.duration_s,
            v_mps: self.v_mps,
            omega_radps: self.omega_radps,
        }
    }
}
