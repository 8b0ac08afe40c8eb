//! Measures of localization: mean, quantiles and distribution of the position error, and intervals of the mean.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Number of bootstrap resamples.
const RESAMPLES: usize = 10_000;

/// Mean of `values`; `NaN` when there are none.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Quantile `fraction` (0 to 1) of `values` by linear interpolation between order statistics; `NaN` when there are
/// none.
pub fn quantile(values: &[f64], fraction: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile_of_sorted(&sorted, fraction)
}

/// As [`quantile`], of values in rising order.
pub fn quantile_of_sorted(sorted: &[f64], fraction: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = fraction.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let above = place.ceil() as usize;
    sorted[below] + (sorted[above] - sorted[below]) * (place - below as f64)
}

/// Percentile bootstrap interval (95 %) of the mean of `trials`. One trial gives an interval without width; the same
/// trials always give the same interval.
pub fn bootstrap_interval(trials: &[f64]) -> [f64; 2] {
    if trials.len() < 2 {
        return [mean(trials); 2];
    }
    let mut random = ChaCha8Rng::seed_from_u64(trials.len() as u64);
    let means: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            (0..trials.len())
                .map(|_| trials[random.random_range(0..trials.len())])
                .sum::<f64>()
                / trials.len() as f64
        })
        .collect();
    [quantile(&means, 0.025), quantile(&means, 0.975)]
}

/// Empirical distribution of `errors` at `points` evenly spaced fractions: pairs (error, share of errors not above it).
pub fn cumulative_distribution(errors: &[f64], points: usize) -> Vec<(f64, f64)> {
    if errors.is_empty() || points < 2 {
        return Vec::new();
    }
    (0..points)
        .map(|index| {
            let share = index as f64 / (points - 1) as f64;
            (quantile(errors, share), share)
        })
        .collect()
}

/// Rounds to six decimals (micrometres, in metres), so that result files do not change by noise of the last bit.
pub fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// Mean absolute position error over the trials of one cell of a study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// Mean over all trials and times of the distance between estimated and true position, metres.
    pub mae_m: f64,
    /// 95 % bootstrap interval of `mae_m` over the trials, metres.
    pub interval_m: [f64; 2],
    /// Number of trials.
    pub trials: usize,
    /// Mean absolute error of each trial, metres.
    pub trial_mae_m: Vec<f64>,
    /// 90 % quantile of the position error over all trials and times, metres.
    pub p90_m: f64,
    /// Mean absolute error of the heading over all trials and times, radians.
    pub heading_mae_rad: f64,
}

impl Accuracy {
    /// Accuracy over trials, each given as its position errors (m) and heading errors (rad) over time.
    pub fn over(trials: &[(&[f64], &[f64])]) -> Self {
        let trial_mae_m: Vec<f64> = trials.iter().map(|(errors, _)| mean(errors)).collect();
        let all: Vec<f64> = trials
            .iter()
            .flat_map(|(errors, _)| errors.iter().copied())
            .collect();
        let headings: Vec<f64> = trials
            .iter()
            .flat_map(|(_, headings)| headings.iter().map(|value| value.abs()))
            .collect();
        Self {
            mae_m: rounded(mean(&trial_mae_m)),
            interval_m: bootstrap_interval(&trial_mae_m).map(rounded),
            trials: trials.len(),
            p90_m: rounded(quantile(&all, 0.9)),
            heading_mae_rad: rounded(mean(&headings)),
            trial_mae_m: trial_mae_m.into_iter().map(rounded).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate() {
        let values = [3.0, 1.0, 2.0, 4.0];
        assert_eq!(quantile(&values, 0.0), 1.0);
        assert_eq!(quantile(&values, 1.0), 4.0);
        assert_eq!(quantile(&values, 0.5), 2.5);
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn the_bootstrap_interval_covers_the_standard_error() {
        let trials: Vec<f64> = (0..50).map(|k| f64::from(k % 10)).collect();
        let [low, high] = bootstrap_interval(&trials);
        // The exact standard error of the mean is 2.872 / sqrt(50) = 0.406.
        assert!((low - (4.5 - 1.96 * 0.406)).abs() < 0.05, "{low}");
        assert!((high - (4.5 + 1.96 * 0.406)).abs() < 0.05, "{high}");
        assert_eq!(bootstrap_interval(&trials), [low, high]);
        assert_eq!(bootstrap_interval(&[0.3]), [0.3, 0.3]);
    }

    #[test]
    fn accuracy_weighs_trials_evenly() {
        let accuracy = Accuracy::over(&[(&[1.0, 3.0], &[0.1, -0.1]), (&[4.0, 4.0], &[0.3, 0.3])]);
        assert_eq!(accuracy.mae_m, 3.0);
        assert_eq!(accuracy.trial_mae_m, [2.0, 4.0]);
        assert_eq!(accuracy.heading_mae_rad, 0.2);
        assert!(accuracy.interval_m[0] >= 2.0 && accuracy.interval_m[1] <= 4.0);
    }

    #[test]
    fn the_distribution_rises_from_least_to_greatest() {
        let curve = cumulative_distribution(&[0.2, 0.1, 0.4], 11);
        assert_eq!(curve.first(), Some(&(0.1, 0.0)));
        assert_eq!(curve.last(), Some(&(0.4, 1.0)));
        assert!(curve.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    }
}
