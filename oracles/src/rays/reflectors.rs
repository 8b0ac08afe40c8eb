//! The rigid faces of finite wall segments and what they hide.
//!
//! A wall of thickness `T` shows two faces, one on each side, at `T/2` from its centre line (see [`super::faces`] for how they end where walls
//! meet). The short faces at free ends are left out: they are narrower than a wavelength.

use super::faces::faces_of;
use super::plane::{Vec2, add, cross, dot, length, scale, sub};
use fdtd::walls::Wall;

/// A leg crosses a wall when it reaches at least this far past it, in metres.
const TOUCH_M: f64 = 1e-6;

/// One straight piece of a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Which wall, counted as in the scene.
    pub wall: usize,
    /// Which piece of that wall's polyline.
    pub piece: usize,
    /// Ends of the centre line in metres.
    pub ends_m: [Vec2; 2],
    /// Thickness in metres, 0 or more.
    pub thickness_m: f64,
}

impl Segment {
    /// Whether it touches or overlaps another.
    fn touches(&self, other: &Self) -> bool {
        let reach_m = 0.5 * (self.thickness_m + other.thickness_m) + TOUCH_M;
        let ends = |of: &Self, to: &Self| {
            of.ends_m
                .iter()
                .any(|&end| distance_m(end, to.ends_m) <= reach_m)
        };
        ends(self, other) || ends(other, self) || self.crosses(other)
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
fn distance_m(point_m: Vec2, [a, b]: [Vec2; 2]) -> f64 {
    let along = sub(b, a);
    let share = (dot(sub(point_m, a), along) / dot(along, along)).clamp(0.0, 1.0);
    length(sub(point_m, add(a, scale(along, share))))
}

/// One reflecting side of a segment: a line segment with a front.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// Index of the segment it belongs to, in [`Reflectors::segments`]; a segment can have several on one side.
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

    fn end_m(&self) -> Vec2 {
        add(self.start_m, scale(self.along, self.length_m))
    }
}

/// Wall segments with their faces, ready for tracing.
#[derive(Debug, Clone, PartialEq)]
pub struct Reflectors {
    segments: Vec<Segment>,
    faces: Vec<Face>,
    /// Whether two segments touch, `[first * count + second]`.
    touching: Vec<bool>,
}

impl Reflectors {
    /// Faces of a set of segments. Pieces without length are ignored.
    pub fn new(segments: impl IntoIterator<Item = Segment>) -> Self {
        let segments: Vec<Segment> = segments
            .into_iter()
            .filter(|segment| length(sub(segment.ends_m[1], segment.ends_m[0])) > 0.0)
            .collect();
        let faces = faces_of(&segments);
        let touching = segments
            .iter()
            .flat_map(|one| segments.iter().map(|other| one.touches(other)))
            .collect();
        Self {
            segments,
            faces,
            touching,
        }
    }

    /// Faces of the walls of a scene.
    pub fn of(walls: &[Wall]) -> Self {
        let pieces = walls.iter().enumerate().flat_map(|(wall, drawn)| {
            drawn
                .segments_m()
                .enumerate()
                .map(move |(piece, ends_m)| Segment {
                    wall,
                    piece,
                    ends_m,
                    thickness_m: drawn.thickness_m,
                })
        });
        Self::new(pieces)
    }

    /// The wall pieces.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The reflecting faces.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Whether two segments touch or overlap.
    pub fn are_joined(&self, first: usize, second: usize) -> bool {
        self.touching[first * self.segments.len() + second]
    }

    /// Ends of segments that touch no other segment, in metres: the edges.
    pub(crate) fn free_ends_m(&self) -> Vec<Vec2> {
        let free = |index: usize, end: Vec2| {
            let own = &self.segments[index];
            self.segments.iter().enumerate().all(|(other, segment)| {
                let reach_m = 0.5 * (own.thickness_m + segment.thickness_m) + TOUCH_M;
                other == index || distance_m(end, segment.ends_m) > reach_m
            })
        };
        let ends = self.segments.iter().enumerate();
        ends.flat_map(|(index, segment)| segment.ends_m.map(|end| (index, end)))
            .filter(|&(index, end)| free(index, end))
            .map(|(_, end)| end)
            .collect()
    }

    /// All face sequences up to `max_order` reflections along which sound can travel at all, shortest first: each next face
    /// lies at least partly in front of the one before, and the other way round.
    pub fn sequences(&self, max_order: usize) -> Vec<Vec<usize>> {
        let mut all: Vec<Vec<usize>> = Vec::new();
        let mut longest: Vec<Vec<usize>> = vec![Vec::new()];
        for _ in 0..max_order {
            longest = longest
                .iter()
                .flat_map(|sequence| {
                    (0..self.faces.len())
                        .filter(|&next| {
                            sequence
                                .last()
                                .is_none_or(|&last| self.can_follow(last, next))
                        })
                        .map(|next| [sequence.as_slice(), &[next]].concat())
                })
                .collect();
            all.extend_from_slice(&longest);
        }
        all
    }

    fn can_follow(&self, last: usize, next: usize) -> bool {
        let sees = |front: &Face, other: &Face| {
            [other.start_m, other.end_m()]
                .iter()
                .any(|&p| front.height_m(p) > 1e-9)
        };
        let (last, next) = (&self.faces[last], &self.faces[next]);
        last.segment != next.segment && sees(last, next) && sees(next, last)
    }

    /// Share of a leg from `from_m` to `to_m` that gets past the walls, 1 free and 0 blocked. It passes by one half when the leg grazes a
    /// wall's end and changes within `fade_m` on either side of it. The segments `through` do not hide it.
    pub(crate) fn transmission(
        &self,
        from_m: Vec2,
        to_m: Vec2,
        through: &[Option<usize>],
        fade_m: f64,
    ) -> f64 {
        let leg = sub(to_m, from_m);
        let leg_length_m = length(leg);
        let mut hidden = 0.0;
        for (index, segment) in self.segments.iter().enumerate() {
            if through.contains(&Some(index)) {
                continue;
            }
            let wall = sub(segment.ends_m[1], segment.ends_m[0]);
            let determinant = cross(leg, wall);
            let wall_length_m = length(wall);
            if determinant.abs() <= 1e-12 * leg_length_m * wall_length_m {
                continue;
            }
            let offset = sub(segment.ends_m[0], from_m);
            let on_leg_m = cross(offset, wall) / determinant * leg_length_m;
            // A leg that only touches a wall with its end, as in the apex of a corner, is not hidden by it.
            if on_leg_m < TOUCH_M || on_leg_m > leg_length_m - TOUCH_M {
                continue;
            }
            let on_wall_m = cross(offset, leg) / determinant * wall_length_m;
            hidden += fade(on_wall_m.min(wall_length_m - on_wall_m), fade_m);
        }
        (1.0 - hidden).max(0.0)
    }
}

/// Smooth step: 0 below `-fade_m`, one half at 0, 1 above `+fade_m`; `fade(d) + fade(-d) = 1`.
pub(crate) fn fade(clearance_m: f64, fade_m: f64) -> f64 {
    if clearance_m >= fade_m {
        1.0
    } else if clearance_m <= -fade_m {
        0.0
    } else {
        0.5 + 0.5 * (std::f64::consts::FRAC_PI_2 * clearance_m / fade_m).sin()
    }
}
