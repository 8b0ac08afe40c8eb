//! Estimated trajectories: TUM files whose first line, a comment, says that this program wrote them.

use std::path::Path;

use anyhow::Result;
use localizer::Trajectory;

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

#[cfg(test)]
mod tests {
    use localizer::Pose;

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
