//! Errors of the estimates of one drive against its truth, where the truth covers them.

use localizer::pose::wrap_angle;
use localizer::{Pose, Trajectory};
use serde::Serialize;

use crate::metrics::{mean, quantile, rounded};

/// Largest distance in time of a true pose from an estimate of which it is the truth, in seconds: that of `evo_ape`.
const LARGEST_APART_S: f64 = 0.01;

/// Errors of a drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scores {
    /// Mean distance from the true position, metres. The true pose is the one nearest in time, as `evo_ape` takes it:
    /// up to 10 ms of the way may be in this and in all others but the next.
    pub mae_m: f64,
    /// The same from the true position between two poses, at the estimate's own instant.
    pub interpolated_mae_m: f64,
    /// Root of the mean square distance, metres.
    pub rmse_m: f64,
    /// 90 % quantile of the distance, metres.
    pub p90_m: f64,
    /// Largest distance, metres.
    pub max_m: f64,
    /// Distance at the last estimate that the truth covers, metres.
    pub final_m: f64,
    /// Mean absolute error of the heading, radians.
    pub heading_mae_rad: f64,
}

impl Scores {
    /// Scores of estimates by time, and the share of them that the truth covers; no scores when it covers none.
    pub fn of(estimates: &[(f64, Pose)], truth: &Trajectory) -> (Option<Self>, f64) {
        let covered = associated(estimates, truth);
        let between_m: Vec<f64> = estimates
            .iter()
            .filter_map(|(t_s, pose)| Some(pose.distance_m(&truth.covered_pose_at(*t_s)?)))
            .collect();
        let coverage = covered.len() as f64 / estimates.len().max(1) as f64;
        let errors_m: Vec<f64> = covered
            .iter()
            .map(|(pose, truth)| pose.distance_m(truth))
            .collect();
        let turns_rad: Vec<f64> = covered
            .iter()
            .map(|(pose, truth)| wrap_angle(pose.heading_rad - truth.heading_rad).abs())
            .collect();
        let squares: Vec<f64> = errors_m.iter().map(|error_m| error_m * error_m).collect();
        let scores = errors_m.last().map(|&final_m| Self {
            mae_m: rounded(mean(&errors_m)),
            interpolated_mae_m: rounded(mean(&between_m)),
            rmse_m: rounded(mean(&squares).sqrt()),
            p90_m: rounded(quantile(&errors_m, 0.9)),
            max_m: rounded(quantile(&errors_m, 1.0)),
            final_m: rounded(final_m),
            heading_mae_rad: rounded(mean(&turns_rad)),
        });
        (scores, rounded(coverage))
    }
}

/// Estimates that the truth covers, each with the true pose of its time: the nearest one within 10 ms, as `evo_ape`
/// takes it, or one between two.
pub fn associated(estimates: &[(f64, Pose)], truth: &Trajectory) -> Vec<(Pose, Pose)> {
    estimates
        .iter()
        .filter_map(|&(t_s, pose)| Some((pose, true_pose(truth, t_s)?)))
        .collect()
}

/// The true pose nearest in time, as `evo_ape` takes it; between true poses where these lie further apart. None where
/// the truth does not cover the time.
fn true_pose(truth: &Trajectory, t_s: f64) -> Option<Pose> {
    let between = truth.covered_pose_at(t_s)?;
    let next = truth.t_s.partition_point(|&time| time < t_s);
    let apart_s = |index: &usize| (truth.t_s[*index] - t_s).abs();
    (next.saturating_sub(1)..=next)
        .filter(|&index| index < truth.len())
        .min_by(|a, b| apart_s(a).total_cmp(&apart_s(b)))
        .filter(|index| apart_s(index) <= LARGEST_APART_S)
        .map_or(Some(between), |nearest| Some(truth.poses[nearest]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_truth_covers_is_scored() {
        let at = |x_m: f64| Pose {
            x_m,
            ..Pose::default()
        };
        // The truth ends at half of the drive; held to the end, its last pose would be metres off.
        let truth = Trajectory {
            t_s: (0..=10).map(|k| 0.1 * f64::from(k)).collect(),
            poses: (0..=10).map(|k| at(0.1 * f64::from(k))).collect(),
        };
        let estimates: Vec<(f64, Pose)> = (0..20)
            .map(|k| 0.05 + 0.1 * f64::from(k))
            .map(|t_s| {
                (
                    t_s,
                    Pose {
                        heading_rad: 0.01,
                        ..at(t_s + 0.03)
                    },
                )
            })
            .collect();
        let (scores, coverage) = Scores::of(&estimates, &truth);
        let scores = scores.unwrap();
        assert!((0.5..=0.55).contains(&coverage), "{coverage}");
        assert!(
            scores.mae_m < 0.04 && (scores.heading_mae_rad - 0.01).abs() < 1e-6,
            "{scores:?}"
        );
        let half = &estimates[..10];
        let (scores, coverage) = Scores::of(half, &truth);
        assert_eq!(coverage, 1.0);
        let scores = scores.unwrap();
        for value in [
            scores.mae_m,
            scores.rmse_m,
            scores.p90_m,
            scores.max_m,
            scores.final_m,
        ] {
            assert!((value - 0.03).abs() < 1e-6, "{scores:?}");
        }
        let elsewhere: Vec<(f64, Pose)> = vec![(1.7e9, at(0.0))];
        assert_eq!(Scores::of(&elsewhere, &truth), (None, 0.0));
    }

    #[test]
    fn where_truth_lies_apart_the_way_between_is_no_error() {
        // 0.3 m/s, a true pose every 20 ms: the nearest is up to 3 mm away.
        let at = |t_s: f64| Pose {
            x_m: 0.3 * t_s,
            ..Pose::default()
        };
        let times = || (0..200).map(|k| 0.02 * f64::from(k));
        let truth = Trajectory {
            t_s: times().collect(),
            poses: times().map(at).collect(),
        };
        let estimates: Vec<(f64, Pose)> = (1..35)
            .map(|k| 0.1023 * f64::from(k))
            .map(|t_s| (t_s, at(t_s)))
            .collect();
        let scores = Scores::of(&estimates, &truth).0.unwrap();
        assert_eq!(scores.interpolated_mae_m, 0.0);
        assert!((0.001..0.002).contains(&scores.mae_m), "{scores:?}");
    }
}
