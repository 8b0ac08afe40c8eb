//! Map folders: `map.npy`, `map_toa.npy`, `map.json`, and the pair `map.yaml`, `map.pgm` that a ROS map server reads.

use std::hash::Hasher;
use std::path::Path;

use fnv::FnvHasher;
use ndarray::{Array2, ArrayView2, s};
use ndarray_npy::{ReadNpyExt, WriteNpyExt};
use serde::{Deserialize, Serialize};

use super::files;
use crate::error::Error;
use crate::image::map_image::MapImage;
use crate::parameters::Parameters;

/// The content of `map.json`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MapHeader {
    /// World cell number of the first cell.
    origin_cell: [i64; 2],
    /// Centre of the first cell, for readers of the file.
    origin_m: [f64; 2],
    cell_m: f64,
    /// FNV-1a of shape and values of both layers; reveals a mixed-up or damaged folder.
    hash: String,
    parameters: Parameters,
}

impl MapImage {
    /// Writes a map folder, making it if necessary. Every file is written under a temporary name and renamed.
    ///
    /// # Errors
    /// [`Error`] when a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        files::make_folder(folder)?;
        write_npy(&folder.join("map.npy"), &self.intensity)?;
        write_npy(&folder.join("map_toa.npy"), &self.toa_only)?;
        let [rows, columns] = heard(&self.intensity);
        let picture = self
            .intensity
            .slice(s![rows[0]..rows[1], columns[0]..columns[1]]);
        files::write_bytes(&folder.join("map.pgm"), &occupancy_picture(picture))?;
        // A map server's origin is the lower left corner of the lower left cell.
        let corner = [columns[0], rows[0]].map(|cell| cell as f64 - 0.5);
        let origin = self.origin_m();
        let [x_m, y_m] = [0, 1].map(|axis| origin[axis] + self.cell_m * corner[axis]);
        let yaml = format!(
            "image: map.pgm\nresolution: {:.6}\norigin: [{x_m:.6}, {y_m:.6}, 0.0]\n\
             negate: 0\noccupied_thresh: 0.5\nfree_thresh: 0.2\n",
            self.cell_m
        );
        files::write_bytes(&folder.join("map.yaml"), yaml.as_bytes())?;
        let header = MapHeader {
            origin_cell: self.origin_cell,
            origin_m: self.origin_m(),
            cell_m: self.cell_m,
            hash: hash(self),
            parameters: self.parameters.clone(),
        };
        files::write_json(&folder.join("map.json"), &header)
    }

    /// Reads a map folder; the ROS pair is not needed.
    ///
    /// # Errors
    /// [`Error`] when a file is missing or damaged or the files do not belong together.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        let path = folder.join("map.json");
        let header: MapHeader = files::read_json(&path)?;
        let refuse = |field: &str, problem: &str| {
            Error::invalid(
                path.display(),
                field,
                problem,
                "make the map anew with the command `map`",
            )
        };
        if !(header.cell_m.is_finite() && header.cell_m > 0.0) {
            return Err(refuse("cell_m", "is not a positive number"));
        }
        if header.origin_cell.iter().any(|cell| cell.abs() > 1 << 40) {
            return Err(refuse("origin_cell", "is out of any room"));
        }
        header.parameters.check()?;
        let map = Self {
            origin_cell: header.origin_cell,
            cell_m: header.cell_m,
            intensity: read_npy(&folder.join("map.npy"))?,
            toa_only: read_npy(&folder.join("map_toa.npy"))?,
            parameters: header.parameters,
        };
        if hash(&map) != header.hash {
            return Err(refuse(
                "hash",
                "map.npy and map_toa.npy are not those of this map.json",
            ));
        }
        if map.intensity.dim() != map.toa_only.dim() {
            return Err(refuse("hash", "map.npy and map_toa.npy differ in shape"));
        }
        if map
            .intensity
            .iter()
            .chain(&map.toa_only)
            .any(|value| !value.is_finite() || *value < 0.0)
        {
            return Err(refuse(
                "hash",
                "the map has values that are negative or not finite",
            ));
        }
        Ok(map)
    }
}

fn write_npy(path: &Path, layer: &Array2<f32>) -> Result<(), Error> {
    let mut bytes = Vec::with_capacity(4 * layer.len() + 128);
    layer
        .write_npy(&mut bytes)
        .map_err(|problem| Error::invalid(path.display(), "array", problem, "report this"))?;
    files::write_bytes(path, &bytes)
}

fn read_npy(path: &Path) -> Result<Array2<f32>, Error> {
    let bytes = std::fs::read(path).map_err(|source| Error::io(path, source))?;
    Array2::<f32>::read_npy(bytes.as_slice()).map_err(|problem| {
        Error::invalid(
            path.display(),
            "array",
            problem,
            "give a two-dimensional array of 32-bit floats",
        )
    })
}

fn hash(map: &MapImage) -> String {
    let mut hasher = FnvHasher::default();
    for layer in [&map.intensity, &map.toa_only] {
        hasher.write(&(layer.nrows() as u64).to_le_bytes());
        for value in layer {
            hasher.write(&value.to_le_bytes());
        }
    }
    format!("{:016x}", hasher.finish())
}

/// Share of the brightest cell from which on a cell was heard.
const HEARD: f32 = 0.3;

/// Cells kept around what was heard.
const AROUND: usize = 5;

/// First and last row, and column, of what was heard; all of a map in which nothing stands out.
fn heard(layer: &Array2<f32>) -> [[usize; 2]; 2] {
    let least = HEARD * layer.iter().copied().fold(0.0_f32, f32::max);
    let (rows, columns) = layer.dim();
    let bright = layer.indexed_iter().filter(|(_, value)| **value >= least);
    let ends = bright.fold([[rows, 0], [columns, 0]], |[y, x], ((row, column), _)| {
        [
            [y[0].min(row), y[1].max(row + 1)],
            [x[0].min(column), x[1].max(column + 1)],
        ]
    });
    [(ends[0], rows), (ends[1], columns)].map(|([first, last], size)| match first < last {
        true => [first.saturating_sub(AROUND), (last + AROUND).min(size)],
        false => [0, size],
    })
}

/// A binary PGM, dark where the map is bright, upper row first.
fn occupancy_picture(layer: ArrayView2<'_, f32>) -> Vec<u8> {
    let largest = layer.iter().copied().fold(0.0_f32, f32::max);
    let scale = if largest > 0.0 { 255.0 / largest } else { 0.0 };
    let mut bytes = format!("P5\n{} {}\n255\n", layer.ncols(), layer.nrows()).into_bytes();
    for row in layer.rows().into_iter().rev() {
        bytes.extend(
            row.iter()
                .map(|value| 255 - (value * scale).round().clamp(0.0, 255.0) as u8),
        );
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> MapImage {
        MapImage {
            origin_cell: [-3, 5],
            cell_m: 0.1,
            intensity: Array2::from_shape_fn((4, 6), |(row, column)| (row * 6 + column) as f32),
            toa_only: Array2::from_elem((4, 6), 0.5),
            parameters: Parameters::default(),
        }
    }

    #[test]
    fn a_folder_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        map().write(folder.path()).unwrap();
        assert_eq!(MapImage::read(folder.path()).unwrap(), map());
        let yaml = std::fs::read_to_string(folder.path().join("map.yaml")).unwrap();
        assert!(
            yaml.contains("origin: [-0.350000, 0.450000, 0.0]"),
            "{yaml}"
        );
        let picture = std::fs::read(folder.path().join("map.pgm")).unwrap();
        assert!(picture.starts_with(b"P5\n6 4\n255\n"));
        // The last map row, with the largest value at its right end, comes first.
        assert_eq!(picture[11 + 5], 0);
        assert_eq!(picture[11 + 18], 255);
    }

    #[test]
    fn mixed_up_folders_are_noticed() {
        let folder = tempfile::tempdir().unwrap();
        assert!(
            MapImage::read(folder.path())
                .unwrap_err()
                .to_string()
                .contains("map.json")
        );
        map().write(folder.path()).unwrap();
        write_npy(&folder.path().join("map.npy"), &Array2::zeros((4, 6))).unwrap();
        assert!(
            MapImage::read(folder.path())
                .unwrap_err()
                .to_string()
                .contains("hash")
        );
        std::fs::write(folder.path().join("map.npy"), b"no array").unwrap();
        assert!(
            MapImage::read(folder.path())
                .unwrap_err()
                .to_string()
                .contains("map.npy")
        );
    }
}
