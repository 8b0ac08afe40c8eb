//! Frequencies and angles of incidence for which the weights of surfaces are designed.

use std::f64::consts::TAU;

/// Wave number in radians per cell up to which weights are designed for the wide schemes: 11 kHz on the papers' grid.
/// For the 5-point scheme, whose group velocity is less accurate, it is half of it.
pub(super) const BAND_EDGE: f64 = TAU * 11e3 / 340.0 * 0.005;

/// Cosines of the angles of incidence: 0, 30, 60 and 75 degrees.
pub(super) const COSINES: [f64; 4] = [1.0, 0.866, 0.5, 0.259];
