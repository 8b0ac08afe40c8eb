//! The rig that tests and `echolot validate` share, and its measurements as assertions.

use fdtd::validation::Measurement;

pub(crate) use fdtd::validation::rig::*;

/// Prints the measurements of a law and asserts that all of them are within their tolerances.
pub(crate) fn assert_within(law: &str, found: &[Measurement]) {
    for measurement in found {
        println!(
            "{law}, {}: {} {:.4}",
            measurement.case, measurement.quantity, measurement.measured
        );
        assert!(measurement.passed(), "{law}: {measurement:?}");
    }
}
