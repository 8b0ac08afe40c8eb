//! Arguments that several commands share.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use localizer::Parameters;

use crate::data::json;
use crate::recordings::spec::{Engine, IMAGE_ORDER};

/// Engine that computes the sound.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(super) struct EngineArguments {
    /// Engine: the field, or image sources (approximate, seconds).
    #[arg(long, value_enum, default_value_t = Engine::Fdtd)]
    pub(super) engine: Engine,
    /// Most reflections of an echo by image sources [default: 2].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=6))]
    image_order: Option<u8>,
}

impl EngineArguments {
    /// Most reflections of an image source's echo.
    pub(super) fn image_order(&self) -> Result<usize> {
        if let (Engine::Fdtd, Some(order)) = (self.engine, self.image_order) {
            bail!(
                "--image-order {order}: is for image sources, the field has all reflections; add --engine \
                image-source or leave it out"
            );
        }
        Ok(usize::from(self.image_order.unwrap_or(IMAGE_ORDER)))
    }
}

/// Whether an output may replace what this program did not write.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(super) struct ForceArgument {
    /// Replace a file or folder that this command did not write. Its own inputs, and what is no regular file, are never
    /// replaced.
    #[arg(long)]
    pub(super) force: bool,
}

/// The files that are read of a recording folder.
pub(super) fn files_of_recording(folder: &Path) -> Vec<PathBuf> {
    let names = [
        "recording.json",
        "signal.wav",
        "odometry.csv",
        "truth.tum",
        "direct.wav",
        "transmitted.wav",
        "transmitted.json",
    ];
    names.map(|name| folder.join(name)).to_vec()
}

/// The files that are read of a map folder.
pub(super) fn files_of_map(folder: &Path) -> Vec<PathBuf> {
    let names = ["map.json", "map.npy", "map_toa.npy", "landmarks.json"];
    names.map(|name| folder.join(name)).to_vec()
}

/// Parameters of the localizer.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct ParameterArguments {
    /// JSON file with parameters of the localizer; those it leaves out keep the paper's values.
    #[arg(long, value_name = "FILE")]
    pub(super) parameters: Option<PathBuf>,
}

impl ParameterArguments {
    /// Reads the file, if one was given.
    pub(super) fn read(&self) -> Result<Parameters> {
        let Some(path) = &self.parameters else {
            return Ok(Parameters::default());
        };
        json::read(path)
    }
}

/// More threads than any grid has strips for.
const MOST_THREADS: usize = 1024;

/// Reads a number of threads.
pub(super) fn threads(text: &str) -> Result<usize, String> {
    let threads = text.parse().ok().filter(|&threads| threads <= MOST_THREADS);
    threads.ok_or_else(|| format!("give 0 to {MOST_THREADS}"))
}

/// Reads an argument by its spelling in files (`slf`, `kaiser8`).
pub(super) fn named<T: serde::de::DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_value(serde_json::Value::String(text.to_string()))
        .map_err(|error| error.to_string())
}
