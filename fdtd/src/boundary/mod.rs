//! Walls of an impedance: the reaction of their surfaces on the field, and the design of its weights.
//!
//! A surface element ([`crate::walls::Load`]) samples the pressure in cells before it, and takes its flow from the
//! same cells with the same weights. Each file depends on files above it only:
//! * `branches`: time stepping of branches of resistance, inertance and compliance;
//! * `surface`: a surface as a step of the field uses it;
//! * `linear`: linear equations;
//! * `surface_element`: a surface element with its weights;
//! * `band`: frequencies and angles for which weights are designed;
//! * `half_line`: plane waves before axis-parallel walls on the grid;
//! * `axis_kernel`, `column`: weights and cells before axis-parallel walls, and nearly parallel ones;
//! * `slanted_kernel`: weights before slanted walls;
//! * `added_mass`: mass of air before a surface element;
//! * `passivity`: least mass with which no surface makes energy;
//! * `design`: all surfaces of a grid.

mod added_mass;
mod axis_kernel;
mod band;
mod branches;
mod column;
mod design;
mod half_line;
mod linear;
mod passivity;
mod slanted_kernel;
mod surface;
mod surface_element;

pub use branches::Branches;
pub use design::surfaces;
pub use surface::{Reaction, Surface, Surfaces};
