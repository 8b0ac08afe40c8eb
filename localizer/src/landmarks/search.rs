//! A search for the pose over a whole map.

use std::f64::consts::TAU;

use super::hypothesis::{Hypothesis, Noise, Seen};
use super::map::LandmarkMap;
use super::peaks::MOST_PEAKS;
use crate::pose::{Pose, wrap_angle};

/// Most hypotheses.
const MOST_HYPOTHESES: usize = 1500;
/// Steps of the search over all poses in metres and radians.
const SEARCH_STEP: [f64; 2] = [0.1, TAU / 72.0];
/// Uncertainty of what the search finds, in metres and radians.
const SEARCH_SIGMA: [f64; 2] = [0.05, 0.05];
/// Uncertainty of the ranges that a guess begins with, in metres.
const SEARCH_BLUR_M: f64 = 0.03;
/// How far the search goes beyond the poses from which the map was learnt, in metres.
const SEARCH_MARGIN_M: f64 = 0.4;
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
    let headings = (TAU / SEARCH_STEP[1]).round() as usize;
    let sigma = [0.5 * SEARCH_STEP[0], seen.cosine_sigma.hypot(0.05)];
    let mut found: Vec<(f64, Pose)> = Vec::new();
    for y_m in y {
        for x_m in x.clone() {
            let place = Pose {
                x_m,
                y_m,
                heading_rad: 0.0,
            };
            // Peaks and landmarks whose ranges agree here: what remains to be seen is the heading.
            let mut near: Vec<(usize, f64, f64, f64)> = Vec::new();
            for landmark in &map.landmarks {
                let echo = landmark.shape.predict(&place);
                if echo.range_m <= 0.0 {
                    continue;
                }
                let visible = landmark
                    .visibility
                    .probability(landmark.shape.aspect(&place));
                let bearing_rad = echo.cosine_by_pose[2].atan2(echo.cosine);
                for (number, peak) in seen.peaks.iter().enumerate() {
                    let off = (peak.range_m - echo.range_m) / sigma[0];
                    if off.abs() < 3.0 {
                        near.push((
                            number,
                            bearing_rad,
                            visible * (-0.5 * off * off).exp(),
                            peak.cosine,
                        ));
                    }
                }
            }
            for k in 0..headings {
                let heading_rad = wrap_angle(k as f64 * SEARCH_STEP[1]);
                let mut score = [0.1_f64; MOST_PEAKS];
                for &(number, bearing_rad, weight, cosine) in &near {
                    let off = ((bearing_rad - heading_rad).cos() - cosine) / sigma[1];
                    score[number] += weight * (-0.5 * off * off).exp();
                }
                let score: f64 = score[..seen.peaks.len().min(MOST_PEAKS)]
                    .iter()
                    .map(|p| p.ln())
                    .sum();
                found.push((
                    score,
                    Pose {
                        x_m,
                        y_m,
                        heading_rad,
                    },
                ));
            }
            if found.len() >= 8 * MOST_HYPOTHESES {
                keep_best(&mut found);
            }
        }
    }
    keep_best(&mut found);
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found
        .into_iter()
        .map(|(_, pose)| {
            let [sigma_m, sigma_rad] = SEARCH_SIGMA;
            Hypothesis {
                blur_m: SEARCH_BLUR_M,
                ..Hypothesis::new(&pose, sigma_m, sigma_rad, noise)
            }
        })
        .collect()
}

/// Leaves the best of all that were found, in any order.
fn keep_best(found: &mut Vec<(f64, Pose)>) {
    if found.len() > MOST_HYPOTHESES {
        found.select_nth_unstable_by(MOST_HYPOTHESES, |a, b| b.0.total_cmp(&a.0));
        found.truncate(MOST_HYPOTHESES);
    }
}
