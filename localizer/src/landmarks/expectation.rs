//! What a hypothesis expects of a landmark's echo, and a peak held against it.

use nalgebra::RowVector6;

use super::hypothesis::{Hypothesis, Noise, Seen};
use super::landmark::Prediction;
use super::map::Landmark;
use super::peaks::Peak;

/// Probability up to which a peak is held to come from its landmark: what gives echoes and is no landmark stays in
/// place, too.
const MOST_PROBABLE: f64 = 0.98;

/// What a hypothesis expects of a landmark's echo.
pub(super) struct Expected {
    /// Range and cosine.
    mean: [f64; 2],
    /// Their variances at a known state.
    pub(super) variances: [f64; 2],
    pub(super) by_state: [RowVector6<f64>; 2],
    /// Their covariance `[[a, b], [b, d]]` with the state's uncertainty: `[a, b, d]`, and its determinant.
    spread: [f64; 3],
    determinant: f64,
}

impl Expected {
    pub(super) fn new(
        hypothesis: &Hypothesis,
        entry: &Landmark,
        echo: &Prediction,
        seen: &Seen<'_>,
        noise: &Noise,
    ) -> Self {
        let (speed, sound) = (hypothesis.state[4], hypothesis.state[5]);
        // A guess says nothing of wheels and air before it has settled.
        let settled = if hypothesis.is_settled() { 1.0 } else { 0.0 };
        // Ranges are read with the set speed of sound, cosines also with the wheels' speed.
        let (stretch, slant) = (1.0 - sound, 1.0 + speed - sound);
        let [rx, ry, rt] = [0, 1, 2].map(|k| echo.range_by_pose[k] * stretch);
        let [cx, cy, ct] = [0, 1, 2].map(|k| echo.cosine_by_pose[k] * slant);
        let of_landmark: f64 = (0..2)
            .flat_map(|a| (0..2).map(move |b| (a, b)))
            .map(|(a, b)| echo.range_by_shape[a] * entry.covariance[a][b] * echo.range_by_shape[b])
            .sum();
        let variances = [
            entry.range_sigma_m.powi(2)
                + noise.range_m.powi(2)
                + hypothesis.blur_m.powi(2)
                + of_landmark,
            seen.cosine_sigma.powi(2),
        ];
        let by_state = [
            RowVector6::new(rx, ry, rt, 0.0, 0.0, -settled * echo.range_m),
            RowVector6::new(
                cx,
                cy,
                ct,
                0.0,
                settled * echo.cosine,
                -settled * echo.cosine,
            ),
        ];
        let spread = by_state.map(|row| hypothesis.covariance * row.transpose());
        let a = (by_state[0] * spread[0])[0] + variances[0];
        let b = (by_state[0] * spread[1])[0];
        let d = (by_state[1] * spread[1])[0] + variances[1];
        Self {
            mean: [echo.range_m * stretch, echo.cosine * slant],
            variances,
            by_state,
            spread: [a, b, d],
            determinant: (a * d - b * b).max(1e-12),
        }
    }

    pub(super) fn residuals(&self, peak: &Peak) -> [f64; 2] {
        [peak.range_m - self.mean[0], peak.cosine - self.mean[1]]
    }

    /// Squared Mahalanobis distance of residuals.
    pub(super) fn distance(&self, [r, c]: [f64; 2]) -> f64 {
        let [a, b, d] = self.spread;
        (d * r * r - 2.0 * b * r * c + a * c * c) / self.determinant
    }

    /// Information of a range that comes from the landmark with a probability: what makes the state's uncertainty
    /// along it that of the mixture of both cases (probabilistic data association, Bar-Shalom 1975). A range far
    /// more exact than the state would otherwise settle it although it may be another's.
    pub(super) fn information(&self, residual_m: f64, probability: f64) -> f64 {
        let before = self.spread[0] - self.variances[0];
        let p = probability.min(MOST_PROBABLE);
        let gain = before / self.spread[0];
        let after = (1.0 - p) * before
            + p * gain * self.variances[0]
            + p * (1.0 - p) * (gain * residual_m).powi(2);
        (1.0 / after - 1.0 / before).clamp(0.0, 1.0 / self.variances[0])
    }

    /// The density's factor before the exponential.
    pub(super) fn density(&self) -> f64 {
        1.0 / (std::f64::consts::TAU * self.determinant.sqrt())
    }
}

/// A peak against the landmark that it is held to come from: residuals of range and cosine.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Match {
    pub(super) residuals: [f64; 2],
    pub(super) variances: [f64; 2],
    /// Their information.
    pub(super) weights: [f64; 2],
    pub(super) by_state: [RowVector6<f64>; 2],
}

impl Match {
    /// Sum of the squared residuals over their variances.
    pub(super) fn squares(&self) -> f64 {
        (0..2)
            .map(|k| self.residuals[k].powi(2) / self.variances[k])
            .sum()
    }
}
