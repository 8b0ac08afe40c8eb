//! Where the faces of walls end: at free ends, at mitred joints, and inside other walls.
//!
//! Where two segments share an end, their faces are cut or prolonged to meet at the mitre, so that a closed corner has
//! its apex where the wall's surface has it and not where the centre lines meet. Where walls overlap otherwise (two
//! walls drawn into each other, a wall that ends in the middle of another), parts inside the other wall are cut out.

use super::face::Face;
use super::plane::{Vec2, add, cross, dot, left_of, length, scale, sub};
use super::wall_segment::WallSegment;

/// Two ends closer than this are one joint, in metres, unless the walls are thicker: then half the thickness.
const JOINT_TOLERANCE_M: f64 = 1e-6;

/// Ends of a face within this distance of a line lie on it, in metres.
const SAME_LINE_M: f64 = 2e-6;

/// Faces shorter than this are crumbs of the cutting, in metres.
const SHORTEST_M: f64 = 1e-6;

/// All faces of a set of segments.
pub(super) fn faces_of(segments: &[WallSegment]) -> Vec<Face> {
    let all = (0..segments.len())
        .flat_map(|index| [1.0, -1.0].map(|side| mitred(segments, index, side)))
        .flat_map(|face| visible_pieces(segments, face));
    let mut faces: Vec<Face> = Vec::new();
    for face in all {
        // Walls drawn over each other have one surface, which reflects once.
        let covered: Vec<[f64; 2]> = faces
            .iter()
            .filter_map(|before| common(&face, before))
            .collect();
        faces.extend(without(&face, &covered));
    }
    faces
}

/// Interval of a face, in metres from its start, on which another face lies with its front to the same side.
fn common(face: &Face, other: &Face) -> Option<[f64; 2]> {
    let ends = [other.start_m, other.end_m()];
    let same = dot(face.normal, other.normal) > 0.0
        && ends
            .iter()
            .all(|&end| face.height_m(end).abs() <= SAME_LINE_M);
    let [one, two] = ends.map(|end| dot(sub(end, face.start_m), face.along));
    let (low, high) = (one.min(two).max(0.0), one.max(two).min(face.length_m));
    (same && high - low > SHORTEST_M).then_some([low, high])
}

/// The face on one side (+1 left of the centre line's direction, -1 right) between its joints.
fn mitred(segments: &[WallSegment], index: usize, side: f64) -> Face {
    let segment = &segments[index];
    let [a, b] = segment.ends_m;
    let extent = sub(b, a);
    let full_m = length(extent);
    let along = scale(extent, 1.0 / full_m);
    let normal = scale(left_of(along), side);
    let cut_start_m = mitre_m(segments, index, a, along, normal);
    let cut_end_m = mitre_m(segments, index, b, scale(along, -1.0), normal);
    Face {
        segment: index,
        start_m: add(
            add(a, scale(normal, 0.5 * segment.thickness_m)),
            scale(along, cut_start_m),
        ),
        along,
        normal,
        length_m: full_m - cut_start_m - cut_end_m,
    }
}

/// The parts of a face that are not inside other walls.
fn visible_pieces(segments: &[WallSegment], face: Face) -> Vec<Face> {
    let hidden: Vec<[f64; 2]> = segments
        .iter()
        .enumerate()
        .filter(|&(index, _)| index != face.segment)
        .filter_map(|(_, other)| inside(&face, other))
        .collect();
    without(&face, &hidden)
}

/// The parts of a face outside of intervals, in metres from its start.
fn without(face: &Face, intervals: &[[f64; 2]]) -> Vec<Face> {
    let mut pieces = vec![[0.0, face.length_m]];
    for &[from, to] in intervals {
        pieces = pieces
            .into_iter()
            .flat_map(|[low, high]| [[low, high.min(from)], [low.max(to), high]])
            .collect();
    }
    pieces
        .into_iter()
        .filter(|[low, high]| high - low > SHORTEST_M)
        .map(|[low, high]| Face {
            start_m: add(face.start_m, scale(face.along, low)),
            length_m: high - low,
            ..*face
        })
        .collect()
}

/// Interval of a face's line, in metres from its start, that lies in the rectangle of a wall.
fn inside(face: &Face, wall: &WallSegment) -> Option<[f64; 2]> {
    let extent = sub(wall.ends_m[1], wall.ends_m[0]);
    let full_m = length(extent);
    let axis = scale(extent, 1.0 / full_m);
    let offset = sub(face.start_m, wall.ends_m[0]);
    // On the rim is outside: faces that lie on each other stay.
    let half_m = 0.5 * wall.thickness_m - SHORTEST_M;
    let slabs = [
        (
            dot(offset, axis),
            dot(face.along, axis),
            [SHORTEST_M, full_m - SHORTEST_M],
        ),
        (
            cross(axis, offset),
            cross(axis, face.along),
            [-half_m, half_m],
        ),
    ];
    let mut interval = [f64::NEG_INFINITY, f64::INFINITY];
    for (at, slope, [low, high]) in slabs {
        if slope.abs() < 1e-12 {
            if at <= low || at >= high {
                return None;
            }
            continue;
        }
        let (one, other) = ((low - at) / slope, (high - at) / slope);
        interval = [
            interval[0].max(one.min(other)),
            interval[1].min(one.max(other)),
        ];
    }
    (interval[0] < interval[1]).then_some(interval)
}

fn joint_tolerance_m(one: &WallSegment, other: &WallSegment) -> f64 {
    JOINT_TOLERANCE_M.max(0.5 * one.thickness_m.min(other.thickness_m))
}

/// How much of a face the joint at `joint_m` takes away (or adds, negative), in metres. `away` is the unit vector from
/// the joint along the segment.
fn mitre_m(segments: &[WallSegment], index: usize, joint_m: Vec2, away: Vec2, normal: Vec2) -> f64 {
    let own = &segments[index];
    // Turning from this segment towards the face's side, the first other segment met bounds the same free sector.
    let neighbour = segments
        .iter()
        .enumerate()
        .filter(|&(other, _)| other != index)
        .flat_map(|(_, other)| {
            let [p, q] = other.ends_m;
            [(p, q), (q, p)].map(|(near, far)| (near, sub(far, near), other))
        })
        .filter(|(near, _, other)| length(sub(*near, joint_m)) <= joint_tolerance_m(own, other))
        .map(|(_, direction, other)| {
            let turn = dot(direction, normal).atan2(dot(direction, away));
            (turn.rem_euclid(std::f64::consts::TAU), other.thickness_m)
        })
        // A wall drawn over this one is not its neighbour.
        .filter(|(turn, _)| turn.sin().abs() > 1e-6 || turn.cos() < 0.0)
        .min_by(|one, other| one.0.total_cmp(&other.0));
    let Some((turn_rad, neighbour_thickness_m)) = neighbour else {
        return 0.0;
    };
    let (sine, cosine) = turn_rad.sin_cos();
    if sine.abs() < 1e-6 {
        return 0.0;
    }
    let cut_m = 0.5 * (neighbour_thickness_m + own.thickness_m * cosine) / sine;
    // A sharp outer corner would be prolonged without end: the wall's joint is round there.
    cut_m.max(-own.thickness_m)
}
