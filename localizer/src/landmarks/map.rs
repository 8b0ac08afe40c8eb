//! A map of landmarks: what they are, how well they are known, and from where they are seen.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::landmark::Shape;
use crate::parameters::Parameters;
use crate::pose::Pose;

/// Width of a bin along a wall in metres.
const WALL_BIN_M: f64 = 0.1;
/// Bins around a point.
const POINT_BINS: usize = 24;
/// Bins to both sides whose counts a probability takes in, with falling weights.
const BIN_REACH: i64 = 3;
/// Looks that the probability of an aspect never looked at stands for, and that probability.
const PRIOR: [f64; 2] = [1.0, 0.1];

/// From where a landmark was seen, and from where it was looked for in vain: counts of blocks over its aspect, which
/// is the place along a wall or the direction from a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Visibility {
    /// Aspect at the start of the first bin: metres along a wall, or -pi around a point.
    pub start: f64,
    /// Width of a bin: metres, or radians.
    pub step: f64,
    /// True around a point: the last bin is next to the first.
    pub around: bool,
    /// Blocks in which the landmark was seen, for each bin.
    pub seen: Vec<u32>,
    /// Blocks in which it could have been seen.
    pub looked: Vec<u32>,
}

impl Visibility {
    /// Counts the aspects of one shape: a pose for every block, and whether its echo was there.
    pub fn count(shape: &Shape, looks: impl Iterator<Item = (Pose, bool)>) -> Self {
        let aspects: Vec<(f64, bool)> = looks
            .map(|(pose, seen)| (shape.aspect(&pose), seen))
            .collect();
        let around = matches!(shape, Shape::Point { .. });
        let (start, step, bins) = if around {
            (-0.5 * TAU, TAU / POINT_BINS as f64, POINT_BINS)
        } else {
            let low = aspects
                .iter()
                .map(|look| look.0)
                .fold(f64::INFINITY, f64::min);
            let high = aspects
                .iter()
                .map(|look| look.0)
                .fold(f64::NEG_INFINITY, f64::max);
            let start = if low.is_finite() {
                (low / WALL_BIN_M).floor() * WALL_BIN_M
            } else {
                0.0
            };
            let bins = if high.is_finite() {
                ((high - start) / WALL_BIN_M) as usize + 1
            } else {
                1
            };
            (start, WALL_BIN_M, bins)
        };
        let mut counts = Self {
            start,
            step,
            around,
            seen: vec![0; bins],
            looked: vec![0; bins],
        };
        for (aspect, seen) in aspects {
            let bin = (((aspect - start) / step) as usize).min(bins - 1);
            counts.looked[bin] += 1;
            counts.seen[bin] += u32::from(seen);
        }
        counts
    }

    /// Probability that the landmark's echo is there at an aspect, between 0 and 1.
    pub fn probability(&self, aspect: f64) -> f64 {
        let bins = self.seen.len() as i64;
        let place = (aspect - self.start) / self.step;
        let (mut seen, mut looked) = (PRIOR[0] * PRIOR[1], PRIOR[0]);
        let middle = place.floor() as i64;
        for bin in middle - BIN_REACH..=middle + BIN_REACH {
            let index = if self.around {
                bin.rem_euclid(bins)
            } else {
                bin
            };
            if !(0..bins).contains(&index) {
                continue;
            }
            let distance = (bin as f64 + 0.5 - place).abs() / (BIN_REACH as f64 + 0.5);
            let weight = (1.0 - distance).max(0.0);
            seen += weight * f64::from(self.seen[index as usize]);
            looked += weight * f64::from(self.looked[index as usize]);
        }
        seen / looked
    }

    /// Lowest and highest aspect, as bin edges, at which the landmark was seen; none if it never was.
    pub fn extent(&self) -> Option<[f64; 2]> {
        let first = self.seen.iter().position(|&count| count > 0)?;
        let last = self.seen.iter().rposition(|&count| count > 0)?;
        let edge = |bin: usize| self.start + bin as f64 * self.step;
        Some([edge(first), edge(last + 1)])
    }
}

/// One landmark of a map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Landmark {
    /// What it is and where.
    pub shape: Shape,
    /// Covariance of the two numbers of its shape: normal (rad) and distance (m), or x and y (m).
    pub covariance: [[f64; 2]; 2],
    /// Root mean square of the range's residuals in metres.
    pub range_sigma_m: f64,
    /// From where it is seen.
    pub visibility: Visibility,
    /// Blocks in which it was seen.
    pub blocks: usize,
}

/// Landmarks of a place, learnt with one set of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct LandmarkMap {
    /// Parameters of signal and measurement under which it was learnt.
    pub parameters: Parameters,
    /// The landmarks, the ones seen most often first.
    pub landmarks: Vec<Landmark>,
    /// Least and largest x and y of the poses from which it was learnt, `[[x, x], [y, y]]` in metres.
    pub area_m: [[f64; 2]; 2],
    /// Share of all peaks, while learning, that belong to a landmark.
    pub explained: f64,
}

impl Landmark {
    /// The two ends of the stretch of a wall that was seen, `[x, y]` in metres; none for a point.
    pub fn ends_m(&self) -> Option<[[f64; 2]; 2]> {
        let Shape::Wall {
            normal_rad,
            distance_m,
        } = self.shape
        else {
            return None;
        };
        let (ny, nx) = normal_rad.sin_cos();
        let at = |along_m: f64| {
            [
                nx * distance_m - ny * along_m,
                ny * distance_m + nx * along_m,
            ]
        };
        self.visibility.extent().map(|extent| extent.map(at))
    }

    /// The middle of what was seen of it, `[x, y]` in metres.
    pub fn middle_m(&self) -> Option<[f64; 2]> {
        match self.shape {
            Shape::Wall { .. } => {
                let [one, other] = self.ends_m()?;
                Some([0, 1].map(|axis| 0.5 * (one[axis] + other[axis])))
            }
            Shape::Point { place_m } => Some(place_m),
        }
    }
}

impl LandmarkMap {
    /// Whether a landmark lies behind a wall, seen from the middle of the area in which the map was learnt: then it is
    /// a mirror image of something in front of it.
    pub fn is_image(&self, landmark: &Landmark) -> bool {
        let Some(middle_m) = landmark.middle_m() else {
            return false;
        };
        let from = self.area_m.map(|[low, high]| 0.5 * (low + high));
        self.landmarks
            .iter()
            .filter(|other| *other != landmark)
            .any(|wall| {
                wall.ends_m().is_some_and(|ends| {
                    // Not what touches it: walls meet in corners.
                    let short =
                        [0, 1].map(|axis| from[axis] + BEFORE * (middle_m[axis] - from[axis]));
                    crosses([from, short], ends)
                })
            })
    }
}

/// Part of the way to a landmark on which a wall hides it.
const BEFORE: f64 = 0.95;

/// Whether two stretches cross.
fn crosses([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_is_seen_where_it_was_and_its_end_is_known() {
        let wall = Shape::Wall {
            normal_rad: 0.0,
            distance_m: 3.0,
        };
        let looks = (0..200).map(|k| {
            let y_m = 0.02 * f64::from(k);
            (
                Pose {
                    x_m: 1.0,
                    y_m,
                    heading_rad: 0.0,
                },
                y_m < 2.0,
            )
        });
        let visibility = Visibility::count(&wall, looks);
        assert!(visibility.probability(1.0) > 0.9);
        assert!(visibility.probability(3.0) < 0.1);
        assert!(
            (visibility.probability(30.0) - PRIOR[1]).abs() < 1e-12,
            "nothing is known there"
        );
        let [low, high] = visibility.extent().expect("was seen");
        assert!(
            (low - 0.0).abs() < 0.11 && (high - 2.0).abs() < 0.11,
            "{low} {high}"
        );
    }

    #[test]
    fn directions_around_a_point_close() {
        let point = Shape::Point {
            place_m: [0.0, 0.0],
        };
        let looks = (0..100).map(|_| {
            (
                Pose {
                    x_m: -1.0,
                    y_m: 1e-6,
                    heading_rad: 0.0,
                },
                true,
            )
        });
        let visibility = Visibility::count(&point, looks);
        // Seen from just this side of -pi: just the other side counts too.
        assert!(visibility.probability(-3.13) > 0.9);
        assert!(visibility.probability(0.0) < 0.5);
    }
}
