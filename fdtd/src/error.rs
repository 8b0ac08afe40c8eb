//! The error type of the library: every message names the file or field, the problem, and the values accepted.

use std::path::PathBuf;

/// Errors between a scene file and a microphone signal.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A field of an input file has a value that cannot be used.
    #[error("{origin}: {field}: {problem}; {remedy}")]
    Invalid {
        /// The file, or "scene" when it did not come from one.
        origin: String,
        /// Path of the field, e.g. `paths.mapping.legs[3].v_mps`.
        field: String,
        /// The problem with it.
        problem: String,
        /// The values that would be accepted.
        remedy: String,
    },
    /// The field has values that no source can have made.
    #[error(
        "the field cannot be trusted {time_s:.3} s into the drive: at [{:.3}, {:.3}] m{} {cause}; \
         nothing is written of this run. A scene that passes its check must not do this, please report it",
        place_m[0], place_m[1], if *in_layer { ", in the absorbing layer," } else { "" }
    )]
    Unstable {
        /// Time of the drive in seconds.
        time_s: f64,
        /// Where the pressure is highest, `[x, y]` in the scene, metres.
        place_m: [f64; 2],
        /// Whether that is in the absorbing layer.
        in_layer: bool,
        /// The evidence.
        cause: String,
    },
    /// A checkpoint belongs to other inputs or is damaged.
    #[error("{}: {problem}; delete the file to start anew", path.display())]
    Checkpoint {
        /// The checkpoint file.
        path: PathBuf,
        /// The mismatch.
        problem: String,
    },
}

impl Error {
    /// An [`Error::Invalid`] from anything that prints.
    pub fn invalid(
        origin: impl std::fmt::Display,
        field: impl std::fmt::Display,
        problem: impl std::fmt::Display,
        remedy: impl std::fmt::Display,
    ) -> Self {
        Self::Invalid {
            origin: origin.to_string(),
            field: field.to_string(),
            problem: problem.to_string(),
            remedy: remedy.to_string(),
        }
    }

    /// An [`Error::Io`] that names its file.
    pub fn io(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::Io {
            path: path.into(),
            source,
        }
    }
}
