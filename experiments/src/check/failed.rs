//! The error of a check that did not pass.

/// A check did not pass; its table has been printed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CheckFailed(
    /// One line that names the failure.
    pub String,
);

impl std::fmt::Display for CheckFailed {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl std::error::Error for CheckFailed {}
