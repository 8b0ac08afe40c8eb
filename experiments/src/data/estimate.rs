//! Estimated trajectories: TUM files whose first line, a comment, says that this program wrote them.

use std::path::Path;

use anyhow::Result;
use localizer::quality::Fit;
use localizer::{Estimate, Pose, Trajectory};

use super::{atomic, manifest};

/// How the first line begins; the digest of the lines below it follows.
const BEGIN: &str = "# echolot estimate ";

/// Writes a trajectory.
///
/// # Errors
/// When the file cannot be written.
pub fn write(path: &Path, trajectory: &Trajectory) -> Result<()> {
    let text = trajectory.to_tum();
    let digest = manifest::digest(text.as_bytes());
    atomic::write(path, format!("{BEGIN}{digest}\n{text}").as_bytes())
}

/// Whether bytes are a file of [`write`] that nobody has changed.
pub fn is_ours(bytes: &[u8]) -> bool {
    std::str::from_utf8(bytes)
        .ok()
        .and_then(|text| text.strip_prefix(BEGIN)?.split_once('\n'))
        .is_some_and(|(digest, text)| manifest::digest(text.as_bytes()) == digest)
}

/// First line of the table.
const HEADER: &str =
    "t_s,x_m,y_m,heading_rad,xx_m2,xy_m2,yy_m2,xh_mrad,yh_mrad,hh_rad2,fit,status\n";

/// Estimates with covariance, fit and status as CSV, one line each.
pub fn table(estimates: &[Estimate], fits: &[Fit]) -> String {
    let mut text = HEADER.to_string();
    for (estimate, fit) in estimates.iter().zip(fits) {
        let Pose {
            x_m,
            y_m,
            heading_rad,
        } = estimate.pose;
        let [[xx, xy, xh], [_, yy, yh], [.., hh]] = estimate.covariance;
        let status = if fit.sure { "sure" } else { "doubtful" };
        text += &format!(
            "{:.6},{x_m:.6},{y_m:.6},{heading_rad:.6},{xx:.3e},{xy:.3e},{yy:.3e},{xh:.3e},{yh:.3e},{hh:.3e},\
             {:.3},{status}\n",
            estimate.t_s, fit.fit
        );
    }
    text
}

/// Whether bytes are a file of [`table`].
pub fn is_table(bytes: &[u8]) -> bool {
    bytes.starts_with(HEADER.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_is_known_until_it_is_edited() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive.tum");
        let trajectory = Trajectory {
            t_s: vec![0.5],
            poses: vec![Pose::default()],
        };
        write(&path, &trajectory).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert!(is_ours(&bytes));
        assert!(!is_ours(&[&bytes[..], b"# mine\n"].concat()) && !is_ours(b""));
        assert_eq!(Trajectory::read_tum(&path).unwrap(), trajectory);
    }
}
