//! A reflecting side of a wall.

use super::plane::{Vec2, add, dot, scale, sub};

/// One reflecting side of a segment: a line segment with a front.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// Index of the segment it belongs to, in [`super::Reflectors::segments`]; a segment can have several on one side.
    pub segment: usize,
    /// One end in metres.
    pub start_m: Vec2,
    /// Unit vector from `start_m` along the face.
    pub along: Vec2,
    /// Unit vector out of the wall.
    pub normal: Vec2,
    /// Length in metres.
    pub length_m: f64,
}

impl Face {
    /// Distance of a point in front of the face's line in metres, negative behind it.
    pub fn height_m(&self, point_m: Vec2) -> f64 {
        dot(sub(point_m, self.start_m), self.normal)
    }

    /// Mirror image of a point in the face's line.
    pub fn mirror(&self, point_m: Vec2) -> Vec2 {
        add(point_m, scale(self.normal, -2.0 * self.height_m(point_m)))
    }

    /// How far inside the face's ends a point of its line lies, in metres; negative beyond an end.
    pub fn clearance_m(&self, point_m: Vec2) -> f64 {
        let position = dot(sub(point_m, self.start_m), self.along);
        position.min(self.length_m - position)
    }

    pub(super) fn end_m(&self) -> Vec2 {
        add(self.start_m, scale(self.along, self.length_m))
    }
}
