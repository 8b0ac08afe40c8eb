//! Verdicts on a summary: against a baseline (regression gate) and against the paper's claims.

pub mod gate;
pub mod readme;
pub mod report;
pub mod targets;
pub mod verdicts;

mod failed;
mod rules;

pub use self::failed::CheckFailed;
