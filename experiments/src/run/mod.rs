//! One run of the program: its preset, progress, interruption and provenance.

pub mod interrupt;
pub mod preset;
pub mod progress;
pub mod project;
pub mod provenance;
