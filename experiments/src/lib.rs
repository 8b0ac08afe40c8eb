//! The papers' studies: simulate recordings, localize, measure, draw, check; behind the command line tool `echolot`.

pub mod atomic;
pub mod bench;
pub mod cache;
pub mod check;
pub mod cli;
mod click;
pub mod figures;
pub mod interrupt;
pub mod laboratory;
pub mod metrics;
pub mod multipath;
pub mod noise;
pub mod preset;
pub mod progress;
pub mod provenance;
pub mod robot;
pub mod schedule;
pub mod simulate;
pub mod study;
pub mod summary;
pub mod table;
pub mod trials;
pub mod ultrasound;
pub mod validate;

/// The Rust examples of the project's README, compiled as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
