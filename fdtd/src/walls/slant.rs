//! Changes of the wave operator in cells that slanted walls cut, so that waves along a wall keep their phase wherever
//! the wall cuts the cells.
//!
//! *Small cells lack face area.* A triangle that a wall leaves of a cell has one open face along x and one along y,
//! and stability allows each less weight than its open part ([`super::cut_cells`]). That reduces the flow towards the
//! wall, which is small, but also the flow along the wall, which enters by one face and leaves by the other. A
//! [`Bridge`] between the two neighbours restores the difference: two faces in series of weights a and b pass
//! `a b/(a + b)`.
//!
//! *A and B are large where their sum is small.* Before a slanted wall the pressure varies along both axes, and in a
//! cut cell A and B each see the wall as the end of that variation: they grow as cells shrink. The wide schemes have
//! `b (A^2 + B^2) + m (AB + BA)/2 = (b/2 + m/4) (A + B)^2 + (b/2 - m/4) (A - B)^2`, whose last square acts as a
//! reactance along the wall. It is left out in cut cells: `(A - B) Q (A - B)` with Q zero there is still symmetric
//! and between zero and the full square, so that the bounds of the spectrum hold ([`crate::scheme::Polynomial`]).

use super::face_weights::FaceWeights;
use std::collections::BTreeMap;

/// Cosine of the angle between normal and nearest axis above which a wall counts as parallel to the axis (18 degrees).
pub(crate) const LEAST_SLOPE: f64 = 0.95;

/// Angle between normal and nearest axis in degrees from which on a wall is treated as slanted throughout; between
/// [`LEAST_SLOPE`] and this angle the changes are blended in.
const WHOLLY_DEG: f64 = 20.0;

/// A connection past a small cell, from its neighbour along x to its neighbour along y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bridge {
    /// Sides on which the neighbours lie, along x and along y: -1 or 1.
    pub(super) sides: [isize; 2],
    /// Weight, in the unit of face weights.
    pub(super) weight: f64,
}

impl Bridge {
    /// The two cells that it joins, from the place of the small cell.
    pub(super) fn ends(&self, [x, y]: [isize; 2]) -> [[isize; 2]; 2] {
        [[x + self.sides[0], y], [x, y + self.sides[1]]]
    }

    /// The weight within the stability limit, for cells of the given areas and a `spare` as in
    /// [`crate::scheme::Polynomial::spare`]. A bridge adds at most twice its weight in each of its cells, and a cell
    /// has two bridges along a wall and four at most: bridges take up half of the spare along a wall, and all of it
    /// at most.
    pub(super) fn stable_weight(&self, spare: f64, areas: [f64; 2]) -> f64 {
        self.weight.min(spare * areas[0].min(areas[1]) / 8.0)
    }
}

/// A place in a window of `width` cells along a side, if it lies within.
pub(crate) fn place_in([x, y]: [isize; 2], width: usize) -> Option<[usize; 2]> {
    let within = |at: isize| usize::try_from(at).ok().filter(|&at| at < width);
    Some([within(x)?, within(y)?])
}

/// Changes in a cell that a slanted wall cuts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slant {
    /// Share of the square of A - B that is left out, 0 to 1.
    pub(super) share: f64,
    /// The bridge past the cell, if a wall leaves a triangle of it.
    pub(super) bridge: Option<Bridge>,
}

/// Slants by the cells' index `iy nx + ix`.
pub(super) type Slants = BTreeMap<usize, Slant>;

/// Share of the changes for a wall with this cosine between normal and nearest axis, 0 to 1.
pub(crate) fn share(cosine: f64) -> f64 {
    let degrees = |cosine: f64| cosine.min(1.0).acos().to_degrees();
    let first = degrees(LEAST_SLOPE);
    ((degrees(cosine) - first) / (WHOLLY_DEG - first)).clamp(0.0, 1.0)
}

/// The cells that slanted walls cut.
pub(super) fn slants(open: &FaceWeights<'_>) -> Slants {
    let slant = |(&cell, &area): (&usize, &f64)| {
        let [ix, iy] = [cell % open.solid.nx, cell / open.solid.nx];
        let shapes = open.near[&cell].iter();
        let cosines = shapes.filter_map(|shape| shape.slant_through([ix as f64, iy as f64]));
        let share = share(cosines.reduce(f64::min)?);
        let bridge = bridge(open, [ix as isize, iy as isize]).map(|bridge| Bridge {
            weight: share * bridge.weight,
            ..bridge
        });
        (area < 1.0 && share > 0.0).then_some((cell, Slant { share, bridge }))
    };
    open.areas.iter().filter_map(slant).collect()
}

/// The bridge past a cell of which a wall leaves a triangle.
fn bridge(open: &FaceWeights<'_>, [ix, iy]: [isize; 2]) -> Option<Bridge> {
    // The only open face along an axis: its side, open part and weight.
    let only = |axis: usize| {
        let next = [(ix + 1, iy), (ix, iy + 1)][axis];
        let low = open.face(axis, ix, iy);
        let high = open.face(axis, next.0, next.1);
        match (low > 0.0, high > 0.0) {
            (true, false) => Some((-1, low, open.weight(axis, ix, iy))),
            (false, true) => Some((1, high, open.weight(axis, next.0, next.1))),
            _ => None,
        }
    };
    let (x, y) = (only(0)?, only(1)?);
    let in_series = |a: f64, b: f64| a * b / (a + b);
    // A triangle has half the area of the rectangle of its sides.
    let is_triangle = open.area(ix, iy) < 0.75 * x.1 * y.1;
    let weight = in_series(x.1, y.1) - in_series(x.2, y.2);
    (is_triangle && weight > 0.0).then_some(Bridge {
        sides: [x.0, y.0],
        weight,
    })
}
