//! The scene file as written: flat structs that deny unknown fields.

use super::locate::describe;
use super::model::{Robot, Scene, WaveformSpec};
use super::path_file::PathFile;
use super::wall_file::WallFile;
use crate::error::Error;
use crate::grid::{Grid, Medium};
use crate::medium::{Air, STANDARD_PRESSURE_PA};
use crate::scheme::Scheme;
use crate::spread::Spread;
use crate::walls::WallModel;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// A scene: medium, grid, absorbing layer, rigid walls, waveform, robot and named drive paths. SI units, radians; x
/// right, y up, origin at the lower left corner of the domain.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Scene")]
pub(super) struct SceneFile {
    /// The schema this file follows, for editors; not read.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    _schema: Option<String>,
    /// Short name, for titles.
    name: String,
    /// Description of the scene.
    #[serde(default)]
    description: String,
    /// The air.
    #[serde(default = "default_medium")]
    medium: MediumFile,
    /// Size and step of the grid.
    grid: GridFile,
    /// Width of the absorbing layer on each of the four sides, in cells.
    #[serde(default = "default_layer_cells")]
    layer_cells: usize,
    /// Finite-difference scheme.
    #[serde(default = "default_scheme")]
    scheme: Scheme,
    /// Spreading of the moving source and interpolation at the moving receiver.
    #[serde(default = "default_spread")]
    spread: Spread,
    /// Walls.
    #[serde(default)]
    walls: Vec<WallFile>,
    /// How the walls become cells of the grid.
    #[serde(default)]
    wall_model: WallModel,
    /// The signal that the loudspeaker repeats.
    #[serde(default)]
    waveform: WaveformSpec,
    /// Sampling rate of the microphone signal in hertz.
    #[serde(default = "default_sample_rate_hz")]
    sample_rate_hz: f64,
    /// Where loudspeaker and microphone sit on the robot.
    #[serde(default)]
    robot: Robot,
    /// Drives by name (letters, digits, `_` and `-`).
    #[serde(default)]
    paths: BTreeMap<String, PathFile>,
}

/// The air at rest, by its numbers (`c_mps` and `rho_kgpm3`) or by its weather (`temperature_degc` and
/// `relative_humidity_percent`, with `pressure_pa` if it is not the standard atmosphere's), not both.
#[derive(Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Medium")]
struct MediumFile {
    /// Speed of sound in m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64", extend("default" = DEFAULT_MEDIUM.c_mps))]
    c_mps: Option<f64>,
    /// Density in kg/m^3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64", extend("default" = DEFAULT_MEDIUM.rho_kgpm3))]
    rho_kgpm3: Option<f64>,
    /// Temperature in degC, 0 to 30.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    temperature_degc: Option<f64>,
    /// Relative humidity in percent, 0 to 100.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    relative_humidity_percent: Option<f64>,
    /// Pressure in pascals, 60000 to 110000 (default 101325); only with temperature and humidity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    pressure_pa: Option<f64>,
}

/// The medium of a scene that says nothing about it.
const DEFAULT_MEDIUM: Medium = Medium {
    c_mps: 340.0,
    rho_kgpm3: 1.293,
};

/// Size and step of the grid; the domain is `[0, nx dx] x [0, ny dx]` and includes the absorbing layer.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Grid")]
struct GridFile {
    /// Cells along x.
    nx: usize,
    /// Cells along y.
    ny: usize,
    /// Cell width in metres.
    dx_m: f64,
    /// Time step in seconds.
    dt_s: f64,
}

fn default_medium() -> MediumFile {
    MediumFile {
        c_mps: Some(DEFAULT_MEDIUM.c_mps),
        rho_kgpm3: Some(DEFAULT_MEDIUM.rho_kgpm3),
        ..MediumFile::default()
    }
}

fn default_layer_cells() -> usize {
    20
}

fn default_scheme() -> Scheme {
    Scheme::M13
}

fn default_spread() -> Spread {
    Spread::Kaiser12
}

fn default_sample_rate_hz() -> f64 {
    40e3
}

impl SceneFile {
    /// Parses the text; the error names the field's path and place in the text.
    pub(super) fn parse(text: &str, origin: &Path) -> Result<Self, Error> {
        // Editors of some systems put a byte order mark before the text.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let describe = |error: serde_json::Error| describe(text, &error, origin);
        let file: Self = serde_json::from_str(text).map_err(describe)?;
        // A structure is read from an array too, field by field, and [] would be one of defaults.
        let given: Value = serde_json::from_str(text).map_err(describe)?;
        let read = serde_json::to_value(&file).unwrap_or_default();
        match array_for_object(&given, &read) {
            None => Ok(file),
            Some(path) => {
                let field = match path.as_str() {
                    "" => "the scene",
                    path => path,
                };
                let remedy = "see docs/reference/scene.md for the fields of a scene";
                Err(Error::invalid(
                    origin.display(),
                    field,
                    "is an array; give an object",
                    remedy,
                ))
            }
        }
    }

    /// Builds the scene; only what concerns a single path is checked here, see [`Scene::check`] for the rest.
    pub(super) fn into_scene(self, origin: &Path) -> Result<Scene, Error> {
        let mut paths = BTreeMap::new();
        for (name, path) in self.paths {
            let path = path.into_path(&name, origin)?;
            paths.insert(name, path);
        }
        let (medium, air) = self.medium.resolve(&origin.display().to_string())?;
        let characteristic_pasm = medium.rho_kgpm3 * medium.c_mps;
        let mut walls = Vec::new();
        for (index, wall) in self.walls.into_iter().enumerate() {
            let wall = wall.into_wall(characteristic_pasm);
            walls.push(wall.map_err(|[field, problem, remedy]| {
                let field = format!("walls[{index}].{field}");
                Error::invalid(origin.display(), field, problem, remedy)
            })?);
        }
        Ok(Scene {
            name: self.name,
            description: self.description,
            medium,
            air,
            grid: Grid {
                nx: self.grid.nx,
                ny: self.grid.ny,
                dx_m: self.grid.dx_m,
                dt_s: self.grid.dt_s,
            },
            layer_cells: self.layer_cells,
            scheme: self.scheme,
            spread: self.spread,
            walls,
            wall_model: self.wall_model,
            waveform: self.waveform,
            sample_rate_hz: self.sample_rate_hz,
            robot: self.robot,
            paths,
        })
    }
}

/// Path of the first array of a text that was read as an object.
fn array_for_object(given: &Value, read: &Value) -> Option<String> {
    let deeper = |key: &str, given, read| {
        let path = array_for_object(given, read)?;
        let dot = if path.is_empty() || path.starts_with('[') {
            ""
        } else {
            "."
        };
        Some(format!("{key}{dot}{path}"))
    };
    match (given, read) {
        (Value::Array(_), Value::Object(_)) => Some(String::new()),
        (Value::Array(given), Value::Array(read)) => (given.iter().zip(read).enumerate())
            .find_map(|(index, (given, read))| deeper(&format!("[{index}]"), given, read)),
        (Value::Object(given), Value::Object(read)) => {
            (given.iter()).find_map(|(key, given)| deeper(key, given, read.get(key)?))
        }
        _ => None,
    }
}

impl MediumFile {
    /// The medium, and the air behind it where it is given by its weather.
    fn resolve(self, origin: &str) -> Result<(Medium, Option<Air>), Error> {
        let refuse = |problem: &str| {
            let remedy = "give `temperature_degc` and `relative_humidity_percent` (and `pressure_pa`), \
                          or `c_mps` and `rho_kgpm3`";
            Err(Error::invalid(origin, "medium", problem, remedy))
        };
        let plain = self.c_mps.is_some() || self.rho_kgpm3.is_some();
        match (self.temperature_degc, self.relative_humidity_percent) {
            (None, None) if self.pressure_pa.is_some() => {
                refuse("`pressure_pa` needs temperature and humidity")
            }
            (None, None) => Ok((
                Medium {
                    c_mps: self.c_mps.unwrap_or(DEFAULT_MEDIUM.c_mps),
                    rho_kgpm3: self.rho_kgpm3.unwrap_or(DEFAULT_MEDIUM.rho_kgpm3),
                },
                None,
            )),
            _ if plain => {
                refuse("speed of sound or density stands beside the weather they follow from")
            }
            (Some(_), None) => refuse("`relative_humidity_percent` is missing"),
            (None, Some(_)) => refuse("`temperature_degc` is missing"),
            (Some(temperature_degc), Some(relative_humidity_percent)) => {
                let air = Air {
                    temperature_degc,
                    relative_humidity_percent,
                    pressure_pa: self.pressure_pa.unwrap_or(STANDARD_PRESSURE_PA),
                };
                air.check(origin, "medium.")?;
                Ok((air.medium(), Some(air)))
            }
        }
    }
}
