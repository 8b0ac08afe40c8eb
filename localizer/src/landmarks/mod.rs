//! Landmarks: walls and corners learnt from their Doppler echoes, and the pose followed among them.
//!
//! The images of the papers tell echoes apart on a grid of 0.1 m. The same blocks hold the range of each echo to
//! millimetres. Here each peak of H(delay, direction) is read between the samples ([`peaks`]), a drive with known
//! poses turns them into walls and points ([`mod@learn`]), and a filter follows the pose among these ([`filter`]).

mod expectation;
pub mod filter;
mod fit;
mod hough;
pub mod hypothesis;
pub mod landmark;
pub mod learn;
pub mod localizer;
pub mod map;
pub mod peaks;
mod search;
pub mod sighting;
#[cfg(test)]
pub(crate) mod simulated;
pub(crate) mod track;

pub use filter::{LandmarkFilter, Start, Status};
pub use hypothesis::Noise;
pub use landmark::Shape;
pub use learn::{Learner, learn};
pub use localizer::{Estimate, LandmarkLocalizer, LandmarkTracker, localize};
pub use map::{Landmark, LandmarkMap, Visibility};
pub use sighting::Sighting;

/// Periods M of a block for landmarks: enough to tell directions apart, and a pose that is hardly old.
pub const PERIODS: usize = 2;
