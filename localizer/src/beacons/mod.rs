//! Position of a transmitter from its distances to fixed receivers (Hsu et al., Sens. Mater. 2021, section 3).
//!
//! Three solutions of the same problem: [`Beacons::dual_circle`] intersects the circles around two receivers, eqs.
//! (1)-(17); [`Beacons::triangulate`] crosses two bearings that follow from the sides of triangles;
//! [`Beacons::least_squares`] minimizes the residuals of all ranges and gives the covariance. Two circles meet in two
//! points: the ranges of all receivers decide between them, so there must be three receivers that are not in line.

mod circles;
mod least_squares;
mod receivers;
#[cfg(test)]
mod tests;
mod triangulation;

pub use circles::intersections;
pub use least_squares::Fix;
pub use receivers::Beacons;
