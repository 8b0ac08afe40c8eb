//! A measurement of a law.

use oracles::laws::Measurement;
use serde::Serialize;

/// A measurement of a law: one line of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The law.
    pub law: &'static str,
    /// The measurement.
    #[serde(flatten)]
    pub measurement: Measurement,
    /// Whether it is within its range.
    pub passed: bool,
}
