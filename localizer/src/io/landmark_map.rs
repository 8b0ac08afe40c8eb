//! Landmarks in a map folder: `landmarks.json`, the same as `landmarks.geojson` for viewers, and the pair
//! `landmarks.yaml`, `landmarks.pgm` that a ROS map server reads.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{files, json as json_text};
use crate::error::Error;
use crate::landmarks::{Landmark, LandmarkMap, Shape};
use crate::parameters::Parameters;

/// The version of the format that is written and read.
const VERSION: u32 = 1;
/// Most landmarks of a map that is read.
const MOST_LANDMARKS: usize = 10_000;
/// Most bins of a landmark's visibility.
const MOST_BINS: usize = 100_000;
/// Largest coordinate and distance in metres.
const FARTHEST_M: f64 = 1e5;
/// Width of a cell of the occupancy picture in metres.
const CELL_M: f64 = 0.05;
/// Largest side of the occupancy picture in cells.
const MOST_CELLS: f64 = 4000.0;
/// Grey values of the picture: a landmark, and what is not known.
const OCCUPIED: u8 = 0;
const UNKNOWN: u8 = 205;

/// The content of `landmarks.json`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LandmarkFile {
    version: u32,
    /// Least and largest x and y of the poses from which the map was learnt, in metres.
    area_m: [[f64; 2]; 2],
    /// Share of all peaks, while learning, that belong to a landmark.
    explained: f64,
    landmarks: Vec<Landmark>,
    parameters: Parameters,
}

/// What is read before the rest: files of another version may have other fields.
#[derive(Deserialize)]
struct Version {
    version: u32,
}

impl LandmarkMap {
    /// Writes the landmarks into a map folder, making it if necessary. Every file is written under a temporary name
    /// and renamed; files of an image map in the same folder stay.
    ///
    /// # Errors
    /// [`Error`] when a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        files::make_folder(folder)?;
        let (picture, yaml) = self.occupancy();
        files::write_bytes(&folder.join("landmarks.pgm"), &picture)?;
        files::write_bytes(&folder.join("landmarks.yaml"), yaml.as_bytes())?;
        files::write_json(&folder.join("landmarks.geojson"), &self.geojson())?;
        let file = LandmarkFile {
            version: VERSION,
            area_m: self.area_m,
            explained: self.explained,
            landmarks: self.landmarks.clone(),
            parameters: self.parameters.clone(),
        };
        files::write_json(&folder.join("landmarks.json"), &file)
    }

    /// Reads the landmarks of a map folder; the other files are not needed.
    ///
    /// # Errors
    /// [`Error`] when the file is missing, has another version, or holds what cannot be a map.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        let path = folder.join("landmarks.json");
        Self::from_json(&files::read_text(&path)?, &path.display().to_string())
    }

    /// Reads the text of a `landmarks.json`; errors name `origin`.
    ///
    /// # Errors
    /// As [`LandmarkMap::read`], but for a missing file.
    pub fn from_json(text: &str, origin: &str) -> Result<Self, Error> {
        let refuse = |field: String, problem: String| {
            let remedy = "make the map anew with `map --method landmarks`";
            Error::invalid(origin, field, problem, remedy)
        };
        let syntax = |(field, problem)| refuse(field, problem);
        let Version { version } = json_text::parse(text).map_err(syntax)?;
        if version != VERSION {
            let problem = format!("is {version}, this program reads {VERSION}");
            return Err(refuse("version".into(), problem));
        }
        let file: LandmarkFile = json_text::parse(text).map_err(syntax)?;
        file.parameters.check_of_map()?;
        if file.landmarks.is_empty() || file.landmarks.len() > MOST_LANDMARKS {
            let problem = format!("has {} landmarks", file.landmarks.len());
            return Err(refuse("landmarks".into(), problem));
        }
        let near = |number: &f64| number.abs() <= FARTHEST_M;
        let in_order = |[low, high]: &[f64; 2]| near(low) && near(high) && low <= high;
        if !(file.area_m.iter().all(in_order) && (0.0..=1.0).contains(&file.explained)) {
            return Err(refuse(
                "area_m".into(),
                "is not an area, or explained no share".into(),
            ));
        }
        for (index, landmark) in file.landmarks.iter().enumerate() {
            check(landmark)
                .map_err(|problem| refuse(format!("landmarks[{index}]"), problem.into()))?;
        }
        Ok(Self {
            parameters: file.parameters,
            landmarks: file.landmarks,
            area_m: file.area_m,
            explained: file.explained,
        })
    }

    /// The landmarks as GeoJSON in metres of the world frame: walls as lines as long as they were seen, points as
    /// points. Those behind another wall are its mirror images (`"image": true`).
    pub fn geojson(&self) -> Value {
        let features: Vec<Value> = self
            .landmarks
            .iter()
            .map(|landmark| self.feature(landmark))
            .collect();
        json!({"type": "FeatureCollection", "features": features})
    }

    fn feature(&self, landmark: &Landmark) -> Value {
        let (kind, geometry) = match landmark.shape {
            Shape::Wall { .. } => {
                let ends = landmark.ends_m().unwrap_or([[0.0; 2]; 2]);
                ("wall", json!({"type": "LineString", "coordinates": ends}))
            }
            Shape::Point { place_m } => ("point", json!({"type": "Point", "coordinates": place_m})),
        };
        json!({
            "type": "Feature",
            "geometry": geometry,
            "properties": {
                "kind": kind,
                "image": self.is_image(landmark),
                "blocks": landmark.blocks,
                "range_sigma_m": landmark.range_sigma_m,
            },
        })
    }

    /// A picture of what is not an image, and the file that describes it.
    fn occupancy(&self) -> (Vec<u8>, String) {
        let lines: Vec<[[f64; 2]; 2]> = self
            .landmarks
            .iter()
            .filter(|landmark| !self.is_image(landmark))
            .filter_map(Landmark::ends_m)
            .collect();
        let axis = |k: usize| {
            let ends = lines
                .iter()
                .flatten()
                .map(|place| place[k])
                .chain(self.area_m[k]);
            let low = ends.clone().fold(f64::INFINITY, f64::min) - 10.0 * CELL_M;
            let high = ends.fold(f64::NEG_INFINITY, f64::max) + 10.0 * CELL_M;
            let cells = ((high - low) / CELL_M).ceil().clamp(1.0, MOST_CELLS);
            (low, cells as usize)
        };
        let ((x_m, columns), (y_m, rows)) = (axis(0), axis(1));
        let mut cells = vec![UNKNOWN; columns * rows];
        for [from, to] in lines {
            let length_m = (to[0] - from[0]).hypot(to[1] - from[1]);
            let steps = (length_m / (0.5 * CELL_M))
                .ceil()
                .clamp(1.0, 4.0 * MOST_CELLS) as usize;
            for step in 0..=steps {
                let share = step as f64 / steps as f64;
                let at = [0, 1].map(|k| from[k] + share * (to[k] - from[k]));
                let (column, row) = ((at[0] - x_m) / CELL_M, (at[1] - y_m) / CELL_M);
                if column >= 0.0
                    && row >= 0.0
                    && (column as usize) < columns
                    && (row as usize) < rows
                {
                    // The first row of a picture is the uppermost.
                    cells[(rows - 1 - row as usize) * columns + column as usize] = OCCUPIED;
                }
            }
        }
        let mut picture = format!("P5\n{columns} {rows}\n255\n").into_bytes();
        picture.extend(cells);
        let yaml = format!(
            "image: landmarks.pgm\nresolution: {CELL_M:.6}\norigin: [{x_m:.6}, {y_m:.6}, 0.0]\n\
             negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
        );
        (picture, yaml)
    }
}

/// Refuses numbers that no landmark has.
fn check(landmark: &Landmark) -> Result<(), &'static str> {
    let numbers = match landmark.shape {
        Shape::Wall {
            normal_rad,
            distance_m,
        } => [normal_rad, distance_m],
        Shape::Point { place_m } => place_m,
    };
    let near = |number: &f64| number.abs() <= FARTHEST_M;
    if !numbers.iter().all(near) {
        return Err("is not in any room");
    }
    let [[a, b], [c, d]] = landmark.covariance;
    let positive = a >= 0.0 && d >= 0.0 && (b - c).abs() <= 1e-9 && [a, b, c, d].iter().all(near);
    if !(positive && b * c <= a * d * (1.0 + 1e-9) + 1e-30) {
        return Err("has no covariance");
    }
    if !(landmark.range_sigma_m > 0.0 && landmark.range_sigma_m < 10.0) {
        return Err("has a range_sigma_m that is not between 0 and 10 m");
    }
    let visibility = &landmark.visibility;
    let bins = visibility.seen.len();
    let whole = bins == visibility.looked.len()
        && (1..=MOST_BINS).contains(&bins)
        && visibility
            .seen
            .iter()
            .zip(&visibility.looked)
            .all(|(seen, looked)| seen <= looked);
    if !(whole && near(&visibility.start) && visibility.step > 1e-6 && visibility.step < 1e3) {
        return Err("has a visibility that does not fit together");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landmarks::Visibility;
    use crate::pose::Pose;

    fn map() -> LandmarkMap {
        let looks = || {
            (0..50).map(|k| {
                (
                    Pose {
                        x_m: 1.0,
                        y_m: 0.05 * f64::from(k),
                        heading_rad: 0.0,
                    },
                    k < 40,
                )
            })
        };
        let landmark = |shape: Shape| Landmark {
            visibility: Visibility::count(&shape, looks()),
            shape,
            covariance: [[1e-6, 0.0], [0.0, 4e-6]],
            range_sigma_m: 0.002,
            blocks: 40,
        };
        LandmarkMap {
            parameters: Parameters::default(),
            landmarks: vec![
                landmark(Shape::Wall {
                    normal_rad: 0.0,
                    distance_m: 3.0,
                }),
                landmark(Shape::Wall {
                    normal_rad: 0.0,
                    distance_m: 5.0,
                }),
                landmark(Shape::Point {
                    place_m: [0.0, 2.0],
                }),
            ],
            area_m: [[1.0, 1.0], [0.0, 2.5]],
            explained: 0.7,
        }
    }

    #[test]
    fn a_folder_is_read_back_and_holds_a_map_for_viewers() {
        let folder = tempfile::tempdir().unwrap();
        let map = map();
        map.write(folder.path()).unwrap();
        assert_eq!(LandmarkMap::read(folder.path()).unwrap(), map);
        let text = std::fs::read_to_string(folder.path().join("landmarks.geojson")).unwrap();
        let geojson: Value = serde_json::from_str(&text).unwrap();
        let image = |k: usize| geojson["features"][k]["properties"]["image"].as_bool();
        assert_eq!(
            [image(0), image(1), image(2)],
            [Some(false), Some(true), Some(false)]
        );
        let ends = &geojson["features"][0]["geometry"]["coordinates"];
        assert_eq!(ends[0][0].as_f64(), Some(3.0));
        assert!(
            (ends[1][1].as_f64().unwrap() - 2.0).abs() < 0.11,
            "as long as it was seen"
        );
        let picture = std::fs::read(folder.path().join("landmarks.pgm")).unwrap();
        let occupied = picture.iter().filter(|&&cell| cell == OCCUPIED).count();
        assert!(
            (38..=44).contains(&occupied),
            "{occupied} cells of a wall of 2 m"
        );
    }

    #[test]
    fn files_that_are_no_map_are_refused_in_one_line() {
        let good = || {
            let folder = tempfile::tempdir().unwrap();
            map().write(folder.path()).unwrap();
            let text = std::fs::read_to_string(folder.path().join("landmarks.json")).unwrap();
            serde_json::from_str::<Value>(&text).unwrap()
        };
        let changes: [(&str, Value, &str); 8] = [
            ("/version", json!(2), "version"),
            ("/landmarks", json!([]), "0 landmarks"),
            ("/landmarks/0/range_sigma_m", json!(0.0), "range_sigma_m"),
            ("/landmarks/1/covariance/0/0", json!(-1.0), "covariance"),
            (
                "/landmarks/0/shape/distance_m",
                json!(1e9),
                "not in any room",
            ),
            (
                "/landmarks/0/visibility/seen/0",
                json!(100_000),
                "visibility",
            ),
            ("/area_m/0", json!([2.0, 1.0]), "area"),
            ("/parameters/periods", json!(0), "periods"),
        ];
        for (pointer, value, word) in changes {
            let mut file = good();
            *file.pointer_mut(pointer).unwrap() = value;
            let message = LandmarkMap::from_json(&file.to_string(), "m/landmarks.json")
                .unwrap_err()
                .to_string();
            assert!(
                message.contains(word) && !message.contains('\n'),
                "{pointer}: {message}"
            );
        }
    }

    #[test]
    fn no_text_panics() {
        let text = serde_json::to_string(&json!({"version": 1})).unwrap();
        for bad in ["", "{}", "[]", "null", "{\"version\": -1}", &text] {
            assert!(LandmarkMap::from_json(bad, "text").is_err());
        }
    }
}
