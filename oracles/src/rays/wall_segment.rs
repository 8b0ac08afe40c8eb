//! Straight parts of walls, and whether they touch.

use super::plane::{Vec2, add, cross, dot, length, scale, sub};

/// A leg crosses a wall when it reaches at least this far past it, in metres.
pub(super) const TOUCH_M: f64 = 1e-6;

/// A straight part of a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallSegment {
    /// Which wall, counted as in the scene.
    pub wall: usize,
    /// Index of the part in that wall's polyline.
    pub piece: usize,
    /// Ends of the centre line in metres.
    pub ends_m: [Vec2; 2],
    /// Thickness in metres, 0 or more.
    pub thickness_m: f64,
}

impl WallSegment {
    /// Whether it touches or overlaps another.
    pub(super) fn touches(&self, other: &Self) -> bool {
        let reach_m = 0.5 * (self.thickness_m + other.thickness_m) + TOUCH_M;
        let ends = |of: &Self, to: &Self| {
            of.ends_m
                .iter()
                .any(|&end| distance_m(end, to.ends_m) <= reach_m)
        };
        ends(self, other) || ends(other, self) || self.crosses(other)
    }

    /// Whether another lies wholly on it: on the same line, not beyond its ends, and not thicker.
    pub(super) fn covers(&self, other: &Self) -> bool {
        let thin = other.thickness_m <= self.thickness_m + TOUCH_M;
        thin && other
            .ends_m
            .iter()
            .all(|&end| distance_m(end, self.ends_m) <= TOUCH_M)
    }

    fn crosses(&self, other: &Self) -> bool {
        let splits = |[a, b]: [Vec2; 2], [p, q]: [Vec2; 2]| {
            let along = sub(b, a);
            cross(along, sub(p, a)) * cross(along, sub(q, a)) < 0.0
        };
        splits(self.ends_m, other.ends_m) && splits(other.ends_m, self.ends_m)
    }
}

/// Distance of a point from a line segment.
pub(super) fn distance_m(point_m: Vec2, [a, b]: [Vec2; 2]) -> f64 {
    let along = sub(b, a);
    let share = (dot(sub(point_m, a), along) / dot(along, along)).clamp(0.0, 1.0);
    length(sub(point_m, add(a, scale(along, share))))
}
