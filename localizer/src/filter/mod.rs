//! The particle filter: motion model (eq. (8)), weights and expected pose (eqs. (17) and (18)), resampling.

pub mod motion_model;
pub mod particle_filter;
pub mod resampling;
pub mod tracker;
