//! Poses over time.

use crate::pose::{Pose, wrap_angle};

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
