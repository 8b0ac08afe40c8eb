//! Benchmarks: the field engines beside the peaks of the machine, the start of a field, where subnormal numbers are,
//! and the steps of the localizer.

pub mod engines;
pub mod localizer;
pub mod peaks;
pub mod subnormal;

mod case;
mod stopwatch;

pub use self::case::SMALLEST;
