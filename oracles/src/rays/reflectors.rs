//! The rigid faces of finite wall segments and what they hide.
//!
//! A wall of thickness `T` shows two faces, one on each side, at `T/2` from its centre line (see [`super::joints`] for
//! how they end where walls meet). The short faces at free ends are left out: they are narrower than a wavelength.

use super::face::Face;
use super::joints::faces_of;
use super::plane::{Vec2, cross, length, sub};
use super::wall_segment::{TOUCH_M, WallSegment, distance_m};
use fdtd::walls::Wall;

/// Wall segments with their faces, ready for tracing.
#[derive(Debug, Clone, PartialEq)]
pub struct Reflectors {
    segments: Vec<WallSegment>,
    faces: Vec<Face>,
    /// Whether two segments touch, `[first * count + second]`.
    touching: Vec<bool>,
}

impl Reflectors {
    /// Faces of a set of segments. Pieces without length are ignored, and so are those that lie wholly on another.
    pub fn new(segments: impl IntoIterator<Item = WallSegment>) -> Self {
        let drawn: Vec<WallSegment> = segments
            .into_iter()
            .filter(|segment| length(sub(segment.ends_m[1], segment.ends_m[0])) > 0.0)
            .collect();
        let is_covered = |index: usize| {
            drawn.iter().enumerate().any(|(other, wall)| {
                // Of two that cover each other the first stays.
                let first = other < index || !drawn[index].covers(wall);
                other != index && first && wall.covers(&drawn[index])
            })
        };
        let segments: Vec<WallSegment> = (0..drawn.len())
            .filter(|&index| !is_covered(index))
            .map(|index| drawn[index])
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
                .map(move |(piece, ends_m)| WallSegment {
                    wall,
                    piece,
                    ends_m,
                    thickness_m: drawn.thickness_m,
                })
        });
        Self::new(pieces)
    }

    /// The wall pieces.
    pub fn segments(&self) -> &[WallSegment] {
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

    /// All face sequences up to `max_order` reflections along which sound can travel at all, shortest first: each next
    /// face lies at least partly in front of the one before, and the other way round.
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

    /// Share of a leg from `from_m` to `to_m` that gets past the walls, 1 free and 0 blocked. It passes by one half
    /// when the leg grazes a wall's end and changes within `fade_m` on either side of it. The segments `through` do not
    /// hide it.
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
