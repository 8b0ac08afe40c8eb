//! A convex room in three dimensions: its faces, and which sequences of reflections join two points.
//!
//! In a convex room nothing hides anything, so a sequence of faces gives an echo exactly when every reflection point
//! lies on its face, that is, inside all the other ones.

mod echoes;
mod faces;

pub use echoes::{RoomPair, SpatialPositionAt, synthesize};
pub use faces::{Room, RoomFace};

#[cfg(test)]
mod tests;
