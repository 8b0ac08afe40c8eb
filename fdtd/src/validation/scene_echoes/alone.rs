//! Rays of a scene, and which of them stand alone.

use crate::rays::{RayPath, Reflectors, TraceOptions, trace};

/// Least difference of path between a compared echo and all others, in metres.
pub(super) const APART_M: f64 = 0.3;
/// Longest path compared, in metres.
const LONGEST_M: f64 = 9.0;

/// Rays that met a wall, up to an order, with some slack at the ends of faces.
pub(super) fn rays(
    reflectors: &Reflectors,
    place_m: [f64; 2],
    max_order: usize,
    slack_m: f64,
) -> Vec<RayPath> {
    let options = TraceOptions { max_order, slack_m };
    let mut rays = trace(reflectors, place_m, place_m, &options);
    rays.retain(|ray| ray.order() > 0);
    rays
}

/// Rays of first and second order that no other arrival comes near.
pub(super) fn alone(reflectors: &Reflectors, place_m: [f64; 2]) -> Vec<RayPath> {
    let mut others: Vec<f64> = rays(reflectors, place_m, 4, 0.4)
        .iter()
        .map(|ray| ray.length_m)
        .collect();
    let single = rays(reflectors, place_m, 1, 0.4);
    for segment in reflectors.segments() {
        for [x, y] in segment.ends_m {
            let away_m = |[u, v]: [f64; 2]| (x - u).hypot(y - v);
            others.push(2.0 * away_m(place_m));
            others.extend(
                single
                    .iter()
                    .map(|ray| away_m(place_m) + away_m(ray.image_m)),
            );
        }
    }
    let mut found: Vec<RayPath> = Vec::new();
    for ray in rays(reflectors, place_m, 2, 0.0) {
        // A pair in one point hears both orders of a double echo at once; they are one echo, see `orders`.
        let known = |other: &RayPath| (other.length_m - ray.length_m).abs() < 1e-6;
        if !found.iter().any(known) {
            found.push(ray);
        }
    }
    found.retain(|ray| {
        // An end of the corner's walls is its apex, where the corner's own echo comes from.
        let same = |length_m: f64| (length_m - ray.length_m).abs() < 1e-6;
        let apex = |length_m: f64| ray.is_corner() && (length_m - ray.length_m).abs() < 0.06;
        let near = |length_m: f64| (length_m - ray.length_m).abs() < APART_M;
        (0.5..LONGEST_M).contains(&ray.length_m)
            && others
                .iter()
                .all(|&other| same(other) || apex(other) || !near(other))
    });
    found
}
