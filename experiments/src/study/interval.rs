//! Mean over everything that was drawn, and its interval by nested bootstrap: layouts are drawn again, in each the
//! slips, in each the noises, in each the filters.

use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::cells::Draw;
use crate::metrics::quantile;

/// Number of resamples.
const RESAMPLES: usize = 10_000;

/// What was drawn, level by level.
enum Tree {
    Leaf(f64),
    Node(Vec<Tree>),
}

impl Tree {
    /// The values by what was drawn from a level on; what was drawn once is no level.
    fn of(values: &[(Draw, f64)], level: usize) -> Self {
        let Some(last) = values.first().map(|(draw, _)| draw.len()) else {
            return Self::Node(Vec::new());
        };
        if level == last {
            return Self::Leaf(values[0].1);
        }
        let mut parts: BTreeMap<u64, Vec<(Draw, f64)>> = BTreeMap::new();
        for &(draw, value) in values {
            parts.entry(draw[level]).or_default().push((draw, value));
        }
        let mut parts = parts.values().map(|part| Self::of(part, level + 1));
        match parts.len() {
            1 => parts.next().unwrap_or(Self::Node(Vec::new())),
            _ => Self::Node(parts.collect()),
        }
    }

    /// Mean over the branches, each with the mean of its own.
    fn mean(&self) -> f64 {
        match self {
            Self::Leaf(value) => *value,
            Self::Node(parts) => parts.iter().map(Self::mean).sum::<f64>() / parts.len() as f64,
        }
    }

    /// The mean when every level with several branches is drawn again.
    fn resampled(&self, random: &mut ChaCha8Rng) -> f64 {
        match self {
            Self::Leaf(value) => *value,
            Self::Node(parts) => {
                let sum: f64 = (0..parts.len())
                    .map(|_| parts[random.random_range(0..parts.len())].resampled(random))
                    .sum();
                sum / parts.len() as f64
            }
        }
    }
}

/// Mean of values by what was drawn, every branch of a level with the same weight, and its 95 % percentile-bootstrap
/// interval. `NaN` without values; equal values give equal intervals.
pub fn mean_and_interval(values: &[(Draw, f64)]) -> (f64, [f64; 2]) {
    resampled(values, RESAMPLES)
}

/// As [`mean_and_interval`], by so many resamples.
fn resampled(values: &[(Draw, f64)], resamples: usize) -> (f64, [f64; 2]) {
    let tree = Tree::of(values, 0);
    let mean = tree.mean();
    if values.len() < 2 {
        return (mean, [mean; 2]);
    }
    let mut random = ChaCha8Rng::seed_from_u64(values.len() as u64);
    let means: Vec<f64> = (0..resamples)
        .map(|_| tree.resampled(&mut random))
        .collect();
    (mean, [quantile(&means, 0.025), quantile(&means, 0.975)])
}

/// Wilson's 95 % interval of a share of `count` that holds in `held` of them.
pub fn share_interval(held: usize, count: usize) -> [f64; 2] {
    const Z: f64 = 1.959_964;
    let n = count as f64;
    let share = held as f64 / n;
    let middle = share + Z * Z / (2.0 * n);
    let half = Z * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    [
        ((middle - half) / scale).max(0.0),
        ((middle + half) / scale).min(1.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::bootstrap_interval;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn with_one_level_it_is_the_plain_bootstrap() {
        for count in [1, 2, 10, 23] {
            let values: Vec<f64> = (0..count).map(|k| f64::from(k * 7 % 5)).collect();
            let drawn: Vec<(Draw, f64)> = (0..)
                .zip(&values)
                .map(|(k, v)| ([0, 0, 0, k], *v))
                .collect();
            assert_eq!(mean_and_interval(&drawn).1, bootstrap_interval(&values));
        }
    }

    #[test]
    fn intervals_over_layouts_cover_the_mean_of_all_layouts() {
        // Layouts spread by 1, filters in a layout by 0.1: the interval must follow the layouts.
        let mut covered = [0; 2];
        for trial in 0..200 {
            let mut random = ChaCha8Rng::seed_from_u64(trial);
            let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
            let mut values = Vec::new();
            for layout in 0..12 {
                let middle = normal();
                for filter in 0..5 {
                    values.push(([layout, 0, 0, filter], middle + 0.1 * normal()));
                }
            }
            // As if all were drawn at one level.
            let flat: Vec<(Draw, f64)> = (0..)
                .zip(&values)
                .map(|(k, (_, value))| ([0, 0, 0, k], *value))
                .collect();
            let intervals = [&values, &flat].map(|values| resampled(values, 1000).1);
            for (covered, [low, high]) in covered.iter_mut().zip(intervals) {
                *covered += usize::from((low..=high).contains(&0.0));
            }
        }
        // A percentile bootstrap over 12 layouts covers somewhat less than 95 %; one that ignores layouts far less.
        assert!((170..=200).contains(&covered[0]), "{covered:?}");
        assert!(covered[1] < 150, "{covered:?}");
    }

    #[test]
    fn shares_have_wilsons_interval() {
        // Wilson (1927) for 8 of 10: 0.490 to 0.943.
        let [low, high] = share_interval(8, 10);
        assert!(
            (low - 0.490).abs() < 1e-3 && (high - 0.943).abs() < 1e-3,
            "{low} {high}"
        );
        assert!(share_interval(10, 10)[1] > 1.0 - 1e-12 && share_interval(0, 10)[0] < 1e-12);
    }
}
