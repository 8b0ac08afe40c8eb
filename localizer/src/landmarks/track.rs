//! Hypotheses of the pose that compete with each other.

use super::hypothesis::{Fit, Hypothesis, Noise, Seen};
use super::map::LandmarkMap;
use crate::odometry::Odometry;
use crate::pose::wrap_angle;

/// Logarithm of the weight below the best one's at which a hypothesis may end.
const LEAST_LOG_WEIGHT: f64 = -14.0;
/// Part of what the best one explains by which a rival must fall short to be refuted, and twice of which to end. From
/// where images of images are seen is known that well: in a room that is nearly its own copy the copy may lead by as
/// much.
const RIVAL_PART: f64 = 0.08;
/// Distances (metres, radians) within which two hypotheses are one.
const ALIKE: [f64; 2] = [0.04, 0.08];
/// Logarithm of the odds from which on a hypothesis is sure.
pub(crate) const SURE_LOG_ODDS: f64 = 6.0;
/// Standard deviation of the position in metres up to which a hypothesis is sure.
const SURE_SIGMA_M: f64 = 0.05;
/// Blocks over which the fit is averaged.
const FIT_BLOCKS: f64 = 8.0;
/// Expected echoes a block below which a fit says nothing.
const LEAST_EXPECTED: f64 = 0.8;
/// Share of the expected echoes below which a fit is bad.
const BAD_FIT: f64 = 0.35;

/// Hypotheses that compete with each other, and how well the best one fits.
#[derive(Debug, Clone, Default)]
pub(crate) struct Track {
    /// The best one first.
    pub(crate) hypotheses: Vec<Hypothesis>,
    fits: Vec<Fit>,
    /// Echoes that the best hypothesis expects in a block and those of them that it finds, averaged.
    expected: f64,
    found: f64,
    /// Blocks in a row with a good fit of a single hypothesis, and with a bad fit.
    pub(crate) good: usize,
    pub(crate) bad: usize,
    /// Logarithm of the best one's likelihood.
    score: f64,
    /// Blocks taken in, and the logarithm of the best one's likelihood since the last [`Track::begin`].
    pub(crate) blocks: usize,
    pub(crate) lately: f64,
}

impl Track {
    pub(crate) fn of(hypotheses: Vec<Hypothesis>) -> Self {
        Self {
            hypotheses,
            ..Self::default()
        }
    }

    /// Counts blocks and score from here on.
    pub(crate) fn begin(&mut self) {
        (self.blocks, self.lately) = (0, 0.0);
    }

    pub(crate) fn fit(&self) -> f64 {
        if self.expected > 0.0 {
            self.found / self.expected
        } else {
            0.0
        }
    }

    pub(crate) fn predict(&mut self, odometry: Odometry, duration_s: f64, noise: &Noise) {
        for hypothesis in &mut self.hypotheses {
            hypothesis.predict(odometry, duration_s, noise);
        }
    }

    pub(crate) fn update(&mut self, seen: &Seen<'_>, map: &LandmarkMap, noise: &Noise) {
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
        self.bad = if tells && !self.fits() {
            self.bad + 1
        } else {
            0
        };
        self.good = if self.fits() && self.is_single() {
            self.good + 1
        } else {
            0
        };
    }

    /// Whether the best hypothesis expects echoes, and finds enough of them.
    pub(crate) fn fits(&self) -> bool {
        self.expected > LEAST_EXPECTED && self.fit() > BAD_FIT
    }

    /// Whether one hypothesis stands out, and is narrow.
    pub(crate) fn is_single(&self) -> bool {
        let second = self.hypotheses.get(1);
        let narrow = self.hypotheses.first().is_some_and(|best| {
            best.covariance[(0, 0)] + best.covariance[(1, 1)] < SURE_SIGMA_M.powi(2)
        });
        let enough = SURE_LOG_ODDS.max(RIVAL_PART * self.score);
        narrow && second.is_none_or(|second| second.log_weight < -enough)
    }

    /// Takes over the hypotheses of another track that followed the same blocks since both began; their likelihoods
    /// are taken to have fallen short of this one's at the same rate before, and to begin behind it.
    pub(crate) fn join(&mut self, other: Self) {
        let longer = (self.score / self.lately.max(1e-6)).clamp(1.0, 100.0);
        for mut hypothesis in other.hypotheses {
            let lead = other.lately + hypothesis.log_weight - self.lately;
            hypothesis.log_weight = (longer * lead).min(-0.5 * SURE_LOG_ODDS);
            self.hypotheses.push(hypothesis);
        }
        self.thin();
    }

    /// Drops and joins hypotheses, the best one first.
    fn thin(&mut self) {
        self.hypotheses
            .sort_unstable_by(|a, b| b.log_weight.total_cmp(&a.log_weight));
        let Some(most) = self.hypotheses.first().map(|best| best.log_weight) else {
            return;
        };
        self.score += most;
        self.lately += most;
        let least = LEAST_LOG_WEIGHT.min(-2.0 * RIVAL_PART * self.score);
        let mut kept = 0;
        for index in 0..self.hypotheses.len() {
            self.hypotheses[index].log_weight -= most;
            if self.hypotheses[index].log_weight < least {
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
