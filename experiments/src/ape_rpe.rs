//! Errors of whole trajectories as `evo` defines them: absolute after alignment, and relative from pose to pose.
//!
//! Grupp, evo: Python package for the evaluation of odometry and SLAM; Umeyama (1991) for the alignment.

use localizer::Pose;

/// Distances in metres of positions from the true ones after the rigid motion that makes their root mean square least:
/// `evo_ape tum truth.tum est.tum --align`.
pub fn aligned_errors_m(poses: &[Pose], truth: &[Pose]) -> Vec<f64> {
    let count = poses.len().min(truth.len()) as f64;
    let centre = |poses: &[Pose]| {
        let sum = poses
            .iter()
            .fold([0.0; 2], |sum, pose| [sum[0] + pose.x_m, sum[1] + pose.y_m]);
        sum.map(|value| value / count)
    };
    let (here, there) = (centre(poses), centre(truth));
    let pairs: Vec<[f64; 4]> = poses
        .iter()
        .zip(truth)
        .map(|(pose, truth)| {
            [
                pose.x_m - here[0],
                pose.y_m - here[1],
                truth.x_m - there[0],
                truth.y_m - there[1],
            ]
        })
        .collect();
    let (dot, cross) = pairs.iter().fold((0.0, 0.0), |(dot, cross), [x, y, u, v]| {
        (dot + x * u + y * v, cross + x * v - y * u)
    });
    let (sin, cos) = f64::atan2(cross, dot).sin_cos();
    pairs
        .iter()
        .map(|[x, y, u, v]| (cos * x - sin * y - u).hypot(sin * x + cos * y - v))
        .collect()
}

/// Errors in metres of the way from each pose to the next, seen from the pose: `evo_rpe tum truth.tum est.tum`.
pub fn relative_errors_m(poses: &[Pose], truth: &[Pose]) -> Vec<f64> {
    poses
        .windows(2)
        .zip(truth.windows(2))
        .map(|(ours, truth)| {
            let [x, y] = way(&ours[0], &ours[1]);
            let [u, v] = way(&truth[0], &truth[1]);
            (x - u).hypot(y - v)
        })
        .collect()
}

/// Root mean square of [`aligned_errors_m`]; `NaN` without poses.
pub fn aligned_rmse_m(poses: &[Pose], truth: &[Pose]) -> f64 {
    root_mean_square(&aligned_errors_m(poses, truth))
}

/// Root mean square of [`relative_errors_m`]; `NaN` with fewer than two poses.
pub fn relative_rmse_m(poses: &[Pose], truth: &[Pose]) -> f64 {
    root_mean_square(&relative_errors_m(poses, truth))
}

fn root_mean_square(errors: &[f64]) -> f64 {
    let sum: f64 = errors.iter().map(|error| error * error).sum();
    (sum / errors.len() as f64).sqrt()
}

/// The place of one pose as seen from another.
fn way(from: &Pose, to: &Pose) -> [f64; 2] {
    let (sin, cos) = from.heading_rad.sin_cos();
    let (x, y) = (to.x_m - from.x_m, to.y_m - from.y_m);
    [cos * x + sin * y, cos * y - sin * x]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive() -> Vec<Pose> {
        (0..200)
            .map(|k| {
                let t = 0.05 * f64::from(k);
                Pose {
                    x_m: t.sin() + 0.1 * t,
                    y_m: (0.7 * t).cos(),
                    heading_rad: 0.3 * t,
                }
            })
            .collect()
    }

    #[test]
    fn a_rigid_motion_is_no_error_after_alignment() {
        for (turn, x_m, y_m) in [(0.0, 0.3, -2.0), (1.3, 0.0, 0.0), (-3.0, 5.0, 7.0)] {
            let (sin, cos) = f64::sin_cos(turn);
            let moved: Vec<Pose> = drive()
                .iter()
                .map(|pose| Pose {
                    x_m: cos * pose.x_m - sin * pose.y_m + x_m,
                    y_m: sin * pose.x_m + cos * pose.y_m + y_m,
                    heading_rad: pose.heading_rad + turn,
                })
                .collect();
            assert!(aligned_rmse_m(&moved, &drive()) < 1e-12);
            assert!(relative_rmse_m(&moved, &drive()) < 1e-12);
        }
    }

    /// The numbers of evo 1.38.1 for these two drives as TUM files: `evo_ape tum` with and without `--align`,
    /// `evo_rpe tum`.
    #[test]
    fn errors_are_those_of_evo() {
        let estimate: Vec<Pose> = drive()
            .iter()
            .enumerate()
            .map(|(k, pose)| {
                let t = 0.05 * k as f64;
                Pose {
                    x_m: pose.x_m + 0.02 * (1.7 * t).sin() + 0.05,
                    y_m: pose.y_m + 0.015 * (2.3 * t).cos() - 0.02,
                    heading_rad: pose.heading_rad + 0.03 * t.sin() + 0.01,
                }
            })
            .collect();
        let distances = estimate.iter().zip(drive()).map(|(a, b)| a.distance_m(&b));
        let squares: Vec<f64> = distances.map(|distance| distance * distance).collect();
        let rmse_m = crate::metrics::mean(&squares).sqrt();
        assert!((rmse_m - 0.058_186).abs() < 1e-6, "{rmse_m}");
        let aligned_m = aligned_rmse_m(&estimate, &drive());
        assert!((aligned_m - 0.017_446).abs() < 1e-6, "{aligned_m}");
        let relative_m = relative_rmse_m(&estimate, &drive());
        assert!((relative_m - 0.002_210).abs() < 1e-6, "{relative_m}");
    }

    #[test]
    fn errors_that_alternate_stay() {
        let off: Vec<Pose> = drive()
            .iter()
            .enumerate()
            .map(|(k, pose)| Pose {
                x_m: pose.x_m + [0.01, -0.01][k % 2],
                ..*pose
            })
            .collect();
        assert!((aligned_rmse_m(&off, &drive()) - 0.01).abs() < 1e-4);
        assert!((relative_rmse_m(&off, &drive()) - 0.02).abs() < 1e-6);
        assert!(aligned_rmse_m(&[], &[]).is_nan() && relative_rmse_m(&off[..1], &off).is_nan());
    }
}
