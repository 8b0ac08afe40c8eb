//! Poses over time.

use crate::pose::{Pose, wrap_angle};

/// Longest time between two poses of a trajectory that covers what is in between, in seconds.
pub const LONGEST_GAP_S: f64 = 1.0;
/// Time beyond its ends that a trajectory still covers, in seconds.
pub const END_S: f64 = 0.1;
/// Distance between two poses that their noise may explain, in metres.
pub const JUMP_M: f64 = 0.1;

/// Poses at increasing times.
///
/// ```
/// use localizer::Trajectory;
///
/// let text = "0.0 1.0 2.0 0 0 0 0 1\n1.0 2.0 2.0 0 0 0 0 1\n";
/// let trajectory = Trajectory::from_tum(text, "text")?;
/// assert_eq!(trajectory.pose_at(0.5).map(|pose| pose.x_m), Some(1.5));
/// # Ok::<(), localizer::Error>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trajectory {
    /// Times in seconds, increasing.
    pub t_s: Vec<f64>,
    /// One pose for each time.
    pub poses: Vec<Pose>,
}

impl Trajectory {
    /// The pose at a time: position interpolated linearly, heading the shorter way; the first or last pose beyond the
    /// ends.
    ///
    /// None for an empty trajectory.
    pub fn pose_at(&self, t_s: f64) -> Option<Pose> {
        let next = self.t_s.partition_point(|&time| time <= t_s);
        let Some(before) = next.checked_sub(1) else {
            return self.poses.first().copied();
        };
        let (Some(&a), Some(&b)) = (self.poses.get(before), self.poses.get(next)) else {
            return self.poses.last().copied();
        };
        let share = (t_s - self.t_s[before]) / (self.t_s[next] - self.t_s[before]);
        Some(Pose {
            x_m: a.x_m + share * (b.x_m - a.x_m),
            y_m: a.y_m + share * (b.y_m - a.y_m),
            heading_rad: wrap_angle(
                a.heading_rad + share * wrap_angle(b.heading_rad - a.heading_rad),
            ),
        })
    }

    /// The pose at a time that the trajectory covers: `None` before its first pose, after its last, and in a gap of
    /// more than [`LONGEST_GAP_S`], where [`Self::pose_at`] would hold or guess one. Its ends may be off by
    /// [`END_S`].
    pub fn covered_pose_at(&self, t_s: f64) -> Option<Pose> {
        let (first, last) = (*self.t_s.first()?, *self.t_s.last()?);
        if !(first - END_S..=last + END_S).contains(&t_s) {
            return None;
        }
        let next = self.t_s.partition_point(|&time| time <= t_s);
        if let (Some(before), Some(&after)) = (next.checked_sub(1), self.t_s.get(next))
            && after - self.t_s[before] > LONGEST_GAP_S
            && t_s > self.t_s[before]
        {
            return None;
        }
        self.pose_at(t_s)
    }

    /// Intervals between two poses over which nothing can have moved so far: faster than `fastest_mps`, by more than
    /// [`JUMP_M`]. Each is the index of the pose before the jump.
    pub fn jumps(&self, fastest_mps: f64) -> Vec<usize> {
        let is_jump = |&index: &usize| {
            let length_s = self.t_s[index + 1] - self.t_s[index];
            let way_m = self.poses[index].distance_m(&self.poses[index + 1]);
            way_m > JUMP_M + fastest_mps * length_s
        };
        (0..self.poses.len().saturating_sub(1))
            .filter(is_jump)
            .collect()
    }

    /// Poses at several times, in their order. Empty for an empty trajectory.
    pub fn poses_at(&self, times_s: impl IntoIterator<Item = f64>) -> Vec<Pose> {
        times_s
            .into_iter()
            .filter_map(|t_s| self.pose_at(t_s))
            .collect()
    }

    /// Number of poses.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// True when there is no pose.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn only_what_is_covered_has_a_pose() {
        let at = |x_m| Pose {
            x_m,
            ..Pose::default()
        };
        let trajectory = Trajectory {
            t_s: vec![1.0, 1.5, 2.0, 12.0, 12.5],
            poses: [0.0, 0.1, 0.2, 2.0, 0.4].map(at).to_vec(),
        };
        for (t_s, covered) in [
            (-1.0, false),
            (0.85, false),
            (0.95, true),
            (1.0, true),
            (1.7, true),
            (2.0, true),
            (2.001, false),
            (11.99, false),
            (12.0, true),
            (12.55, true),
            (12.65, false),
            (1.7e18, false),
            (f64::NAN, false),
        ] {
            assert_eq!(trajectory.covered_pose_at(t_s).is_some(), covered, "{t_s}");
        }
        assert_eq!(Trajectory::default().covered_pose_at(0.0), None);
        assert_eq!(trajectory.jumps(0.5), [3]);
        assert_eq!(trajectory.jumps(0.1), [2, 3]);
        assert!(Trajectory::default().jumps(1.0).is_empty());
    }

    #[test]
    fn poses_between_two_turn_the_shorter_way() {
        let trajectory = Trajectory {
            t_s: vec![0.0, 2.0],
            poses: vec![
                Pose {
                    x_m: 0.0,
                    y_m: 0.0,
                    heading_rad: PI - 0.1,
                },
                Pose {
                    x_m: 2.0,
                    y_m: 1.0,
                    heading_rad: -PI + 0.3,
                },
            ],
        };
        let pose = trajectory.pose_at(1.0).unwrap();
        assert!((pose.x_m - 1.0).abs() < 1e-12 && (pose.y_m - 0.5).abs() < 1e-12);
        assert!((pose.heading_rad - (-PI + 0.1)).abs() < 1e-12);
        assert_eq!(trajectory.pose_at(-1.0), Some(trajectory.poses[0]));
        assert_eq!(trajectory.pose_at(9.0), Some(trajectory.poses[1]));
        assert_eq!(Trajectory::default().pose_at(0.0), None);
    }
}
