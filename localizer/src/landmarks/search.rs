//! A search for the pose over a whole map.

use std::f64::consts::TAU;

use super::hypothesis::{Hypothesis, Noise, Seen};
use super::map::LandmarkMap;
use super::peaks::MOST_PEAKS;
use crate::pose::{Pose, wrap_angle};

/// Most hypotheses.
const MOST_HYPOTHESES: usize = 500;
/// Steps of the search over all poses in metres and radians.
const SEARCH_STEP: [f64; 2] = [0.1, TAU / 72.0];
/// Uncertainty of what the search finds, in metres and radians.
const SEARCH_SIGMA: [f64; 2] = [0.05, 0.05];
/// Uncertainty of the ranges that a guess begins with, in metres.
const SEARCH_BLUR_M: f64 = 0.03;
/// How far the search goes beyond the poses from which the map was learnt, in metres.
const SEARCH_MARGIN_M: f64 = 0.4;
/// What a peak that fits no landmark counts.
const LEAST_SCORE: f64 = 0.1;
/// Most steps of the search along one axis: 100 m; a larger place is searched in larger steps.
const MOST_STEPS: f64 = 1000.0;

/// Looks for poses anywhere in the map that explain the block, and makes hypotheses of the best.
pub(super) fn search(seen: &Seen<'_>, map: &LandmarkMap, noise: &Noise) -> Vec<Hypothesis> {
    let [x, y] = map.area_m.map(|[low, high]| {
        let count = ((high - low + 2.0 * SEARCH_MARGIN_M) / SEARCH_STEP[0])
            .ceil()
            .clamp(1.0, MOST_STEPS);
        let step = (high - low + 2.0 * SEARCH_MARGIN_M) / count;
        (0..count as usize).map(move |k| low - SEARCH_MARGIN_M + (k as f64 + 0.5) * step)
    });
    let headings: Vec<(f64, [f64; 2])> = (0..(TAU / SEARCH_STEP[1]).round() as usize)
        .map(|k| wrap_angle(k as f64 * SEARCH_STEP[1]))
        .map(|heading_rad| (heading_rad, [heading_rad.cos(), heading_rad.sin()]))
        .collect();
    let peaks = &seen.peaks[..seen.peaks.len().min(MOST_PEAKS)];
    let sigma = [0.5 * SEARCH_STEP[0], seen.cosine_sigma.hypot(0.05)];
    let mut found: Vec<(f64, Pose)> = Vec::with_capacity(8 * MOST_HYPOTHESES);
    // A score below which others are among the best already.
    let mut floor = 0.0;
    let mut near: Vec<Near> = Vec::new();
    for y_m in y {
        for x_m in x.clone() {
            let place = Pose {
                x_m,
                y_m,
                heading_rad: 0.0,
            };
            // Peaks and landmarks whose ranges agree here: what remains to be seen is the heading.
            near.clear();
            for landmark in &map.landmarks {
                let echo = landmark.shape.predict(&place);
                if echo.range_m <= 0.0 {
                    continue;
                }
                let mut visible = None;
                for (number, peak) in peaks.iter().enumerate() {
                    let agreement = bell((peak.range_m - echo.range_m) / sigma[0]);
                    if agreement > 0.0 {
                        let visible = *visible.get_or_insert_with(|| {
                            let aspect = landmark.shape.aspect(&place);
                            landmark.visibility.probability(aspect)
                        });
                        near.push(Near {
                            number,
                            // Heading 0: along and across it.
                            direction: [echo.cosine, echo.cosine_by_pose[2]],
                            weight: visible * agreement,
                            cosine: peak.cosine,
                        });
                    }
                }
            }
            for &(heading_rad, [cosine, sine]) in &headings {
                let mut scores = [LEAST_SCORE; MOST_PEAKS];
                for near in &near {
                    let expected = near.direction[0] * cosine + near.direction[1] * sine;
                    scores[near.number] += near.weight * bell((expected - near.cosine) / sigma[1]);
                }
                let score: f64 = scores[..peaks.len()].iter().product();
                if score > floor {
                    found.push((
                        score,
                        Pose {
                            x_m,
                            y_m,
                            heading_rad,
                        },
                    ));
                }
            }
            if found.len() >= 4 * MOST_HYPOTHESES {
                floor = keep_best(&mut found).max(floor);
            }
        }
    }
    keep_best(&mut found);
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found
        .into_iter()
        .map(|(_, pose)| {
            let [sigma_m, sigma_rad] = SEARCH_SIGMA;
            let mut guess = Hypothesis::new(&pose, sigma_m, sigma_rad, noise);
            guess.blur_m = SEARCH_BLUR_M;
            guess
        })
        .collect()
}

/// A peak that may come from a landmark, as far as its range goes.
struct Near {
    /// Number of the peak.
    number: usize,
    /// Direction of the echo.
    direction: [f64; 2],
    /// How well the range agrees, times the probability that the landmark is seen.
    weight: f64,
    /// Cosine of the peak.
    cosine: f64,
}

/// A normal density's shape, with an end at three standard deviations.
fn bell(off: f64) -> f64 {
    let part = (1.0 - off * off / 9.0).max(0.0);
    (part * part).powi(2)
}

/// Leaves the best of all that were found, in any order; the least score among them when there are enough.
fn keep_best(found: &mut Vec<(f64, Pose)>) -> f64 {
    if found.len() <= MOST_HYPOTHESES {
        return 0.0;
    }
    found.select_nth_unstable_by(MOST_HYPOTHESES - 1, |a, b| b.0.total_cmp(&a.0));
    found.truncate(MOST_HYPOTHESES);
    found[MOST_HYPOTHESES - 1].0
}
