//! Trajectories as TUM text, `t x y z qx qy qz qw` with single spaces, which common evaluation tools read.

use std::fmt::Write as _;
use std::path::Path;

use super::files;
use super::files::shorten;
use crate::error::Error;
use crate::pose::{Pose, wrap_angle};
use crate::trajectory::Trajectory;

/// Largest tilt of a robot that drives on a floor, in degrees.
const LARGEST_TILT_DEG: f64 = 20.0;
/// Farthest place from the world's origin in metres, per coordinate.
const FARTHEST_M: f64 = 1e7;

impl Trajectory {
    /// Reads a TUM file. Lines that are empty or start with `#` are skipped.
    ///
    /// # Errors
    /// [`Error::Io`] when the file cannot be read, otherwise those of [`Self::from_tum`].
    pub fn read_tum(path: &Path) -> Result<Self, Error> {
        Self::from_tum(&files::read_text(path)?, &path.display().to_string())
    }

    /// Reads TUM text; `origin` names it in errors.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the line that has not eight finite numbers, no rotation, or a time that does not
    /// increase, or when there is no pose at all.
    pub fn from_tum(text: &str, origin: &str) -> Result<Self, Error> {
        let mut trajectory = Self::default();
        for (index, line) in text.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let refuse = |problem: String, remedy: &str| {
                Error::invalid(origin, format!("line {}", index + 1), problem, remedy)
            };
            let numbers: Vec<f64> = line
                .split_whitespace()
                .map(str::parse)
                .collect::<Result<_, _>>()
                .map_err(|_| {
                    refuse(
                        format!("`{}` is not all numbers", shorten(line)),
                        "write `t x y z qx qy qz qw`",
                    )
                })?;
            let &[t_s, x_m, y_m, _, qx, qy, qz, qw] = numbers.as_slice() else {
                let problem = format!("has {} numbers", numbers.len());
                return Err(refuse(problem, "write eight: `t x y z qx qy qz qw`"));
            };
            if numbers.iter().any(|number| !number.is_finite()) {
                return Err(refuse(
                    "has a number that is not finite".to_owned(),
                    "write finite numbers",
                ));
            }
            if x_m.abs().max(y_m.abs()) > FARTHEST_M {
                return Err(refuse(
                    format!("the place {x_m}, {y_m} is far from any room"),
                    "write metres",
                ));
            }
            if qx * qx + qy * qy + qz * qz + qw * qw < 1e-6 {
                return Err(refuse(
                    "the rotation is zero".to_owned(),
                    "write a unit quaternion, `0 0 0 1` for none",
                ));
            }
            // The body's own z axis leaves the world's by the tilt.
            let norm = qx * qx + qy * qy + qz * qz + qw * qw;
            let tilt = |x: f64, y: f64| (1.0 - 2.0 * (x * x + y * y) / norm).acos().to_degrees();
            if tilt(qx, qy) > LARGEST_TILT_DEG {
                let looks = match tilt(qy, qz) <= LARGEST_TILT_DEG {
                    true => "; it looks like the order qw qx qy qz",
                    false => "",
                };
                let problem = format!("the robot is tilted by {:.0} degrees{looks}", tilt(qx, qy));
                let remedy = "write `t x y z qx qy qz qw` with z upwards";
                return Err(refuse(problem, remedy));
            }
            if trajectory.t_s.last().is_some_and(|&before| t_s <= before) {
                return Err(refuse(
                    format!("time {t_s} s does not increase"),
                    "sort the lines by time",
                ));
            }
            let heading_rad =
                (2.0 * (qw * qz + qx * qy)).atan2(qw * qw + qx * qx - qy * qy - qz * qz);
            trajectory.t_s.push(t_s);
            trajectory.poses.push(Pose {
                x_m,
                y_m,
                heading_rad,
            });
        }
        if trajectory.t_s.is_empty() {
            return Err(Error::invalid(
                origin,
                "content",
                "has no pose",
                "write one `t x y z qx qy qz qw` per line",
            ));
        }
        Ok(trajectory)
    }

    /// The TUM text of the trajectory.
    pub fn to_tum(&self) -> String {
        let mut text = String::with_capacity(64 * self.t_s.len());
        for (t_s, pose) in self.t_s.iter().zip(&self.poses) {
            let (qz, qw) = (0.5 * wrap_angle(pose.heading_rad)).sin_cos();
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{t_s:.6} {:.9} {:.9} 0 0 0 {qz:.12} {qw:.12}",
                pose.x_m, pose.y_m
            );
        }
        text
    }

    /// Writes a TUM file under a temporary name and renames it.
    ///
    /// # Errors
    /// [`Error::Io`] when that fails.
    pub fn write_tum(&self, path: &Path) -> Result<(), Error> {
        files::write_bytes(path, self.to_tum().as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn errors_name_the_line() {
        for (text, word) in [
            ("", "no pose"),
            ("# only a comment\n", "no pose"),
            ("0 1 2 0 0 0 0 1\n0 1 2 0 0 0 0 1\n", "line 2"),
            ("0 1 2 0 0 0 0\n", "has 7 numbers"),
            ("0 1 2 0 0 0 0 x\n", "not all numbers"),
            ("0 1 nan 0 0 0 0 1\n", "not finite"),
            ("0 1 2 0 0 0 0 0\n", "rotation is zero"),
            ("0 1 2 0 0.9689 0 0 0.2474\n", "qw qx qy qz"),
            ("0 1 2 0 0 0.3827 0 0.9239\n", "tilted by 45 degrees"),
        ] {
            let message = Trajectory::from_tum(text, "a.tum").unwrap_err().to_string();
            assert!(
                message.contains(word) && message.contains("a.tum"),
                "{message}"
            );
        }
    }

    proptest! {
        #[test]
        fn text_is_read_back(poses in prop::collection::vec((-50.0..50.0, -50.0..50.0, -3.1..3.1), 1..20)) {
            let written = Trajectory {
                t_s: (0..poses.len()).map(|k| 0.1023 * k as f64).collect(),
                poses: poses.iter().map(|&(x_m, y_m, heading_rad)| Pose { x_m, y_m, heading_rad }).collect(),
            };
            let read = Trajectory::from_tum(&written.to_tum(), "text").unwrap();
            prop_assert_eq!(read.len(), written.len());
            for (a, b) in read.poses.iter().zip(&written.poses) {
                prop_assert!(a.distance_m(b) < 1e-8);
                prop_assert!((a.heading_rad - b.heading_rad).abs() < 1e-9);
            }
        }

        #[test]
        fn no_text_panics(text in "[ 0-9.eE+#\\-\nnaif]{0,200}") {
            let _ = Trajectory::from_tum(&text, "text");
        }
    }
}
