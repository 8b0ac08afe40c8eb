//! Specular sound rays between two points among rigid walls.
//!
//! The papers compare measured echoes with ray theory (single, corner and double reflections); [`crate::image_source`]
//! adds up the same paths. Each wall piece reflects on both sides, at its face and not at its centre
//! line.

mod face;
mod joints;
pub(crate) mod plane;
mod reflectors;
mod wall_segment;

pub use face::Face;
pub use reflectors::Reflectors;
pub(crate) use reflectors::fade;
pub use wall_segment::WallSegment;

use plane::{Vec2, add, bearing_rad, dot, length, scale, sub};

/// Beyond this the reflection point no longer counts as on the face, in metres.
const ON_FACE_M: f64 = 1e-6;

/// Walls that a path met on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RayKind {
    /// No wall.
    Direct,
    /// One wall.
    Single,
    /// Two walls that touch: with a right angle between them the sound comes back to where it started.
    Corner,
    /// Two walls that do not touch.
    Double,
    /// Three walls or more.
    Multiple,
}

impl RayKind {
    /// Name in data files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Single => "single",
            Self::Corner => "corner",
            Self::Double => "double",
            Self::Multiple => "multiple",
        }
    }
}

/// One specular path from a source to a receiver.
#[derive(Debug, Clone, PartialEq)]
pub struct RayPath {
    /// Walls that it met.
    pub kind: RayKind,
    /// The walls in the order the sound meets them: (wall, piece of its polyline).
    pub walls: Vec<(usize, usize)>,
    /// Source, reflection points, receiver, in metres.
    pub points_m: Vec<[f64; 2]>,
    /// Length in metres.
    pub length_m: f64,
    /// World direction in which the sound leaves the source, radians, -pi..pi.
    pub departure_rad: f64,
    /// World direction from the receiver towards where the sound comes from, radians, -pi..pi.
    pub arrival_rad: f64,
    /// Distance of the reflection point nearest to an end of its face from that end, in metres, negative beyond it.
    /// Infinite without reflection.
    pub clearance_m: f64,
    /// Where the sound seems to come from: the last image of the source, in metres.
    pub image_m: [f64; 2],
}

impl RayPath {
    /// Number of reflections.
    pub fn order(&self) -> usize {
        self.walls.len()
    }

    /// Whether it is a reflection in a corner.
    pub fn is_corner(&self) -> bool {
        self.kind == RayKind::Corner
    }
}

/// Selection of the paths of [`trace`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TraceOptions {
    /// Most reflections.
    pub max_order: usize,
    /// How far beyond the end of a face a reflection point may lie, in metres. A corner of 92 degrees sends no ray
    /// straight back, yet within some centimetres of its apex the sound does not care; 0 is strict.
    pub slack_m: f64,
}

impl Default for TraceOptions {
    fn default() -> Self {
        Self {
            max_order: 2,
            slack_m: 0.0,
        }
    }
}

/// All visible specular paths from `source_m` to `receiver_m` with up to `max_order` reflections, lowest order first;
/// the direct path is first when no wall is between the points. Two orders of the same walls that give the same image
/// (a right-angled corner and a pair in one point) count once.
///
/// ```
/// use fdtd::walls::Wall;
/// use oracles::rays::{Reflectors, TraceOptions, trace};
///
/// let wall = Wall { points_m: vec![[0.0, 1.0], [4.0, 1.0]], thickness_m: 0.0, impedance: None };
/// let paths = trace(&Reflectors::of(&[wall]), [1.0, 0.0], [2.0, 0.0], &TraceOptions::default());
/// // The direct path, and the one by the wall from the image at y = 2 m.
/// assert_eq!(paths.len(), 2);
/// assert!((paths[1].length_m - 5.0_f64.sqrt()).abs() < 1e-12);
/// ```
pub fn trace(
    reflectors: &Reflectors,
    source_m: [f64; 2],
    receiver_m: [f64; 2],
    options: &TraceOptions,
) -> Vec<RayPath> {
    let sequences = std::iter::once(Vec::new()).chain(reflectors.sequences(options.max_order));
    let mut paths: Vec<RayPath> = Vec::new();
    for sequence in sequences {
        let Some(unfolded) =
            reflectors.unfold(&sequence, source_m, receiver_m, options.slack_m + ON_FACE_M)
        else {
            continue;
        };
        if unfolded.clearance_m < -options.slack_m - ON_FACE_M
            || reflectors.leg_transmission(&sequence, &unfolded, 0.0) < 0.5
        {
            continue;
        }
        let path = reflectors.describe(&sequence, unfolded);
        let seen = paths.iter().any(|other| {
            other.order() == path.order()
                && other.walls.iter().rev().eq(path.walls.iter())
                && length(sub(other.image_m, path.image_m)) < 2.0 * ON_FACE_M
        });
        if !seen || path.order() < 2 {
            paths.push(path);
        }
    }
    paths
}

/// A face sequence laid out for one pair of points.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unfolded {
    pub(crate) points_m: Vec<Vec2>,
    pub(crate) image_m: Vec2,
    pub(crate) clearance_m: f64,
}

impl Reflectors {
    /// Image of a point in a face sequence: mirrored in the first face, that image in the second, and so on.
    pub fn image(&self, sequence: &[usize], point_m: [f64; 2]) -> [f64; 2] {
        sequence
            .iter()
            .fold(point_m, |image, &face| self.faces()[face].mirror(image))
    }

    /// Reflection points of a sequence, walking back from the receiver. None when an image lies on the wrong side of a
    /// face, or when the reflection points are out of order by more than `slack_m`; their clearance is the caller's to
    /// judge.
    pub(crate) fn unfold(
        &self,
        sequence: &[usize],
        source_m: Vec2,
        receiver_m: Vec2,
        slack_m: f64,
    ) -> Option<Unfolded> {
        let mut images = Vec::with_capacity(sequence.len() + 1);
        images.push(source_m);
        for &face in sequence {
            let face = &self.faces()[face];
            let image = *images.last()?;
            if face.height_m(image) <= 1e-9 {
                return None;
            }
            images.push(face.mirror(image));
        }
        let image_m = *images.last()?;
        let mut points_m = vec![receiver_m];
        let mut clearances_m = Vec::with_capacity(sequence.len());
        let mut towards = receiver_m;
        for (&face, &image) in sequence.iter().zip(&images[1..]).rev() {
            let face = &self.faces()[face];
            let (height_m, depth_m) = (face.height_m(towards), -face.height_m(image));
            // Only reflection points next to a joint may be behind the other face by a little.
            let least_m = if points_m.len() == 1 { 1e-9 } else { -slack_m };
            if height_m < least_m || height_m + depth_m <= 1e-9 {
                return None;
            }
            let point = add(
                towards,
                scale(sub(image, towards), height_m / (height_m + depth_m)),
            );
            clearances_m.push(face.clearance_m(point));
            points_m.push(point);
            towards = point;
        }
        points_m.push(source_m);
        points_m.reverse();
        clearances_m.reverse();
        Some(Unfolded {
            points_m,
            image_m,
            clearance_m: self.least_clearance_m(sequence, &clearances_m),
        })
    }

    /// The clearance that decides whether a path is visible: the least of all bounces.
    ///
    /// In a right-angled corner both orders of the walls give the same image, and one is visible where the other is
    /// not: their clearances are opposite, bounce by bounce. For theirs to be opposite as well, two bounces beyond the
    /// ends of joined faces count by the one that is less far beyond.
    fn least_clearance_m(&self, sequence: &[usize], clearances_m: &[f64]) -> f64 {
        let mut least_m = clearances_m.last().copied().unwrap_or(f64::INFINITY);
        let segment = |bounce: usize| self.faces()[sequence[bounce]].segment;
        for (bounce, pair) in clearances_m.windows(2).enumerate() {
            let both_beyond = pair[0] < 0.0 && pair[1] < 0.0;
            let counts_m = if both_beyond && self.are_joined(segment(bounce), segment(bounce + 1)) {
                pair[0].max(pair[1])
            } else {
                pair[0].min(pair[1])
            };
            least_m = if bounce == 0 {
                counts_m
            } else {
                least_m.min(counts_m)
            };
        }
        least_m
    }

    /// Share of a path that no wall hides, 0..1.
    ///
    /// Walls do not hide the legs that end on them. Neither does the other wall of a corner hide the way in or out,
    /// when that starts or ends in front of it: only a reflection point beyond the apex, which fades anyway, would be
    /// hidden.
    pub(crate) fn leg_transmission(
        &self,
        sequence: &[usize],
        unfolded: &Unfolded,
        fade_m: f64,
    ) -> f64 {
        let points_m = &unfolded.points_m;
        let face = |bounce: usize| sequence.get(bounce).map(|&face| &self.faces()[face]);
        let in_corner = |of: Option<&Face>, other: Option<&Face>, outer_m: Vec2| {
            let (of, other) = (of?, other?);
            let apart = self.are_joined(of.segment, other.segment) && other.height_m(outer_m) > 0.0;
            apart.then_some(other.segment)
        };
        // Leg k lies between bounces k - 1 and k.
        (0..points_m.len() - 1)
            .map(|leg| {
                let before = |back: usize| leg.checked_sub(back).and_then(face);
                let through = [
                    before(1).map(|face| face.segment),
                    face(leg).map(|face| face.segment),
                    in_corner(face(leg), face(leg + 1), points_m[leg]),
                    in_corner(before(1), before(2), points_m[leg + 1]),
                ];
                self.transmission(points_m[leg], points_m[leg + 1], &through, fade_m)
            })
            .product()
    }

    fn describe(&self, sequence: &[usize], unfolded: Unfolded) -> RayPath {
        let points = &unfolded.points_m;
        let segments: Vec<usize> = sequence
            .iter()
            .map(|&face| self.faces()[face].segment)
            .collect();
        let kind = match segments.as_slice() {
            [] => RayKind::Direct,
            [_] => RayKind::Single,
            [one, other] if self.are_joined(*one, *other) => RayKind::Corner,
            [_, _] => RayKind::Double,
            _ => RayKind::Multiple,
        };
        let receiver = points[points.len() - 1];
        RayPath {
            kind,
            walls: segments
                .iter()
                .map(|&s| (self.segments()[s].wall, self.segments()[s].piece))
                .collect(),
            length_m: length(sub(receiver, unfolded.image_m)),
            departure_rad: bearing_rad(departure(self, sequence, unfolded.image_m, receiver)),
            arrival_rad: bearing_rad(sub(unfolded.image_m, receiver)),
            clearance_m: unfolded.clearance_m,
            image_m: unfolded.image_m,
            points_m: unfolded.points_m,
        }
    }
}

/// Direction of the first leg: the straight line from the last image to the receiver, folded back face by face. Unlike
/// the difference of the first two points it is defined when those coincide.
fn departure(reflectors: &Reflectors, sequence: &[usize], image_m: Vec2, receiver_m: Vec2) -> Vec2 {
    sequence
        .iter()
        .rev()
        .fold(sub(receiver_m, image_m), |direction, &face| {
            let normal = reflectors.faces()[face].normal;
            sub(direction, scale(normal, 2.0 * dot(direction, normal)))
        })
}

#[cfg(test)]
mod tests;
