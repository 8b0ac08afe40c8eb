//! A scene: medium, grid, walls, waveform, robot and its drives, read from JSON and checked once.

mod check;
mod clearance;
mod code;
mod file;
mod locate;
mod model;
mod path_file;
pub mod random;
mod wall_file;

pub use model::{
    MIN_CELLS_PER_WAVELENGTH, MIN_LAYER_CELLS, MIN_WALL_CELLS, Robot, Scene, WaveformSpec,
};
pub use random::LayoutKind;

use crate::error::Error;
use std::path::Path;

impl Scene {
    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// [`Error::Io`] when a file cannot be read, [`Error::Invalid`] naming the file and the field otherwise.
    pub fn load(file: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(file).map_err(|source| Error::io(file, source))?;
        Self::from_json(&text, file)
    }

    /// Reads and checks a scene from the text of a scene file. `origin` is the file it came from: errors name it, and
    /// the pose files of paths are looked up beside it.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_json(text: &str, origin: &Path) -> Result<Self, Error> {
        let scene = file::SceneFile::parse(text, origin)?.into_scene(origin)?;
        scene.check(&origin.display().to_string())?;
        Ok(scene)
    }

    /// Refuses a scene that cannot be simulated faithfully: an unstable step, too few cells per wavelength, walls or
    /// paths outside the domain, in the absorbing layer or too near each other, more memory than the machine has,
    /// numbers out of range.
    ///
    /// Call it again after changing a field, for example the scheme.
    ///
    /// # Errors
    /// [`Error::Invalid`] with `origin`, the field's path, the problem and the accepted values.
    pub fn check(&self, origin: &str) -> Result<(), Error> {
        check::check(self, origin)?;
        clearance::check(self, origin)
    }

    /// The JSON schema of scene files.
    pub fn json_schema() -> serde_json::Value {
        schemars::schema_for!(file::SceneFile).to_value()
    }
}
