//! The papers' studies: recordings are simulated, localized and measured; data files are drawn and checked. The command
//! line tool `echolot` is in [`cli`].

pub mod ape_rpe;
pub mod bag;
pub mod bench;
pub mod check;
pub mod cli;
pub mod data;
pub mod drive;
pub mod figures;
pub mod inspection;
pub mod live;
pub mod localization;
pub mod mapping;
pub mod metrics;
pub mod papers;
pub mod recordings;
pub mod report;
pub mod run;
pub mod schedule;
pub mod scores;
pub mod session;
pub mod study;
pub mod summary;
pub mod transmission;
pub mod trials;
pub mod trust;
pub mod validate;

/// The Rust examples of the project's README, compiled as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
