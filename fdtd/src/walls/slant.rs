//! What keeps waves along a slanted wall right, wherever it cuts the cells.
//!
//! Two things give waves before a rigid wall of 45 degrees another phase from place to place: by 0.2 (m13, o13, d25) where it is met at 45 degrees at
//! 10 kHz on the papers' grid, by 0.4 at 60. With both mended 0.018 and 0.035 are left (d25, whose cubes stay as they are, 0.05 and 0.1), by an
//! analysis of the step along such a wall.
//!
//! *Small cells are short of faces.* A corner that a wall cuts off has one face along x and one along y, and less of each than is open, for the
//! spectrum's sake ([`super::cut`]). That takes from the flow towards the wall, which the wall stops anyway, but from that along the wall too, which
//! comes in by one face and goes out by the other. A [`Bridge`] between the two cells beside gives back what is missing: two faces in a row of
//! weights a and b pass `a b/(a + b)`.
//!
//! *A and B are large where only their sum is small.* Before a slanted wall the pressure changes along both axes, though not along the normal, and in a cut
//! cell A and B each see the wall as the end of that change: they grow as the cells shrink. The wide schemes have
//! `b (A^2 + B^2) + m (AB + BA)/2 = (b/2 + m/4) (A + B)^2 + (b/2 - m/4) (A - B)^2`, and the last square makes of it a reactance along the wall. In cut
//! cells it is left out: `(A - B) Q (A - B)` with Q zero there is symmetric still, and between nothing and the whole square, so that the bounds of the
//! spectrum hold ([`crate::scheme::Polynomial`]).

use std::collections::BTreeMap;

use super::WallCells;
use super::faces::Openings;
use super::surface::LEAST_SLOPE;

/// A way past a small cell, from its neighbour along x to that along y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bridge {
    /// On which side the neighbours lie, along x and along y: -1 or 1.
    pub(super) sides: [isize; 2],
    /// Weight, as those of faces.
    pub(super) weight: f64,
}

impl Bridge {
    /// The two cells that it joins, of the small cell at a place.
    fn ends(&self, [x, y]: [isize; 2]) -> [[isize; 2]; 2] {
        [[x + self.sides[0], y], [x, y + self.sides[1]]]
    }

    /// The weight that the step bears. A bridge adds at most twice its weight in each of its cells, and a cell has two along a wall and four at most.
    /// So they stay within half of what the bound leaves of 4 ([`crate::scheme::Polynomial::spare`]) along a wall, and within all of it anywhere.
    fn borne(&self, spare: f64, areas: [f64; 2]) -> f64 {
        self.weight.min(spare * areas[0].min(areas[1]) / 8.0)
    }
}

/// Place in a window of so many cells along a side, if it is in it.
pub(super) fn place_in([x, y]: [isize; 2], width: usize) -> Option<[usize; 2]> {
    let within = |at: isize| usize::try_from(at).ok().filter(|&at| at < width);
    Some([within(x)?, within(y)?])
}

impl WallCells {
    /// Bridges past the cells of a window that begins at `first`, `width` cells along a side: places of their ends in the window, where they may lie
    /// just outside, and weights that a step bears whose bound leaves `spare`.
    pub(super) fn bridges(
        &self,
        first: [isize; 2],
        width: usize,
        spare: f64,
    ) -> Vec<([[isize; 2]; 2], f64)> {
        let area = |[x, y]: [isize; 2]| {
            let opening = self.opening(first[0] + x, first[1] + y);
            opening.map_or(1.0, |opening| opening.area)
        };
        let places = (0..width as isize).flat_map(|y| (0..width as isize).map(move |x| [x, y]));
        places
            .filter_map(|[x, y]| {
                let bridge = self.slant(first[0] + x, first[1] + y)?.bridge?;
                let ends = bridge.ends([x, y]);
                Some((ends, bridge.borne(spare, ends.map(area))))
            })
            .collect()
    }
}

/// What a slanted wall changes in a cell that it cuts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slant {
    /// How much of the square of A - B is left out, 0 to 1.
    pub(super) share: f64,
    /// The way past the cell, if it is a small one.
    pub(super) bridge: Option<Bridge>,
}

/// Slants by the cells' index `iy nx + ix`.
pub(super) type Slants = BTreeMap<usize, Slant>;

/// Angle between normal and axis in degrees from which on all of it is done; from where columns of cells end ([`LEAST_SLOPE`]) up to there it comes
/// in gradually.
const WHOLLY_DEG: f64 = 20.0;

/// How much of it is done where an edge has this cosine between normal and axis.
pub(super) fn share(cosine: f64) -> f64 {
    let degrees = |cosine: f64| cosine.min(1.0).acos().to_degrees();
    let first = degrees(LEAST_SLOPE);
    ((degrees(cosine) - first) / (WHOLLY_DEG - first)).clamp(0.0, 1.0)
}

/// Of all cells, those that slanted walls cut.
pub(super) fn slants(open: &Openings<'_>) -> Slants {
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
fn bridge(open: &Openings<'_>, [ix, iy]: [isize; 2]) -> Option<Bridge> {
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
    let in_a_row = |a: f64, b: f64| a * b / (a + b);
    // Half of the rectangle of its sides, and not much more.
    let is_triangle = open.area(ix, iy) < 0.75 * x.1 * y.1;
    let weight = in_a_row(x.1, y.1) - in_a_row(x.2, y.2);
    (is_triangle && weight > 0.0).then_some(Bridge {
        sides: [x.0, y.0],
        weight,
    })
}
