//! Where the pixels of a map image are: the JSON beside its `.npy`.

use std::path::Path;

use anyhow::{Context, Result};
use ndarray::Array2;
use serde::{Deserialize, Serialize};

use super::json;

/// Positions of the pixels of a map image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct MapPlace {
    /// Centre of the pixel at row 0, column 0, metres.
    pub(crate) origin_m: [f64; 2],
    /// Width of a pixel, metres.
    pub(crate) cell_m: f64,
}

impl MapPlace {
    /// Reads a map image `[iy, ix]` and the place of its pixels, `NAME.npy` and `NAME.json` of a data folder.
    ///
    /// # Errors
    /// When a file is missing or damaged.
    pub(crate) fn read(data: &Path, name: &str) -> Result<(Array2<f32>, Self)> {
        let image = data.join(format!("{name}.npy"));
        let map = ndarray_npy::read_npy(&image).with_context(|| image.display().to_string())?;
        Ok((map, json::read(&data.join(format!("{name}.json")))?))
    }
}
