//! A scene in memory.

use crate::error::Error;
use crate::grid::{Grid, Medium};
use crate::medium::Air;
use crate::motion::DrivePath;
use crate::scheme::Scheme;
use crate::spread::Spread;
use crate::walls::{Wall, WallModel};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Fewest cells of the absorbing layer.
pub const MIN_LAYER_CELLS: usize = 8;
/// Fewest cells per wavelength at the upper edge of the band.
pub const MIN_CELLS_PER_WAVELENGTH: f64 = 3.0;
/// Fewest cells across a wall; thinner ones could leak between two cells that touch at a corner.
pub const MIN_WALL_CELLS: f64 = 2.0;

/// Everything that determines a sound field but the choice of the drive.
///
/// A scene from [`Scene::load`] or [`Scene::from_json`] has passed [`Scene::check`]; after changing a field, check
/// again.
///
/// ```
/// use fdtd::scene::Scene;
///
/// let text = r#"{
///     "name": "one wall",
///     "grid": { "nx": 300, "ny": 200, "dx_m": 0.005, "dt_s": 8e-6 },
///     "walls": [{ "points_m": [[0.3, 0.7], [1.2, 0.7]], "thickness_m": 0.02 }]
/// }"#;
/// let scene = Scene::from_json(text, "wall.json".as_ref())?;
/// assert_eq!(scene.medium.c_mps, 340.0);
/// assert!(scene.grid.dt_s < scene.largest_stable_step_s());
///
/// let error = Scene::from_json(&text.replace("8e-6", "8e-5"), "wall.json".as_ref()).unwrap_err();
/// assert!(error.to_string().starts_with("wall.json: grid.dt_s"));
/// # Ok::<(), fdtd::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Scene {
    /// Short name, for titles.
    pub name: String,
    /// Description of the scene in a sentence or two.
    pub description: String,
    /// The medium of the field.
    pub medium: Medium,
    /// The air that `medium` follows from, where the scene gives its weather; the absorption needs it.
    pub air: Option<Air>,
    /// Size and step of the grid.
    pub grid: Grid,
    /// Width of the absorbing layer on each of the four sides, in cells.
    pub layer_cells: usize,
    /// Finite-difference scheme.
    pub scheme: Scheme,
    /// Spreading of the moving source and interpolation at the moving receiver.
    pub spread: Spread,
    /// Rigid walls.
    pub walls: Vec<Wall>,
    /// How the walls become cells of the grid.
    pub wall_model: WallModel,
    /// The signal that the loudspeaker repeats.
    pub waveform: WaveformSpec,
    /// Sampling rate of the microphone signal in hertz.
    pub sample_rate_hz: f64,
    /// Where loudspeaker and microphone sit on the robot.
    pub robot: Robot,
    /// Drives by name.
    pub paths: BTreeMap<String, DrivePath>,
}

/// Parameters of the phase-modulated M-sequence and the band it is limited to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WaveformSpec {
    /// Chips of the M-sequence, 2^n - 1.
    pub code_length: u32,
    /// Chips per second.
    pub chip_rate_hz: f64,
    /// Carrier frequency in hertz.
    pub carrier_hz: f64,
    /// Band `[lower edge, upper edge]` in hertz that the loudspeaker emits; the 1 kHz inside an edge is a taper. A
    /// lower edge of 0 means no lower edge.
    pub band_hz: [f64; 2],
}

impl Default for WaveformSpec {
    /// Table I of the paper, to 19 kHz.
    fn default() -> Self {
        Self {
            code_length: 1023,
            chip_rate_hz: 10e3,
            carrier_hz: 10e3,
            band_hz: [0.0, 19e3],
        }
    }
}

impl WaveformSpec {
    /// Length of one period of the M-sequence in seconds.
    pub fn period_s(&self) -> f64 {
        f64::from(self.code_length) / self.chip_rate_hz
    }
}

/// The robot's transducers, `[forward, left]` of its centre in metres.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Robot {
    /// The loudspeaker's place in metres, `[forward, left]` of the robot's centre.
    pub loudspeaker_offset_m: [f64; 2],
    /// The microphone's place in metres, `[forward, left]` of the robot's centre.
    pub microphone_offset_m: [f64; 2],
}

impl Scene {
    /// The drive with this name.
    ///
    /// # Errors
    /// [`Error::Invalid`] that lists the names there are.
    pub fn path(&self, name: &str) -> Result<&DrivePath, Error> {
        self.paths.get(name).ok_or_else(|| {
            let names: Vec<&str> = self.paths.keys().map(String::as_str).collect();
            let remedy = match names.as_slice() {
                [] => "the scene has no paths; add one".to_string(),
                names => format!("choose one of: {}", names.join(", ")),
            };
            Error::invalid(
                format!("scene '{}'", self.name),
                "paths",
                format!("there is no path {name:?}"),
                remedy,
            )
        })
    }

    /// Largest step in seconds at which the scene's scheme is stable.
    pub fn largest_stable_step_s(&self) -> f64 {
        self.scheme.max_courant() * self.grid.dx_m / self.medium.c_mps
    }

    /// How many cells around the cells next to the loudspeaker or microphone must be free of walls: the
    /// kernel's reach and the scheme's radius.
    pub fn reach_cells(&self) -> usize {
        self.spread.reach_cells() + self.scheme.radius()
    }
}
