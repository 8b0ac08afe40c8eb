//! Small vector helpers of the plane.

/// A point or vector in metres.
pub(crate) type Vec2 = [f64; 2];

pub(crate) fn add(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] + b[0], a[1] + b[1]]
}

pub(crate) fn sub(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] - b[0], a[1] - b[1]]
}

pub(crate) fn scale(a: Vec2, factor: f64) -> Vec2 {
    [a[0] * factor, a[1] * factor]
}

pub(crate) fn dot(a: Vec2, b: Vec2) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// z component of the cross product, positive when `b` lies counter-clockwise of `a`.
pub(crate) fn cross(a: Vec2, b: Vec2) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(crate) fn length(a: Vec2) -> f64 {
    a[0].hypot(a[1])
}

/// The vector turned left by a right angle.
pub(crate) fn left_of(a: Vec2) -> Vec2 {
    [-a[1], a[0]]
}

/// Direction of a vector in radians, -pi..pi, counter-clockwise from +x.
pub(crate) fn bearing_rad(a: Vec2) -> f64 {
    a[1].atan2(a[0])
}
