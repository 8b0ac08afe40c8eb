//! Options of a run.

use std::path::PathBuf;

use localizer::Parameters;

use crate::recordings::spec::Engine;
use crate::run::preset::Preset;

/// Options of a run.
#[derive(Debug, Clone)]
pub struct Request {
    /// The preset.
    pub preset: Preset,
    /// Folder of the results; the preset's folder is below it.
    pub results: PathBuf,
    /// Folder of the cache.
    pub cache: PathBuf,
    /// Engine that computes the sound.
    pub engine: Engine,
    /// Most reflections of an image source's echo.
    pub image_order: usize,
    /// Parameters of the localizer where the preset does not set them.
    pub parameters: Parameters,
    /// Simulations side by side; `None` measures which number is faster.
    pub side_by_side: Option<usize>,
}
