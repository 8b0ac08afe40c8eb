//! A wall as drawn: a polyline with a thickness.

use crate::impedance::Impedance;

/// A wall, rigid or of an impedance: all points within half the thickness beside one of its segments, and round
/// joints where segments meet.
///
/// The ends are cut square, so a wall is as long as its points say. Give the first point again at the end to close it.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Corner points `[x, y]` of the middle line in metres, at least two.
    pub points_m: Vec<[f64; 2]>,
    /// Thickness in metres, across the middle line.
    pub thickness_m: f64,
    /// Impedance of its surface, which reacts locally; `None` is rigid.
    pub impedance: Option<Impedance>,
}

impl Wall {
    /// The segments of the middle line, `[from, to]` in metres.
    pub fn segments_m(&self) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
        self.points_m.windows(2).map(|pair| [pair[0], pair[1]])
    }

    /// Length of the middle line in metres.
    pub fn length_m(&self) -> f64 {
        self.segments_m().map(|[from, to]| distance(from, to)).sum()
    }

    /// Points at which segments meet: all but the ends, and the ends too when they coincide.
    pub fn joints_m(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let last = self.points_m.len().saturating_sub(1);
        let closed = last >= 2 && self.points_m[0] == self.points_m[last];
        let skip = usize::from(!closed);
        self.points_m.iter().copied().take(last).skip(skip)
    }

    /// The four corners in metres of the rectangle around a segment.
    pub fn outline_m(&self, [from, to]: [[f64; 2]; 2]) -> [[f64; 2]; 4] {
        let length = distance(from, to).max(f64::MIN_POSITIVE);
        let side = [
            -(to[1] - from[1]) / length * 0.5 * self.thickness_m,
            (to[0] - from[0]) / length * 0.5 * self.thickness_m,
        ];
        [
            [from[0] + side[0], from[1] + side[1]],
            [to[0] + side[0], to[1] + side[1]],
            [to[0] - side[0], to[1] - side[1]],
            [from[0] - side[0], from[1] - side[1]],
        ]
    }

    /// Whether a point in metres is in the wall.
    pub fn contains(&self, point_m: [f64; 2]) -> bool {
        self.segments_m()
            .any(|segment| self.beside(point_m, segment))
            || self.joints_m().any(|joint_m| self.joins(point_m, joint_m))
    }

    /// Distance in metres of a point from the wall's surface, negative within the wall.
    pub(super) fn distance_m(&self, point_m: [f64; 2]) -> f64 {
        let half_m = 0.5 * self.thickness_m;
        let segments = self.segments_m().map(|[from, to]| {
            let length = distance(from, to).max(f64::MIN_POSITIVE);
            let along = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
            let offset = [
                point_m[0] - 0.5 * (from[0] + to[0]),
                point_m[1] - 0.5 * (from[1] + to[1]),
            ];
            let forward = (offset[0] * along[0] + offset[1] * along[1]).abs() - 0.5 * length;
            let sideways = (offset[1] * along[0] - offset[0] * along[1]).abs() - half_m;
            forward.max(0.0).hypot(sideways.max(0.0)) + forward.max(sideways).min(0.0)
        });
        let joints = self
            .joints_m()
            .map(|joint_m| distance(point_m, joint_m) - half_m);
        segments.chain(joints).fold(f64::INFINITY, f64::min)
    }

    /// Whether a point in metres is in the rectangle around one segment.
    pub(super) fn beside(&self, point_m: [f64; 2], segment_m: [[f64; 2]; 2]) -> bool {
        in_rectangle(point_m, segment_m, 0.5 * self.thickness_m)
    }

    /// Whether a point in metres is in the round joint at `joint_m`.
    pub(super) fn joins(&self, point_m: [f64; 2], joint_m: [f64; 2]) -> bool {
        distance(point_m, joint_m) <= 0.5 * self.thickness_m
    }
}

/// Whether a point lies beside the segment and within `half_m` of its line; rims belong to the rectangle.
fn in_rectangle(point: [f64; 2], [from, to]: [[f64; 2]; 2], half_m: f64) -> bool {
    // Far below any cell width: a rim through cell centres must not depend on the last bit.
    const RIM_M: f64 = 1e-9;
    let length = distance(from, to);
    if length == 0.0 {
        return false;
    }
    let along = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
    let offset = [point[0] - from[0], point[1] - from[1]];
    let forward = offset[0] * along[0] + offset[1] * along[1];
    let sideways = offset[1] * along[0] - offset[0] * along[1];
    // Half open across, so that a wall of n cells lying on the grid's lines is n cells thick and not n + 1.
    (-RIM_M..=length + RIM_M).contains(&forward)
        && sideways >= -half_m - RIM_M
        && sideways < half_m - RIM_M
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
