//! Exact lengths and areas that a union of convex shapes leaves of lines and unit squares.
//!
//! Along a line the shapes are intervals, whose union counts nothing twice. The open length of a line through a cell
//! is a piecewise linear function of the line's place, with breaks at corners, crossings of two edges and crossings
//! of an edge with the cell's border: its values half way between the breaks give the open area exactly.

/// Lines are cut at this distance to both sides, in cells, so that a shape that touches a line covers it.
const BESIDE: f64 = 1e-7;

/// A convex polygon in cells.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Convex {
    /// Corners, counter-clockwise.
    corners: Vec<[f64; 2]>,
}

impl Convex {
    /// The polygon with these corners, in either sense of rotation; corners within 1e-6 of a grid line are put on it.
    pub(super) fn new(mut corners: Vec<[f64; 2]>) -> Self {
        for x in corners.iter_mut().flatten() {
            if (*x - x.round()).abs() < 1e-6 {
                *x = x.round();
            }
        }
        let mut polygon = Self { corners };
        let doubled: f64 = polygon
            .edges()
            .map(|[p, q]| p[0] * q[1] - q[0] * p[1])
            .sum();
        if doubled < 0.0 {
            polygon.corners.reverse();
        }
        polygon
    }

    fn edges(&self) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(&p, &q)| [p, q])
    }

    /// Smallest and largest coordinate along an axis.
    pub(super) fn bounds(&self, axis: usize) -> [f64; 2] {
        let start = [f64::INFINITY, f64::NEG_INFINITY];
        let coordinates = self.corners.iter().map(|corner| corner[axis]);
        coordinates.fold(start, |[low, high], x| [low.min(x), high.max(x)])
    }

    /// How much the polygon covers of the unit square whose lower left corner is `[x, y]`.
    pub(super) fn covers(&self, [x, y]: [f64; 2]) -> Cover {
        let square = [[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]];
        let apart = (0..2).any(|axis| {
            let [low, high] = self.bounds(axis);
            low >= [x, y][axis] + 1.0 || high <= [x, y][axis]
        });
        if apart {
            return Cover::None;
        }
        let mut whole = true;
        for [p, q] in self.edges() {
            let outside = square
                .map(|r| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) <= 0.0);
            if outside == [true; 4] {
                return Cover::None;
            }
            let strictly = square
                .iter()
                .any(|r| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) < -1e-12);
            whole &= !strictly;
        }
        if whole { Cover::Whole } else { Cover::Part }
    }

    /// The least cosine between normal and nearest axis of the edges through the unit square whose lower left corner
    /// is given; `None` when no edge passes through it.
    pub(super) fn slant_through(&self, corner: [f64; 2]) -> Option<f64> {
        let passes = |[p, q]: &[[f64; 2]; 2]| {
            // The part of the edge, from 0 to 1, that is between the square's sides along both axes.
            let [from, to] = (0..2).fold([0.0_f64, 1.0], |[from, to], axis| {
                let at = |side: f64| (corner[axis] + side - p[axis]) / (q[axis] - p[axis]);
                let [a, b] = [at(0.0), at(1.0)];
                [from.max(a.min(b)), to.min(a.max(b))]
            });
            to - from > BESIDE
        };
        let cosine = |[p, q]: [[f64; 2]; 2]| {
            let [x, y] = [0, 1].map(|axis| (q[axis] - p[axis]).abs());
            x.max(y) / x.hypot(y)
        };
        self.edges().filter(passes).map(cosine).reduce(f64::min)
    }

    /// The interval that the polygon covers of the line on which coordinate `axis` is `at`.
    fn interval(&self, axis: usize, at: f64) -> Option<[f64; 2]> {
        let along = 1 - axis;
        let crossings = self.edges().filter_map(|[p, q]| {
            let (a, b) = (p[axis] - at, q[axis] - at);
            (a * b <= 0.0 && a != b).then(|| p[along] + (q[along] - p[along]) * a / (a - b))
        });
        crossings.fold(None, |found, x| {
            let [low, high] = found.unwrap_or([x, x]);
            Some([low.min(x), high.max(x)])
        })
    }
}

/// Cover of a square by a polygon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cover {
    /// Nothing.
    None,
    /// A part, or nothing near one of its corners.
    Part,
    /// All of it.
    Whole,
}

/// Length that the union of `intervals` leaves of `low..low + 1`.
fn left_of(intervals: impl Iterator<Item = [f64; 2]>, low: f64) -> f64 {
    let mut intervals: Vec<[f64; 2]> = intervals.collect();
    intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut open, mut reached) = (0.0, low);
    for [from, to] in intervals {
        open += (from.min(low + 1.0) - reached).max(0.0);
        reached = reached.max(to.min(low + 1.0));
    }
    snapped(open + (low + 1.0 - reached).max(0.0))
}

/// A fraction, with values within rounding of 0 or 1 replaced by these.
fn snapped(part: f64) -> f64 {
    match part {
        ..1e-6 => 0.0,
        0.999_999.. => 1.0,
        part => part,
    }
}

/// Length that the union of `shapes` leaves of the face on the line where coordinate `axis` is `at`, from `low` to
/// `low + 1`.
pub(super) fn open_face(shapes: &[&Convex], axis: usize, at: f64, low: f64) -> f64 {
    let sides = [at - BESIDE, at + BESIDE];
    let intervals = shapes
        .iter()
        .flat_map(|shape| sides.map(|side| shape.interval(axis, side)));
    left_of(intervals.flatten(), low)
}

/// Area that the union of `shapes` leaves of the unit square whose lower left corner is `[x, y]`.
pub(super) fn open_area(shapes: &[&Convex], [x, y]: [f64; 2]) -> f64 {
    let mut places = vec![y, y + 1.0];
    let edges: Vec<[[f64; 2]; 2]> = shapes.iter().flat_map(|shape| shape.edges()).collect();
    for (index, &[p, q]) in edges.iter().enumerate() {
        places.push(p[1]);
        let across = q[0] - p[0];
        for border in [x, x + 1.0] {
            let part = (border - p[0]) / across;
            if (0.0..=1.0).contains(&part) {
                places.push(p[1] + (q[1] - p[1]) * part);
            }
        }
        for &[r, s] in &edges[..index] {
            let turn = across * (s[1] - r[1]) - (q[1] - p[1]) * (s[0] - r[0]);
            let part = ((r[0] - p[0]) * (s[1] - r[1]) - (r[1] - p[1]) * (s[0] - r[0])) / turn;
            if (0.0..=1.0).contains(&part) {
                places.push(p[1] + (q[1] - p[1]) * part);
            }
        }
    }
    places.retain(|place| (y..=y + 1.0).contains(place));
    places.sort_by(f64::total_cmp);
    let strips = places.windows(2).filter(|strip| strip[0] < strip[1]);
    let open = strips.map(|strip| {
        let middle = 0.5 * (strip[0] + strip[1]);
        let intervals = shapes.iter().filter_map(|shape| shape.interval(1, middle));
        (strip[1] - strip[0]) * left_of(intervals, x)
    });
    snapped(open.sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_and_faces_of_overlapping_shapes_are_exact() {
        let low = Convex::new(vec![[-3.0, -3.0], [3.0, -3.0], [3.0, 0.7], [-3.0, 0.1]]);
        let left = Convex::new(vec![[0.25, -3.0], [0.25, 3.0], [-2.0, 3.0], [-2.0, -3.0]]);
        let shapes = [&low, &left];
        // Under the slanted edge y = 0.4 + 0.1 x, right of x = 0.25.
        let area = open_area(&shapes, [0.0, 0.0]);
        assert!(
            (area - (0.75 * 0.6 - 0.05 * (1.0 - 0.0625))).abs() < 1e-12,
            "{area}"
        );
        let east = open_face(&shapes, 0, 1.0, 0.0);
        assert!((east - 0.5).abs() < 1e-6, "{east}");
        assert_eq!(open_face(&shapes, 0, 0.0, 0.0), 0.0);
        assert_eq!(open_face(&shapes, 1, 0.0, 0.0), 0.0);
        assert!((open_face(&shapes, 1, 1.0, 0.0) - 0.75).abs() < 1e-6);
        assert_eq!(low.covers([0.0, -2.0]), Cover::Whole);
        assert_eq!(low.covers([0.0, 0.0]), Cover::Part);
        assert_eq!(low.covers([0.0, 1.0]), Cover::None);
    }

    #[test]
    fn the_edges_through_a_square_are_those_inside_it() {
        let roof = Convex::new(vec![
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 0.5],
            [2.0, 2.5],
            [0.0, 0.5],
        ]);
        let slope = Some(std::f64::consts::FRAC_1_SQRT_2);
        for (corner, expected) in [
            ([-0.5, -0.5], Some(1.0)),
            ([0.5, -0.5], Some(1.0)),
            ([0.0, 0.0], slope),
            ([1.0, 1.0], slope),
            ([2.0, 1.0], slope),
            ([3.0, 0.0], slope),
            // Inside, outside, at a corner.
            ([1.5, 0.5], None),
            ([0.0, 1.6], None),
            ([0.5, 0.0], None),
        ] {
            let found = roof.slant_through(corner);
            let is_same = match (found, expected) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-12,
                (a, b) => a == b,
            };
            assert!(is_same, "{corner:?}: {found:?}");
        }
    }
}
