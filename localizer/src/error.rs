//! The error type of the library: every message names the file or field, the problem, and the values accepted.

use std::path::PathBuf;

/// Errors between a recording folder and a pose.
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
    /// A field of an input has a value that cannot be used.
    #[error("{origin}: {field}: {problem}; {remedy}")]
    Invalid {
        /// The file, or the argument's name when it did not come from one.
        origin: String,
        /// Path of the field, e.g. `line 12` or `sample_rate_hz`.
        field: String,
        /// The problem with it.
        problem: String,
        /// The values that would be accepted.
        remedy: String,
    },
    /// Receivers and ranges that do not determine a position.
    #[error("geometry: {problem}; move a receiver, or measure again")]
    Degenerate {
        /// The degenerate part of the geometry.
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

    /// An [`Error::Degenerate`] from anything that prints.
    pub fn degenerate(problem: impl std::fmt::Display) -> Self {
        Self::Degenerate {
            problem: problem.to_string(),
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
