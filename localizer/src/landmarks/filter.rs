//! Following the pose among landmarks: a few Gaussian hypotheses, as many as the echoes leave open.

use std::f64::consts::TAU;

use super::hypothesis::{Fit, Hypothesis, Noise, Seen};
use super::map::LandmarkMap;
use super::peaks::MOST_PEAKS;
use crate::odometry::Odometry;
use crate::pose::{Pose, wrap_angle};

/// How far an estimate is to be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Several poses are still possible.
    Converging,
    /// One pose fits, and has for a while.
    Sure,
    /// No pose fits: the estimate is dead reckoning from the last one that did.
    Lost,
}

/// Pose at the start of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start {
    /// Known, with standard deviations.
    Known {
        /// The pose.
        pose: Pose,
        /// Standard deviation of x and y in metres.
        sigma_m: f64,
        /// Standard deviation of the heading in radians.
        sigma_rad: f64,
    },
    /// Anywhere in the map.
    Unknown,
}

/// Most hypotheses.
const MOST_HYPOTHESES: usize = 1500;
/// Steps of the search over all poses in metres and radians.
const SEARCH_STEP: [f64; 2] = [0.1, TAU / 72.0];
/// Uncertainty of what the search finds, in metres and radians.
const SEARCH_SIGMA: [f64; 2] = [0.05, 0.05];
/// Uncertainty of the ranges that a guess begins with, in metres.
const SEARCH_BLUR_M: f64 = 0.03;
/// Standard deviation of the cosines from which on a block tells directions apart well enough for a search.
const SEARCH_COSINE_SIGMA: f64 = 0.35;
/// How far the search goes beyond the poses from which the map was learnt, in metres.
const SEARCH_MARGIN_M: f64 = 0.4;
/// Logarithm of the weight below the best one's at which a hypothesis ends.
const LEAST_LOG_WEIGHT: f64 = -14.0;
/// Distances (metres, radians) within which two hypotheses are one.
const ALIKE: [f64; 2] = [0.04, 0.08];
/// Logarithm of the odds from which on a hypothesis is sure.
const SURE_LOG_ODDS: f64 = 6.0;
/// Standard deviation of the position in metres up to which a hypothesis is sure.
const SURE_SIGMA_M: f64 = 0.05;
/// Blocks over which the fit is averaged.
const FIT_BLOCKS: f64 = 8.0;
/// Expected echoes a block below which a fit says nothing.
const LEAST_EXPECTED: f64 = 0.8;
/// Share of the expected echoes below which a fit is bad.
const BAD_FIT: f64 = 0.35;
/// Blocks for which a fit must be good to be sure.
const GOOD_BLOCKS: usize = 10;
/// Blocks for which it must be bad for the robot to be lost.
const BAD_BLOCKS: usize = 15;
/// Blocks after which a search that found no pose begins anew.
const SEARCH_BLOCKS: usize = 40;

/// Hypotheses that compete with each other, and how well the best one fits.
#[derive(Debug, Clone, Default)]
struct Track {
    /// The best one first.
    hypotheses: Vec<Hypothesis>,
    fits: Vec<Fit>,
    /// Echoes that the best hypothesis expects in a block and those of them that it finds, averaged.
    expected: f64,
    found: f64,
    /// Blocks in a row with a good fit of a single hypothesis, and with a bad fit.
    good: usize,
    bad: usize,
    /// Blocks taken in, and the logarithm of the best one's likelihood since the last [`Track::begin`].
    blocks: usize,
    score: f64,
}

impl Track {
    fn of(hypotheses: Vec<Hypothesis>) -> Self {
        Self {
            hypotheses,
            ..Self::default()
        }
    }

    /// Counts blocks and score from here on.
    fn begin(&mut self) {
        (self.blocks, self.score) = (0, 0.0);
    }

    fn fit(&self) -> f64 {
        if self.expected > 0.0 {
            self.found / self.expected
        } else {
            0.0
        }
    }

    fn predict(&mut self, odometry: Odometry, duration_s: f64, noise: &Noise) {
        for hypothesis in &mut self.hypotheses {
            hypothesis.predict(odometry, duration_s, noise);
        }
    }

    fn update(&mut self, seen: &Seen<'_>, map: &LandmarkMap, noise: &Noise) {
        self.fits.clear();
        for hypothesis in &mut self.hypotheses {
            self.fits.push(hypothesis.update(seen, map, noise));
        }
        let weight = |index: usize| self.hypotheses[index].log_weight;
        let best = (0..self.hypotheses.len()).max_by(|&a, &b| weight(a).total_cmp(&weight(b)));
        if let Some(best) = best {
            let Fit {
                expected, found, ..
            } = self.fits[best];
            self.expected += (expected - self.expected) / FIT_BLOCKS;
            self.found += (found - self.found) / FIT_BLOCKS;
        }
        self.blocks += 1;
        self.thin();
        let tells = self.expected > LEAST_EXPECTED;
        let fits = self.fit() > BAD_FIT;
        self.bad = if tells && !fits { self.bad + 1 } else { 0 };
        self.good = if tells && fits && self.is_single() {
            self.good + 1
        } else {
            0
        };
    }

    /// Whether one hypothesis stands out, and is narrow.
    fn is_single(&self) -> bool {
        let second = self.hypotheses.get(1);
        let narrow = self.hypotheses.first().is_some_and(|best| {
            best.covariance[(0, 0)] + best.covariance[(1, 1)] < SURE_SIGMA_M.powi(2)
        });
        narrow && second.is_none_or(|second| second.log_weight < -SURE_LOG_ODDS)
    }

    /// Drops and joins hypotheses, the best one first.
    fn thin(&mut self) {
        self.hypotheses
            .sort_by(|a, b| b.log_weight.total_cmp(&a.log_weight));
        let Some(most) = self.hypotheses.first().map(|best| best.log_weight) else {
            return;
        };
        self.score += most;
        let mut kept = 0;
        for index in 0..self.hypotheses.len() {
            self.hypotheses[index].log_weight -= most;
            if self.hypotheses[index].log_weight < LEAST_LOG_WEIGHT {
                continue;
            }
            let pose = self.hypotheses[index].pose();
            let twin = self.hypotheses[..kept].iter().any(|other| {
                let other = other.pose();
                other.distance_m(&pose) < ALIKE[0]
                    && wrap_angle(other.heading_rad - pose.heading_rad).abs() < ALIKE[1]
            });
            if !twin {
                self.hypotheses.swap(kept, index);
                kept += 1;
            }
        }
        self.hypotheses.truncate(kept.max(1));
    }
}

/// A filter: the pose that is followed and, while it does not fit, the poses that might be true instead.
pub struct LandmarkFilter {
    noise: Noise,
    main: Track,
    challenger: Option<Track>,
    status: Status,
    searching: bool,
}

impl LandmarkFilter {
    /// A filter at a start.
    pub fn new(start: &Start, noise: Noise) -> Self {
        let (hypotheses, status) = match start {
            Start::Known {
                pose,
                sigma_m,
                sigma_rad,
            } => (
                vec![Hypothesis::new(
                    pose,
                    sigma_m.max(1e-3),
                    sigma_rad.max(1e-3),
                    &noise,
                )],
                Status::Sure,
            ),
            Start::Unknown => (Vec::new(), Status::Converging),
        };
        Self {
            noise,
            searching: hypotheses.is_empty(),
            main: Track::of(hypotheses),
            challenger: None,
            status,
        }
    }

    /// The best hypothesis; none before the first block of an unknown start.
    pub fn best(&self) -> Option<&Hypothesis> {
        self.main.hypotheses.first()
    }

    /// All hypotheses that are followed, the best one first.
    pub fn hypotheses(&self) -> &[Hypothesis] {
        &self.main.hypotheses
    }

    /// How far the best hypothesis is to be trusted.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Share of the expected echoes that the best hypothesis found lately.
    pub fn fit(&self) -> f64 {
        self.main.fit()
    }

    /// Moves all hypotheses by the wheels.
    pub fn predict(&mut self, odometry: Odometry, duration_s: f64) {
        self.main.predict(odometry, duration_s, &self.noise);
        if let Some(challenger) = &mut self.challenger {
            challenger.predict(odometry, duration_s, &self.noise);
        }
    }

    /// Takes in the peaks of a block.
    pub fn update(&mut self, seen: &Seen<'_>, map: &LandmarkMap) {
        if self.searching && seen.cosine_sigma < SEARCH_COSINE_SIGMA {
            let found = Track::of(self.search(seen, map));
            if self.main.hypotheses.is_empty() {
                self.main = found;
            } else {
                self.main.begin();
                self.challenger = Some(found);
            }
            self.searching = false;
        }
        self.main.update(seen, map, &self.noise);
        if let Some(challenger) = &mut self.challenger {
            challenger.update(seen, map, &self.noise);
        }
        self.judge();
    }

    fn judge(&mut self) {
        if let Some(challenger) = &self.challenger {
            let wins = challenger.good >= GOOD_BLOCKS
                && challenger.score > self.main.score + SURE_LOG_ODDS;
            if wins && let Some(challenger) = self.challenger.take() {
                self.main = challenger;
            }
        }
        if self.main.good >= GOOD_BLOCKS {
            self.status = Status::Sure;
            self.challenger = None;
        } else if self.main.bad >= BAD_BLOCKS {
            self.status = Status::Lost;
        } else if self.status == Status::Sure && !self.main.is_single() {
            self.status = Status::Converging;
        }
        let tried = self.challenger.as_ref().map(|challenger| challenger.blocks);
        let lost =
            self.status == Status::Lost && tried.is_none_or(|blocks| blocks >= SEARCH_BLOCKS);
        self.searching = lost || self.main.hypotheses.is_empty();
    }

    /// Looks for poses anywhere in the map that explain the block, and makes hypotheses of the best.
    fn search(&self, seen: &Seen<'_>, map: &LandmarkMap) -> Vec<Hypothesis> {
        let [x, y] = map.area_m.map(|[low, high]| {
            let count = ((high - low + 2.0 * SEARCH_MARGIN_M) / SEARCH_STEP[0])
                .ceil()
                .max(1.0);
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
            }
        }
        let count = found.len().min(MOST_HYPOTHESES);
        if found.len() > count {
            found.select_nth_unstable_by(count, |a, b| b.0.total_cmp(&a.0));
        }
        found.truncate(count);
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found
            .into_iter()
            .map(|(_, pose)| {
                let [sigma_m, sigma_rad] = SEARCH_SIGMA;
                Hypothesis {
                    blur_m: SEARCH_BLUR_M,
                    ..Hypothesis::new(&pose, sigma_m, sigma_rad, &self.noise)
                }
            })
            .collect()
    }
}
