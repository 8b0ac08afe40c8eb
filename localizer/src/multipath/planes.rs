//! Planes in space and the reflections in them (2021, eq. (2)).

/// Distance within which a path still meets a wall's end, in metres.
const TOUCH_M: f64 = 1e-6;

/// A plane `a x + b y + c z + d = 0` with a unit normal; a wall's plane may end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    normal: [f64; 3],
    offset_m: f64,
    extent: Option<Extent>,
}

/// The stretch of a vertical plane that a finite wall covers.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Extent {
    start_m: [f64; 2],
    along: [f64; 2],
    length_m: f64,
}

/// An affine map of space, `linear p + shift`: one reflection, or several in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflection {
    /// Linear part, `[row][column]`.
    pub linear: [[f64; 3]; 3],
    /// Shift in metres.
    pub shift_m: [f64; 3],
}

impl Plane {
    /// The plane with the given coefficients; `None` where the normal has no direction.
    pub fn new(normal: [f64; 3], offset_m: f64) -> Option<Self> {
        let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        (length > 0.0 && length.is_finite() && offset_m.is_finite()).then(|| Self {
            normal: normal.map(|n| n / length),
            offset_m: offset_m / length,
            extent: None,
        })
    }

    /// The vertical wall between two points in metres. It reflects on its left side only, as seen from the first
    /// point to the second; `None` for equal points.
    pub fn wall([from, to]: [[f64; 2]; 2]) -> Option<Self> {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length_m = along[0].hypot(along[1]);
        let normal = [-along[1], along[0], 0.0];
        let offset = along[1] * from[0] - along[0] * from[1];
        Some(Self {
            extent: Some(Extent {
                start_m: from,
                along: along.map(|a| a / length_m),
                length_m,
            }),
            ..Self::new(normal, offset)?
        })
    }

    /// True for walls, false for ceilings and floors.
    pub fn is_vertical(&self) -> bool {
        self.normal[2].abs() < 1e-9
    }

    /// Height of a point above the plane, on the side of the normal, in metres.
    pub fn height_m(&self, point_m: [f64; 3]) -> f64 {
        (0..3).map(|i| self.normal[i] * point_m[i]).sum::<f64>() + self.offset_m
    }

    /// Where sound from an image behind the plane passes it on its way to `point_m`; `None` when it passes beyond the
    /// wall's ends or comes from its back. A plane without ends lets everything pass, as eq. (3) does.
    pub fn passage(&self, image_m: [f64; 3], point_m: [f64; 3]) -> Option<[f64; 3]> {
        let (below, above) = (self.height_m(image_m), self.height_m(point_m));
        let share = above / (above - below);
        let at: [f64; 3] = std::array::from_fn(|i| point_m[i] + share * (image_m[i] - point_m[i]));
        let Some(extent) = self.extent else {
            return Some(at);
        };
        let along = (at[0] - extent.start_m[0]) * extent.along[0]
            + (at[1] - extent.start_m[1]) * extent.along[1];
        // The corner echo of a pair at one point passes the very apex.
        let hit = below < TOUCH_M
            && above > -TOUCH_M
            && (-TOUCH_M..=extent.length_m + TOUCH_M).contains(&along);
        hit.then_some(at)
    }

    /// `R_j` of eq. (2).
    pub fn reflection(&self) -> Reflection {
        let n = self.normal;
        let mut linear = [[0.0; 3]; 3];
        for (i, row) in linear.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = f64::from(u8::from(i == j)) - 2.0 * n[i] * n[j];
            }
        }
        Reflection {
            linear,
            shift_m: n.map(|n| -2.0 * self.offset_m * n),
        }
    }
}

impl Reflection {
    /// The image of a point.
    pub fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| {
            (0..3).map(|j| self.linear[i][j] * point[j]).sum::<f64>() + self.shift_m[i]
        })
    }

    /// This reflection first, `next` after it: `R_next R_self`.
    pub fn then(&self, next: &Self) -> Self {
        Self {
            linear: std::array::from_fn(|i| {
                std::array::from_fn(|j| (0..3).map(|k| next.linear[i][k] * self.linear[k][j]).sum())
            }),
            shift_m: next.apply(self.shift_m),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Four walls and the ceiling of a room 4 m x 5 m x 2.5 m; the wall at x = 4 m has the normal `east`.
    pub(crate) fn room(east: [f64; 3]) -> Vec<Plane> {
        let planes = [
            ([1., 0., 0.], 0.),
            (east, -4.),
            ([0., 1., 0.], 0.),
            ([0., 1., 0.], -5.),
            ([0., 0., 1.], -2.5),
        ];
        planes
            .iter()
            .map(|(normal, offset_m)| Plane::new(*normal, *offset_m).unwrap())
            .collect()
    }

    #[test]
    fn two_reflections_in_a_row_are_one_map() {
        let (a, b) = (
            Plane::new([1.0, 0.3, 0.1], -2.0).unwrap(),
            Plane::new([0.2, -1.0, 0.4], 1.5).unwrap(),
        );
        let p = [0.4, -1.2, 0.7];
        let once = a.reflection().apply(p);
        assert!((a.height_m(once) + a.height_m(p)).abs() < 1e-12);
        let twice = b.reflection().apply(once);
        let joined = a.reflection().then(&b.reflection()).apply(p);
        assert!(twice.iter().zip(joined).all(|(x, y)| (x - y).abs() < 1e-12));
        assert!(Plane::new([0.0; 3], 1.0).is_none());
    }

    /// A wall from (0, 1) to (2, 1) faces up; the image of (x, 2) is (x, 0).
    #[test]
    fn a_wall_reflects_between_its_ends_and_on_its_front() {
        let wall = Plane::wall([[0.0, 1.0], [2.0, 1.0]]).unwrap();
        let echo = |point: [f64; 3]| wall.passage(wall.reflection().apply(point), point);
        assert_eq!(echo([0.5, 2.0, 0.3]), Some([0.5, 1.0, 0.3]));
        assert_eq!(echo([2.5, 2.0, 0.3]), None);
        assert_eq!(echo([0.5, 0.5, 0.3]), None);
        assert!(wall.is_vertical() && Plane::wall([[1.0; 2]; 2]).is_none());
    }
}
