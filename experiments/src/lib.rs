//! The papers' studies: simulate recordings, localize, measure, draw, check; behind the command line tool `echolot`.

pub mod atomic;
pub mod check;
pub mod figures;
pub mod interrupt;
pub mod metrics;
pub mod preset;
pub mod progress;
pub mod provenance;
pub mod summary;
pub mod table;
