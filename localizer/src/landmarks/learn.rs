//! Learning landmarks from a drive with known poses.
//!
//! A peak has a range and a cosine: at a known pose it may come from a wall or from a point on either side of the
//! heading. Votes of all blocks (Hough) single out the ones that stay in place. The best is refined by robust least
//! squares on the ranges, its peaks are taken out, and so on.

use super::hough::Votes;
use super::landmark::Shape;
use super::map::{Landmark, LandmarkMap, Visibility};
use super::peaks::Peak;
use super::sighting::{Sighting, sightings};
use crate::echo::EchoSequence;
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
/// Gates on the range, one for each round of refinement, in metres.
const GATES_M: [f64; 6] = [0.08, 0.04, 0.025, 0.02, 0.02, 0.02];
/// Residual of the range at which a peak has half its weight, in metres.
const ROBUST_M: f64 = 0.004;
/// Standard deviations of the cosine up to which a peak may belong to a landmark.
const COSINE_GATE: f64 = 3.0;
/// Residual of the range in metres within which most peaks of a landmark lie, and that part of them. Peaks that
/// happen to lie near a line are spread over the whole gate.
const TIGHT_M: f64 = 0.008;
const LEAST_TIGHT: f64 = 0.75;
/// Largest standard deviation of a landmark's position (metres) and normal (radians).
const MOST_SIGMA: f64 = 0.03;
/// Standard deviation of poses in metres up to which they are known as well as ranges.
const KNOWN_M: f64 = 0.002;
/// Largest correlation of the residuals of neighbouring blocks that is believed.
const MOST_ALIKE: f64 = 0.95;
/// Blocks over which residuals are alike, so that they count once.
const ALIKE_BLOCKS: f64 = 4.0;

/// Learns the landmarks of a place from drives with known poses.
///
/// # Errors
/// [`Error::Invalid`] when there is no drive, drives were measured with other parameters, or no landmark was found.
pub fn learn(drives: &[(&EchoSequence, &[Pose])]) -> Result<LandmarkMap, Error> {
    let refuse =
        |problem: &str, remedy: &str| Err(Error::invalid("map", "drives", problem, remedy));
    let Some((first, _)) = drives.first() else {
        return refuse("there is none", "give a recording with true poses");
    };
    let alike = |other: &Parameters| {
        other.signal == first.parameters.signal && other.measurement == first.parameters.measurement
    };
    if !drives.iter().all(|(echoes, _)| alike(&echoes.parameters)) {
        return refuse(
            "they were measured with different parameters",
            "measure all of them alike",
        );
    }
    let seen: Vec<Sighting> = drives
        .iter()
        .flat_map(|(echoes, poses)| sightings(echoes, poses))
        .collect();
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
        parameters: first.parameters.clone(),
        landmarks,
        area_m: [axis(|pose| pose.x_m), axis(|pose| pose.y_m)],
        explained: explained as f64 / all.max(1) as f64,
    })
}

/// A landmark with the peaks that belong to it, one a block at most.
struct Fit {
    shape: Shape,
    /// For each sighting the number of the peak.
    peaks: Vec<Option<usize>>,
    blocks: usize,
    rms_m: f64,
    /// Part of the peaks whose residual is at most [`TIGHT_M`].
    tight: f64,
    covariance: [[f64; 2]; 2],
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
            Some(best) if best.blocks >= least && good(&best) => {
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

fn good(fit: &Fit) -> bool {
    fit.tight >= LEAST_TIGHT && (0..2).all(|k| fit.covariance[k][k].sqrt() <= MOST_SIGMA)
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
            .filter(|fit| fit.blocks >= least && good(fit))
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

/// Robust least squares on the ranges of the free peaks near a landmark, with narrower gates from round to round.
fn fit(
    mut shape: Shape,
    seen: &[Sighting],
    free: &[Vec<bool>],
    gates_m: &[f64],
    pose_sigma_m: f64,
) -> Option<Fit> {
    let mut peaks = vec![None; seen.len()];
    let mut last = ([[0.0; 2]; 2], 0.0, 0.0, 0);
    for &gate_m in gates_m {
        let gate_m = gate_m + 2.0 * pose_sigma_m;
        let (mut information, mut pull) = ([[0.0; 2]; 2], [0.0; 2]);
        let (mut squares, mut weights, mut tight) = (0.0, 0.0, 0);
        for ((sighting, free), chosen) in seen.iter().zip(free).zip(&mut peaks) {
            let echo = shape.echo(&sighting.pose, &sighting.motion);
            let near = |number: &usize| {
                let peak = &sighting.peaks[*number];
                free[*number]
                    && (peak.range_m - echo.range_m).abs() < gate_m
                    && (peak.cosine - echo.cosine).abs() < COSINE_GATE * sighting.cosine_sigma
            };
            let off = |number: usize| (sighting.peaks[number].range_m - echo.range_m).abs();
            *chosen = (0..sighting.peaks.len())
                .filter(near)
                .min_by(|&a, &b| off(a).total_cmp(&off(b)));
            let Some(number) = *chosen else {
                continue;
            };
            let residual_m = sighting.peaks[number].range_m - echo.range_m;
            let weight = 1.0 / (1.0 + (residual_m / (ROBUST_M + pose_sigma_m)).powi(2));
            let [a, b] = echo.range_by_shape;
            pull[0] += weight * a * residual_m;
            pull[1] += weight * b * residual_m;
            information[0][0] += weight * a * a;
            information[0][1] += weight * a * b;
            information[1][0] += weight * a * b;
            information[1][1] += weight * b * b;
            squares += weight * residual_m * residual_m;
            weights += weight;
            tight += usize::from(residual_m.abs() <= TIGHT_M + 1.5 * pose_sigma_m);
        }
        let inverse = invert(information)?;
        let change = [0, 1].map(|row| inverse[row][0] * pull[0] + inverse[row][1] * pull[1]);
        if !change
            .iter()
            .all(|number| number.is_finite() && number.abs() < 1.0)
        {
            return None;
        }
        shape = shape.moved(change);
        last = (inverse, squares, weights, tight);
    }
    let (inverse, squares, weights, tight) = last;
    let variance = (squares / weights).max(1e-8);
    // Where poses are off, residuals last for that reason.
    let variance = if pose_sigma_m <= KNOWN_M {
        variance * lasting(&shape, seen, &peaks)
    } else {
        variance
    };
    let scale = variance * ALIKE_BLOCKS;
    Some(Fit {
        shape,
        blocks: peaks.iter().flatten().count(),
        tight: tight as f64 / peaks.iter().flatten().count().max(1) as f64,
        peaks,
        rms_m: variance.sqrt(),
        covariance: inverse.map(|row| row.map(|number| number * scale)),
    })
}

/// Blocks in a row that count as one, because their residuals are alike: by the correlation of neighbours, as of a
/// first-order process. What is no landmark but happens to lie near one has residuals that last.
fn lasting(shape: &Shape, seen: &[Sighting], peaks: &[Option<usize>]) -> f64 {
    let residual = |index: usize| {
        let sighting = &seen[index];
        let echo = shape.echo(&sighting.pose, &sighting.motion);
        peaks[index].map(|number| sighting.peaks[number].range_m - echo.range_m)
    };
    let (mut squares, mut products) = (0.0, 0.0);
    for index in 1..seen.len() {
        if let (Some(before), Some(here)) = (residual(index - 1), residual(index)) {
            squares += 0.5 * (before * before + here * here);
            products += before * here;
        }
    }
    let alike = (products / squares.max(1e-12)).clamp(0.0, MOST_ALIKE);
    (1.0 + alike) / (1.0 - alike)
}

fn invert([[a, b], [c, d]]: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    let determinant = a * d - b * c;
    (determinant > 1e-9 * a * d).then(|| {
        [
            [d / determinant, -b / determinant],
            [-c / determinant, a / determinant],
        ]
    })
}

#[cfg(test)]
mod tests {
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
