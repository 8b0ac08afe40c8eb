//! Map folders: `map.npy`, `map_toa.npy`, `map.json`, and the pair `map.yaml`, `map.pgm` that a ROS map server reads.

use std::hash::Hasher;
use std::path::Path;

use fnv::FnvHasher;
use ndarray::{Array2, ArrayView2, s};
use ndarray_npy::{ReadNpyExt, ViewNpyError, ViewNpyExt, WriteNpyExt};
use serde::{Deserialize, Serialize};

use super::{files, json};
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
        let bytes = |name: &str| {
            let path = folder.join(name);
            std::fs::read(&path).map_err(|source| Error::io(path, source))
        };
        let path = folder.join("map.json");
        let header = files::read_text(&path)?;
        let layers = [bytes("map.npy")?, bytes("map_toa.npy")?];
        Self::from_bytes(&header, layers.each_ref().map(Vec::as_slice), folder)
    }

    /// Reads the text of `map.json` and the bytes of `map.npy` and `map_toa.npy`; errors name them in `folder`.
    ///
    /// # Errors
    /// As [`MapImage::read`], but for a missing file.
    pub fn from_bytes(header: &str, layers: [&[u8]; 2], folder: &Path) -> Result<Self, Error> {
        let path = folder.join("map.json");
        let refuse = |field: &str, problem: &str| {
            Error::invalid(
                path.display(),
                field,
                problem,
                "make the map anew with the command `map`",
            )
        };
        let header: MapHeader =
            json::parse(header).map_err(|(field, problem)| refuse(&field, &problem))?;
        header
            .parameters
            .check_of_map()
            .map_err(|error| refuse("parameters", &error.to_string()))?;
        if (header.cell_m - header.parameters.measurement.cell_m).abs() > 1e-9 {
            return Err(refuse("cell_m", "is not that of parameters"));
        }
        if header
            .origin_cell
            .iter()
            .any(|cell| cell.unsigned_abs() > 1 << 40)
        {
            return Err(refuse("origin_cell", "is out of any room"));
        }
        let map = Self {
            origin_cell: header.origin_cell,
            cell_m: header.cell_m,
            intensity: parse_npy(layers[0], &folder.join("map.npy"))?,
            toa_only: parse_npy(layers[1], &folder.join("map_toa.npy"))?,
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

/// Where the header of an NPY file ends, by its own length; `None` when it is no such file.
fn header_end(bytes: &[u8]) -> Option<u64> {
    let (version, rest) = bytes.strip_prefix(b"\x93NUMPY")?.split_first_chunk::<2>()?;
    // Version 1 has a length of two bytes, later ones of four.
    let (start, length) = match version[0] {
        1 => (10, u64::from(u16::from_le_bytes(*rest.first_chunk()?))),
        _ => (12, u64::from(u32::from_le_bytes(*rest.first_chunk()?))),
    };
    Some(start + length)
}

/// Reads the bytes of a two-dimensional NPY file; errors name `origin`.
///
/// # Errors
/// [`Error::Invalid`] when they are something else, or another number of bytes than the header says.
pub fn parse_npy(bytes: &[u8], origin: &Path) -> Result<Array2<f32>, Error> {
    let refuse = |problem: String| {
        let remedy = "give a two-dimensional array of 32-bit floats";
        Error::invalid(origin.display(), "array", json::one_line(&problem), remedy)
    };
    // Its reader asks for the memory of the header before it looks whether the file is as long.
    if header_end(bytes).is_none_or(|end| end > bytes.len() as u64) {
        return Err(refuse("is no NPY file, or is cut short".to_string()));
    }
    ArrayView2::<f32>::view_npy(bytes)
        .map(|layer| layer.to_owned())
        .or_else(|problem| match problem {
            // The bytes of a file need not be aligned in memory; their number is the header's all the same.
            ViewNpyError::MisalignedData => {
                Array2::<f32>::read_npy(bytes).map_err(|problem| refuse(problem.to_string()))
            }
            problem => Err(refuse(problem.to_string())),
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
    fn a_header_longer_than_its_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        map().write(folder.path()).unwrap();
        let mut bytes = std::fs::read(folder.path().join("map.npy")).unwrap();
        let origin = Path::new("map.npy");
        assert_eq!(parse_npy(&bytes, origin).unwrap(), map().intensity);
        // Version 2, whose length has four bytes: 3 GB.
        bytes[6] = 2;
        bytes[8..12].copy_from_slice(&3_212_509_302_u32.to_le_bytes());
        for bytes in [&bytes[..], b"", b"\x93NUMPY", b"\x93NUMPY\x01\0\xff\xff"] {
            let message = parse_npy(bytes, origin).unwrap_err().to_string();
            assert!(
                message.contains("map.npy") && message.contains("cut short"),
                "{message}"
            );
        }
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
