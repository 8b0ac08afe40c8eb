//! Specification of a simulated recording: drive, engine and their options.

use clap::ValueEnum;
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::walls::WallModel;
use serde::{Deserialize, Serialize};

/// Steady error of the odometry's turn rate in the paper's simulation, rad/s.
pub const ODOMETRY_BIAS_RADPS: f64 = 0.01;

/// Default of the most reflections of an image source's echo: those that the paper's Fig. 8 shows.
pub const IMAGE_ORDER: u8 = 2;

/// Engine that computes the sound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Engine {
    /// The sound field by finite differences.
    Fdtd,
    /// Image sources: seconds instead of minutes, without diffraction.
    ImageSource,
}

impl Engine {
    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fdtd => "fdtd",
            Self::ImageSource => "image-source",
        }
    }
}

/// Specification of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingSpec {
    /// Drive path of the scene.
    pub path: String,
    /// Engine that computes the sound.
    pub engine: Engine,
    /// Most reflections of an image source's echo; the field has all of them.
    pub image_order: usize,
    /// Scheme of the field; the scene's when absent.
    pub scheme: Option<Scheme>,
    /// Spreading of source and receiver; the scene's when absent.
    pub spread: Option<Spread>,
    /// With the source strength multiplied by the time since the middle of the drive; see [`fdtd::medium::absorbed`].
    pub stamped: bool,
    /// How walls become cells of the field; the scene's way when absent.
    pub wall_model: Option<WallModel>,
    /// Without walls: the direct wave alone.
    pub free_field: bool,
    /// With the air beyond walls and drive, which changes no sample of the microphone; see
    /// [`fdtd::simulation::SimulationOptions`].
    pub whole_domain: bool,
    /// Steady error of the odometry's turn rate, rad/s.
    pub odometry_bias_radps: f64,
}

impl RecordingSpec {
    /// The recording of a path with the scene's own choices.
    pub fn of(path: &str, engine: Engine) -> Self {
        Self {
            path: path.to_string(),
            engine,
            image_order: usize::from(IMAGE_ORDER),
            scheme: None,
            spread: None,
            stamped: false,
            wall_model: None,
            free_field: false,
            whole_domain: false,
            odometry_bias_radps: ODOMETRY_BIAS_RADPS,
        }
    }

    /// The same with the source strength multiplied by the time of emission.
    pub fn stamped(&self) -> Self {
        Self {
            stamped: true,
            ..self.clone()
        }
    }

    /// The same without walls.
    pub fn in_free_field(&self) -> Self {
        Self {
            free_field: true,
            ..self.clone()
        }
    }
}
