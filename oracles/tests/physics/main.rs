//! The field against laws of physics, one law per file. Each header names the layout, the formula, the known bias and
//! the tolerance.
//!
//! `cargo test --release -p oracles --test physics -- --nocapture` prints the measurements.

mod rig;

mod absorbing_layer;
mod absorption;
mod box_modes;
mod branched_wall;
mod coincident_pair;
mod corner;
mod cropped_domain;
mod determinism;
mod dispersion;
mod doppler;
mod drift;
mod energy;
mod free_field;
mod free_field_segments;
mod half_plane;
mod image_echo;
mod impedance_wall;
mod late_time;
mod reciprocity;
mod round_wall;
mod scene_echoes;
mod spectrum;
mod stability;
mod tilted_wall;
