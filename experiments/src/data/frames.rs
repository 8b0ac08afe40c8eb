//! What was heard and believed in the course of a drive, for its replay: `replay.json`.

use std::path::Path;

use anyhow::Result;
use base64::prelude::{BASE64_STANDARD, Engine};
use localizer::echo::EchoBlock;
use localizer::landmarks::LandmarkMap;
use localizer::{MapImage, Parameters, Pose};
use serde::{Deserialize, Serialize};

use super::atomic;
use crate::metrics::rounded;

/// Name of the file in the data of a study.
pub const FRAMES: &str = "replay.json";

/// Most frames of a drive, ranges of an echo image, and poses of a frame: a page is to stay small.
const MOST_FRAMES: f64 = 250.0;
const RANGES: usize = 64;
const MOST_POSES: usize = 60;
/// Decibels below the strongest echo of a block at which an echo image ends.
const DEPTH_DB: f32 = 30.0;

/// Echo images, possible poses and known landmarks at some instants of a drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frames {
    /// The method that heard and believed it.
    pub(crate) method: String,
    /// Instants in seconds.
    t_s: Vec<f64>,
    /// Largest range of the echo images in metres.
    pub(crate) reach_m: f64,
    /// Size of an echo image.
    directions: usize,
    ranges: usize,
    /// The echo images: a byte for each direction, from ahead to behind, and range, from near to far. The strongest
    /// echo of a block is 255, what is 30 dB below it 0; blocks without bearings are all 0. In base64.
    echoes: String,
    /// x and y of possible poses in metres.
    poses: Vec<Vec<[f64; 2]>>,
    /// Landmarks from an instant on.
    landmarks: Vec<Landmarks>,
    /// The map image under the paths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    picture: Option<Picture>,
    #[serde(skip)]
    bytes: Vec<u8>,
    /// Blocks from one frame to the next, and blocks so far.
    #[serde(skip)]
    every: usize,
    #[serde(skip)]
    blocks: usize,
}

/// Pixels of a map under the walls.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Picture {
    /// Edge with the least x and y, and size, in metres.
    low_m: [f64; 2],
    size_m: [f64; 2],
    columns: usize,
    rows: usize,
    /// A byte for each cell, the row of the least y first, in base64.
    cells: String,
}

/// Landmarks that are known from an instant on, without mirror images.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Landmarks {
    t_s: f64,
    /// Ends of walls, and points, in metres.
    walls: Vec<[[f64; 2]; 2]>,
    points: Vec<[f64; 2]>,
}

impl Frames {
    /// None yet, of a drive of a duration by a method.
    pub fn new(method: &str, parameters: &Parameters, duration_s: f64) -> Self {
        let blocks = duration_s / parameters.period_s();
        Self {
            method: method.to_string(),
            t_s: Vec::new(),
            reach_m: parameters.measurement.max_range_m,
            directions: parameters.measurement.directions + 1,
            ranges: RANGES,
            echoes: String::new(),
            poses: Vec::new(),
            landmarks: Vec::new(),
            picture: None,
            bytes: Vec::new(),
            every: (blocks / MOST_FRAMES).ceil().max(1.0) as usize,
            blocks: 0,
        }
    }

    /// Adds a block and the poses that are possible after it.
    pub fn add(&mut self, block: &EchoBlock, poses: &[Pose]) {
        self.blocks += 1;
        if !(self.blocks - 1).is_multiple_of(self.every) {
            return;
        }
        self.t_s.push(rounded(block.t_s));
        self.bytes.extend(image(block));
        let step = poses.len().div_ceil(MOST_POSES).max(1);
        let places = poses.iter().step_by(step);
        self.poses.push(
            places
                .map(|pose| [pose.x_m, pose.y_m].map(to_millimetres))
                .collect(),
        );
    }

    /// Says which landmarks are known from an instant on.
    pub fn know(&mut self, t_s: f64, map: &LandmarkMap) {
        let place = |place: [f64; 2]| place.map(to_millimetres);
        let mut known = Landmarks {
            t_s,
            walls: Vec::new(),
            points: Vec::new(),
        };
        for landmark in map.landmarks.iter().filter(|own| !map.is_image(own)) {
            match landmark.ends_m() {
                Some(ends) => known.walls.push(ends.map(place)),
                None => known.points.extend(landmark.middle_m().map(place)),
            }
        }
        let same =
            |before: &Landmarks| (&before.walls, &before.points) == (&known.walls, &known.points);
        if !self.landmarks.last().is_some_and(same) {
            self.landmarks.push(known);
        }
    }

    /// Whether no landmark was ever known.
    pub fn knows_nothing(&self) -> bool {
        self.landmarks.is_empty()
    }

    /// Puts a map's image under the paths: 255 is the cell from which most comes.
    pub fn put_map(&mut self, map: &MapImage) {
        let layer = &map.intensity;
        let largest = layer.iter().copied().fold(0.0_f32, f32::max).max(1e-12);
        let (rows, columns) = layer.dim();
        let cells: Vec<u8> = (layer.iter())
            .map(|&value| (255.0 * value / largest) as u8)
            .collect();
        self.picture = Some(Picture {
            low_m: map
                .origin_m()
                .map(|first| rounded(first - 0.5 * map.cell_m)),
            size_m: [columns, rows].map(|cells| rounded(cells as f64 * map.cell_m)),
            columns,
            rows,
            cells: BASE64_STANDARD.encode(cells),
        });
    }

    /// Writes them.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        atomic::write(path, serde_json::to_string(self)?.as_bytes())
    }

    /// All of them, ready to be written.
    pub fn finish(mut self) -> Self {
        self.echoes = BASE64_STANDARD.encode(std::mem::take(&mut self.bytes));
        self
    }
}

/// Rounds metres to millimetres.
fn to_millimetres(metres: f64) -> f64 {
    (1e3 * metres).round() / 1e3
}

/// The echo image of a block as bytes.
fn image(block: &EchoBlock) -> Vec<u8> {
    let delays = block.intensity.ncols();
    let strongest = match block.stationary {
        true => 0.0,
        false => block.intensity.iter().copied().fold(0.0_f32, f32::max),
    };
    let byte = |value: f32| {
        if strongest <= 0.0 || value <= 0.0 {
            return 0;
        }
        let down_db = 20.0 * (value / strongest).log10();
        (255.0 * (1.0 + down_db / DEPTH_DB).max(0.0)).round() as u8
    };
    let mut bytes = Vec::with_capacity(block.intensity.nrows() * RANGES);
    for row in block.intensity.rows() {
        // The strongest of the delays that share a range.
        bytes.extend((0..RANGES).map(|range| {
            let [from, to] = [range, range + 1].map(|edge| edge * delays / RANGES);
            let delays = row.slice(ndarray::s![from..to.max(from + 1).min(delays)]);
            byte(delays.iter().copied().fold(0.0_f32, f32::max))
        }));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use localizer::Odometry;
    use ndarray::Array2;

    #[test]
    fn an_echo_stands_at_its_direction_and_range_and_frames_are_few() {
        let parameters = Parameters::default();
        let (rows, delays) = (parameters.measurement.directions + 1, parameters.delays());
        let mut block = EchoBlock {
            index: 0,
            t_s: 0.5,
            odometry: Odometry::default(),
            stationary: false,
            intensity: Array2::zeros((rows, delays)),
            toa_intensity: vec![0.0; delays],
        };
        block.intensity[[3, delays / 2]] = 2.0;
        block.intensity[[7, delays - 1]] = 0.2;
        let bytes = image(&block);
        assert_eq!(bytes.len(), rows * RANGES);
        assert_eq!(bytes[3 * RANGES + RANGES / 2], 255);
        // 20 of 30 dB below.
        assert_eq!(bytes[7 * RANGES + RANGES - 1], 85);
        assert_eq!(bytes.iter().filter(|&&byte| byte > 0).count(), 2);
        block.stationary = true;
        assert!(image(&block).iter().all(|&byte| byte == 0));

        let mut frames = Frames::new("doppler", &parameters, 3600.0);
        let poses = vec![Pose::default(); 1000];
        for _ in 0..(3600.0 / parameters.period_s()) as usize {
            frames.add(&block, &poses);
        }
        assert!(
            (150..=250).contains(&frames.t_s.len()),
            "{}",
            frames.t_s.len()
        );
        assert!(frames.poses.iter().all(|poses| poses.len() <= MOST_POSES));
        let text = serde_json::to_string(&frames.finish()).unwrap();
        assert!(text.len() < 4 << 20, "{} bytes", text.len());
    }
}
