//! Paths of sound back to a place of a scene, and the echoes that stand alone there.
//!
//! An echo is that of its image only where the wave meets whole walls. An end of a wall diffracts; the wave that it
//! scatters goes from wall to wall like any other and comes back by the rays through the end. Its way is longer than
//! that of an echo by half a wavelength when the end lies at the border of the echo's first Fresnel zone, and by
//! nothing when the echo is reflected, or passes, right there: whether an edge diffracts into an echo follows from the
//! lengths of the ways alone. So all ways are listed here: by walls, and by walls and one end of a wall anywhere among
//! them. Ends that scatter one after the other are left out: at 8 kHz each takes some 30 dB, except where the second
//! lies on the border of the first one's rays, which the slack allows for.

use crate::rays::{RayPath, Reflectors, TraceOptions, trace};

/// Least difference of path between a compared echo and all other arrivals, in metres.
pub(super) const APART_M: f64 = 0.3;
/// Longest path compared, in metres.
const LONGEST_M: f64 = 9.0;
/// Most reflections on a way by walls.
const MAX_ORDER: usize = 4;
/// Most reflections on a way by an edge, before and behind it together.
const MAX_ORDER_BY_EDGE: usize = 3;
/// How far beyond a wall's end a way may be reflected, or how far behind it pass, in metres: sound does not end sharply
/// there.
const SLACK_M: f64 = 0.4;

/// A way from a place back to it.
#[derive(Debug, Clone, PartialEq)]
struct Arrival {
    length_m: f64,
    /// The walls on the way, as in [`RayPath`]; those by an edge do not need them.
    walls: Vec<(usize, usize)>,
    /// The end of a wall that scatters on the way, if one does.
    edge_m: Option<[f64; 2]>,
}

impl Arrival {
    /// Whether this is the ray, either way round.
    fn is(&self, ray: &RayPath) -> bool {
        self.edge_m.is_none()
            && (self.length_m - ray.length_m).abs() < 1e-6
            && same_walls(&self.walls, &ray.walls)
    }
}

/// Whether two ways meet the same walls in the same order or its reverse.
fn same_walls(one: &[(usize, usize)], other: &[(usize, usize)]) -> bool {
    one == other || one.iter().rev().eq(other)
}

/// Those of the sequences of faces by which sound comes from one point to another, with slack, and how long these ways
/// are in metres.
fn ways<'a>(
    reflectors: &Reflectors,
    from_m: [f64; 2],
    to_m: [f64; 2],
    sequences: &'a [Vec<usize>],
) -> Vec<(&'a [usize], f64)> {
    let length_m = |sequence: &[usize]| {
        let way = reflectors.unfold(sequence, from_m, to_m, SLACK_M)?;
        let there = way.clearance_m > -SLACK_M
            && reflectors.leg_transmission(sequence, &way, SLACK_M) > 0.0;
        there.then(|| (way.image_m[0] - to_m[0]).hypot(way.image_m[1] - to_m[1]))
    };
    sequences
        .iter()
        .filter_map(|sequence| Some((sequence.as_slice(), length_m(sequence)?)))
        .collect()
}

/// All ways from a place back to it.
fn arrivals(reflectors: &Reflectors, place_m: [f64; 2]) -> Vec<Arrival> {
    let sequences = reflectors.sequences(MAX_ORDER);
    let wall = |&face: &usize| {
        let segment = &reflectors.segments()[reflectors.faces()[face].segment];
        (segment.wall, segment.piece)
    };
    let mut found: Vec<Arrival> = ways(reflectors, place_m, place_m, &sequences)
        .into_iter()
        .map(|(sequence, length_m)| Arrival {
            length_m,
            walls: sequence.iter().map(wall).collect(),
            edge_m: None,
        })
        .collect();
    let straight_or_few: Vec<Vec<usize>> = std::iter::once(Vec::new())
        .chain(sequences)
        .filter(|sequence| sequence.len() <= MAX_ORDER_BY_EDGE)
        .collect();
    for edge_m in reflectors.free_ends_m() {
        let there = ways(reflectors, place_m, edge_m, &straight_or_few);
        for (at, (out, out_m)) in there.iter().enumerate() {
            // Back by the same way or another; the other way round is as long.
            let back = there[at..]
                .iter()
                .filter(|(back, _)| out.len() + back.len() <= MAX_ORDER_BY_EDGE);
            found.extend(back.map(|(_, back_m)| Arrival {
                length_m: out_m + back_m,
                walls: Vec::new(),
                edge_m: Some(edge_m),
            }));
        }
    }
    found
}

/// Rays that met one wall or two.
pub(super) fn rays(reflectors: &Reflectors, place_m: [f64; 2]) -> Vec<RayPath> {
    let options = TraceOptions {
        max_order: 2,
        slack_m: 0.0,
    };
    let mut rays = trace(reflectors, place_m, place_m, &options);
    rays.retain(|ray| ray.order() > 0);
    rays
}

/// Those of the [`rays`] that no other arrival comes near.
pub(super) fn alone(reflectors: &Reflectors, place_m: [f64; 2]) -> Vec<RayPath> {
    let others = arrivals(reflectors, place_m);
    let mut found: Vec<RayPath> = Vec::new();
    for ray in rays(reflectors, place_m) {
        // A pair in one point receives both orders of a double echo at once; they are one echo, see `orders`.
        let known = |other: &RayPath| {
            (other.length_m - ray.length_m).abs() < 1e-6 && same_walls(&other.walls, &ray.walls)
        };
        if !found.iter().any(known) {
            found.push(ray);
        }
    }
    found.retain(|ray| {
        let apart =
            |other: &Arrival| other.is(ray) || (other.length_m - ray.length_m).abs() >= APART_M;
        (0.5..LONGEST_M).contains(&ray.length_m) && others.iter().all(apart)
    });
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::{RayKind, WallSegment};

    fn walls<const N: usize>(ends_m: [[[f64; 2]; 2]; N]) -> Reflectors {
        Reflectors::new(
            ends_m
                .into_iter()
                .enumerate()
                .map(|(wall, ends_m)| WallSegment {
                    wall,
                    piece: 0,
                    ends_m,
                    thickness_m: 0.02,
                }),
        )
    }

    fn kinds(reflectors: &Reflectors, place_m: [f64; 2]) -> Vec<RayKind> {
        let alone = alone(reflectors, place_m);
        alone.iter().map(|ray| ray.kind).collect()
    }

    #[test]
    fn an_echo_from_near_an_end_does_not_stand_alone() {
        let long = walls([[[0.0, 0.0], [3.0, 0.0]]]);
        assert_eq!(kinds(&long, [1.5, 0.5]), [RayKind::Single]);
        assert_eq!(rays(&long, [0.05, 0.5]).len(), 1);
        assert_eq!(kinds(&long, [0.05, 0.5]), []);
    }

    #[test]
    fn an_end_as_far_away_as_the_apex_diffracts_into_the_corners_echo() {
        // The corner of `scenes/four_walls.json`, its second wall as drawn and half a metre longer.
        let corner =
            |height_m: f64| walls([[[0.0, 0.0], [2.13, 0.0]], [[0.0, 0.0], [0.0, height_m]]]);
        let place_m = [2.613, 1.11];
        assert!(!kinds(&corner(2.24), place_m).contains(&RayKind::Corner));
        assert!(kinds(&corner(2.74), place_m).contains(&RayKind::Corner));
    }

    #[test]
    fn an_end_near_the_second_reflection_diffracts_into_a_double_echo() {
        // The two single walls of `scenes/four_walls.json`. The first has no echo of its own here, not even with slack,
        // yet sends sound on to the second one's end.
        let end_m = [3.611, 1.773];
        let walls = walls([[[1.172, 3.787], [3.312, 4.5]], [end_m, [4.233, 3.638]]]);
        let place_m = [1.318, 1.4036];
        let double = rays(&walls, place_m)
            .into_iter()
            .find(|ray| ray.kind == RayKind::Double)
            .expect("a double echo");
        assert!((0.0..0.03).contains(&double.clearance_m), "{double:?}");
        let late_m = |arrival: &Arrival| arrival.length_m - double.length_m;
        assert!(
            arrivals(&walls, place_m)
                .iter()
                .any(|one| one.edge_m == Some(end_m) && (0.0..0.03).contains(&late_m(one)))
        );
        assert_eq!(kinds(&walls, place_m), []);
    }

    #[test]
    fn two_walls_as_far_away_give_no_echo_that_stands_alone() {
        let corner = walls([[[0.0, 0.0], [3.0, 0.0]], [[0.0, 0.0], [0.0, 3.0]]]);
        assert_eq!(kinds(&corner, [1.0, 1.0]), [RayKind::Corner]);
        assert_eq!(kinds(&corner, [1.0, 1.4]).len(), 3);
    }

    #[test]
    fn a_closed_corner_has_two_edges() {
        let corner = walls([[[-0.01, 0.0], [1.5, 0.0]], [[0.0, -0.01], [0.0, 2.0]]]);
        assert_eq!(corner.free_ends_m(), [[1.5, 0.0], [0.0, 2.0]]);
    }
}
