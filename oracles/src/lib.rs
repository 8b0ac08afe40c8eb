//! Independent solutions that the sound field of [`fdtd`] is compared with, and the comparisons.
//!
//! * [`exact`]: solutions of the wave equation in the plane in closed form, as series or as integrals: moving line
//!   source, Doppler factors, half plane, cylinder;
//! * [`rays`]: specular rays between two points among rigid walls;
//! * [`image_source`]: the microphone's signal by image sources, among walls in the plane and in a convex room in three
//!   dimensions ([`image_source::room`]);
//! * [`laws`]: laws of physics as measurements with tolerances, which the tests assert and `echolot validate` prints.
//!
//! [`exact`], [`rays`] and [`image_source`] compute no field: from [`fdtd`] they take the description of a problem
//! (medium, walls, drives, waveforms), and the laws run the solver beside them. The solver uses nothing of this crate.

pub mod exact;
pub mod image_source;
pub mod laws;
pub mod rays;
