//! The rig that tests and `echolot validate` share.

pub(crate) use fdtd::validation::rig::*;
