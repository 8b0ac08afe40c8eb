//! Learning landmarks from a drive with known poses.
//!
//! A peak has a range and a cosine: at a known pose it may come from a wall or from a point on either side of the
//! heading. Votes of all blocks (Hough) single out the ones that stay in place. The best is refined by robust least
//! squares on the ranges, its peaks are taken out, and so on.

use super::fit::{COSINE_GATE, Fit, GATES_M, fit};
use super::hough::Votes;
use super::landmark::Shape;
use super::map::{Landmark, LandmarkMap, Visibility};
use super::peaks::{Peak, PeakFinder};
use super::sighting::{Sighting, sighting};
use crate::echo::{EchoBlock, EchoSequence};
use crate::error::Error;
use crate::parameters::Parameters;
use crate::pose::Pose;

/// Least share of blocks in which a landmark is seen.
const LEAST_SHARE: f64 = 0.06;
/// Least number of blocks in which a landmark is seen.
const LEAST_BLOCKS: usize = 10;
/// Most landmarks of a map.
const MOST_LANDMARKS: usize = 32;
/// Candidates in a row that turn out to be none, after which learning stops.
const MOST_REFUSED: usize = 8;

/// Learns the landmarks of a place from drives with known poses.
///
/// # Errors
/// As [`Learner::begin`] and [`Learner::finish`].
pub fn learn(drives: &[(&EchoSequence, &[Pose])]) -> Result<LandmarkMap, Error> {
    let mut learner = Learner::default();
    for (echoes, poses) in drives {
        learner.begin(&echoes.parameters)?;
        for (block, pose) in echoes.blocks.iter().zip(*poses) {
            learner.add(block, pose);
        }
    }
    learner.finish()
}

/// Landmarks in the making, block by block; of a block the peaks are kept.
#[derive(Default)]
pub struct Learner {
    drive: Option<(Parameters, PeakFinder)>,
    seen: Vec<Sighting>,
}

impl Learner {
    /// The blocks that follow are of another drive, measured with these parameters.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the drives before were measured with others.
    pub fn begin(&mut self, parameters: &Parameters) -> Result<(), Error> {
        if let Some((first, _)) = &self.drive
            && (first.signal != parameters.signal || first.measurement != parameters.measurement)
        {
            return refuse(
                "they were measured with different parameters",
                "measure all of them alike",
            );
        }
        let first = self.drive.take();
        let own = first.map_or_else(|| parameters.clone(), |(first, _)| first);
        self.drive = Some((own, PeakFinder::new(parameters)));
        Ok(())
    }

    /// Adds a block of the drive that began last, at its known pose. Blocks before the first drive, and of a robot that
    /// stands, say nothing.
    pub fn add(&mut self, block: &EchoBlock, pose: &Pose) {
        let Some((parameters, finder)) = &mut self.drive else {
            return;
        };
        if !block.stationary {
            self.seen.push(sighting(block, *pose, parameters, finder));
        }
    }

    /// The map.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there was no drive, or no landmark was found.
    pub fn finish(self) -> Result<LandmarkMap, Error> {
        let Some((parameters, _)) = self.drive else {
            return refuse("there is none", "give a recording with true poses");
        };
        let seen = self.seen;
        let landmarks = landmarks(&seen, 0.0);
        if landmarks.is_empty() {
            return refuse(
                "no landmark was found in them",
                "record longer, drive along curves, and check that the echoes are in the recording",
            );
        }
        let axis = |of: fn(&Pose) -> f64| {
            let values = seen.iter().map(|sighting| of(&sighting.pose));
            [
                values.clone().fold(f64::INFINITY, f64::min),
                values.fold(f64::NEG_INFINITY, f64::max),
            ]
        };
        let all: usize = seen.iter().map(|sighting| sighting.peaks.len()).sum();
        let explained: usize = landmarks.iter().map(|landmark| landmark.blocks).sum();
        Ok(LandmarkMap {
            parameters,
            area_m: [axis(|pose| pose.x_m), axis(|pose| pose.y_m)],
            explained: explained as f64 / all.max(1) as f64,
            landmarks,
        })
    }
}

fn refuse<T>(problem: &str, remedy: &str) -> Result<T, Error> {
    Err(Error::invalid("map", "drives", problem, remedy))
}

/// The landmarks seen in all blocks, the ones seen most often first. The poses of the sightings may be off by some
/// `pose_sigma_m` metres against each other.
pub fn landmarks(seen: &[Sighting], pose_sigma_m: f64) -> Vec<Landmark> {
    let least = LEAST_BLOCKS.max((LEAST_SHARE * seen.len() as f64).ceil() as usize);
    let mut free: Vec<Vec<bool>> = seen
        .iter()
        .map(|sighting| vec![true; sighting.peaks.len()])
        .collect();
    let mut found: Vec<Shape> = Vec::new();
    let mut refused = 0;
    let mut votes = Votes::new(seen);
    while found.len() < MOST_LANDMARKS && refused < MOST_REFUSED {
        let Some(candidates) = votes.best() else {
            break;
        };
        let fits = candidates
            .into_iter()
            .filter_map(|shape| fit(shape, seen, &free, &GATES_M, pose_sigma_m));
        let best = fits.max_by_key(|fit| fit.blocks);
        match best {
            Some(best) if best.blocks >= least && best.is_good() => {
                refused = 0;
                take(&best.shape, seen, pose_sigma_m, &mut free, &mut votes);
                found.push(best.shape);
            }
            _ => {
                refused += 1;
                votes.forget_best();
            }
        }
    }
    settle(found, seen, least, pose_sigma_m)
}

/// Takes the peaks of a landmark out.
fn take(
    shape: &Shape,
    seen: &[Sighting],
    pose_sigma_m: f64,
    free: &mut [Vec<bool>],
    votes: &mut Votes,
) {
    for (index, (sighting, free)) in seen.iter().zip(free).enumerate() {
        let echo = shape.echo(&sighting.pose, &sighting.motion);
        for (number, (peak, free)) in sighting.peaks.iter().zip(free).enumerate() {
            let near = (peak.range_m - echo.range_m).abs() < GATES_M[2] + 2.0 * pose_sigma_m
                && (peak.cosine - echo.cosine).abs() < COSINE_GATE * sighting.cosine_sigma;
            if *free && near {
                *free = false;
                votes.remove(seen, index, number);
            }
        }
    }
}

/// Refits all landmarks beside each other: a peak belongs to the landmark that it fits best.
fn settle(
    mut shapes: Vec<Shape>,
    seen: &[Sighting],
    least: usize,
    pose_sigma_m: f64,
) -> Vec<Landmark> {
    let mut fits: Vec<Fit> = Vec::new();
    for _ in 0..3 {
        let own = assign(&shapes, seen, pose_sigma_m);
        fits = shapes
            .iter()
            .enumerate()
            .filter_map(|(number, &shape)| {
                let free: Vec<Vec<bool>> = own
                    .iter()
                    .map(|peaks| {
                        peaks
                            .iter()
                            .map(|&landmark| landmark == Some(number))
                            .collect()
                    })
                    .collect();
                fit(shape, seen, &free, &GATES_M[2..], pose_sigma_m)
            })
            .filter(|fit| fit.blocks >= least && fit.is_good())
            .collect();
        shapes = fits.iter().map(|fit| fit.shape).collect();
    }
    let mut landmarks: Vec<Landmark> = fits
        .into_iter()
        .map(|fit| Landmark {
            visibility: Visibility::count(
                &fit.shape,
                seen.iter().zip(&fit.peaks).filter_map(|(sighting, peak)| {
                    let range_m = fit.shape.echo(&sighting.pose, &sighting.motion).range_m;
                    (range_m > 0.0).then_some((sighting.pose, peak.is_some()))
                }),
            ),
            shape: fit.shape,
            covariance: fit.covariance,
            range_sigma_m: fit.rms_m,
            blocks: fit.blocks,
        })
        .collect();
    landmarks.sort_by_key(|landmark| std::cmp::Reverse(landmark.blocks));
    landmarks
}

/// For every peak the landmark that it fits best, if any.
fn assign(shapes: &[Shape], seen: &[Sighting], pose_sigma_m: f64) -> Vec<Vec<Option<usize>>> {
    seen.iter()
        .map(|sighting| {
            let echoes: Vec<_> = shapes
                .iter()
                .map(|shape| shape.echo(&sighting.pose, &sighting.motion))
                .collect();
            let of_peak = |peak: &Peak| {
                let distance = |number: usize| {
                    let dr =
                        (peak.range_m - echoes[number].range_m) / (GATES_M[2] + 2.0 * pose_sigma_m);
                    let dc = (peak.cosine - echoes[number].cosine)
                        / (COSINE_GATE * sighting.cosine_sigma);
                    dr * dr + dc * dc
                };
                let all = (0..shapes.len()).map(|number| (distance(number), number));
                all.min_by(|a, b| a.0.total_cmp(&b.0))
                    .and_then(|(distance, number)| (distance < 2.0).then_some(number))
            };
            sighting.peaks.iter().map(of_peak).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::fit::{ALIKE_BLOCKS, invert};
    use super::super::simulated::{self, Drive};
    use super::*;
    use crate::pose::wrap_angle;

    /// Distance of two shapes of the same kind, metres and radians mixed.
    fn apart(one: &Shape, other: &Shape) -> f64 {
        match (*one, *other) {
            (
                Shape::Wall {
                    normal_rad: a,
                    distance_m: b,
                },
                Shape::Wall {
                    normal_rad: c,
                    distance_m: d,
                },
            ) => wrap_angle(a - c).abs() + (b - d).abs(),
            (Shape::Point { place_m: [a, b] }, Shape::Point { place_m: [c, d] }) => {
                (a - c).hypot(b - d)
            }
            _ => f64::INFINITY,
        }
    }

    #[test]
    fn known_walls_and_corners_are_learnt_to_millimetres_and_nothing_else() {
        for seed in 1..=12 {
            let shapes = simulated::shapes();
            let drive = Drive::new(seed, shapes.clone());
            let seen: Vec<Sighting> = drive.take(350).map(|block| block.sighting).collect();
            let found = landmarks(&seen, 0.0);
            assert_eq!(found.len(), shapes.len(), "seed {seed}: {found:?}");
            for shape in &shapes {
                let nearest = found
                    .iter()
                    .map(|landmark| apart(&landmark.shape, shape))
                    .fold(f64::INFINITY, f64::min);
                assert!(
                    nearest < 0.004,
                    "seed {seed}: {shape:?} is off by {nearest}"
                );
            }
            for landmark in &found {
                assert!(landmark.range_sigma_m < 2.5 * simulated::RANGE_SIGMA_M);
                assert!(
                    landmark.blocks > 100,
                    "seed {seed}: {} blocks",
                    landmark.blocks
                );
            }
        }
    }

    #[test]
    fn errors_of_what_is_learnt_are_as_large_as_their_covariance_says() {
        let (mut squares, mut count) = (0.0, 0.0);
        for seed in 1..=30 {
            let shapes = simulated::shapes();
            let drive = Drive::new(seed, shapes.clone());
            let seen: Vec<Sighting> = drive.take(200).map(|block| block.sighting).collect();
            for landmark in landmarks(&seen, 0.0) {
                let off = |shape: &&Shape| apart(&landmark.shape, shape) < 0.05;
                let Some(shape) = shapes.iter().find(off) else {
                    continue;
                };
                let difference = match (landmark.shape, *shape) {
                    (
                        Shape::Wall {
                            normal_rad: a,
                            distance_m: b,
                        },
                        Shape::Wall {
                            normal_rad: c,
                            distance_m: d,
                        },
                    ) => [wrap_angle(a - c), b - d],
                    (Shape::Point { place_m: [a, b] }, Shape::Point { place_m: [c, d] }) => {
                        [a - c, b - d]
                    }
                    _ => continue,
                };
                let inverse = invert(landmark.covariance).expect("a covariance");
                for row in 0..2 {
                    for column in 0..2 {
                        squares += difference[row] * inverse[row][column] * difference[column];
                    }
                }
                count += 2.0;
            }
        }
        // Peaks are independent here; the covariance takes ALIKE_BLOCKS of them for one.
        let ratio = squares / count * ALIKE_BLOCKS;
        assert!((0.5..1.6).contains(&ratio), "{ratio} over {count}");
    }

    #[test]
    fn clutter_alone_has_no_landmarks() {
        let drive = Drive::new(3, Vec::new());
        let seen: Vec<Sighting> = drive.take(300).map(|block| block.sighting).collect();
        assert_eq!(landmarks(&seen, 0.0), Vec::new());
    }
}
