//! The faces of a convex room, and the images and visibility of points in it.

use crate::rays::fade;
use fdtd::Error;

/// A point or vector in metres.
pub(super) type Vec3 = [f64; 3];

/// A plane `normal . p + offset_m = 0`; the unit normal points into the room.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoomFace {
    /// Unit normal into the room.
    pub normal: [f64; 3],
    /// Height of the origin above the plane in metres.
    pub offset_m: f64,
}

impl RoomFace {
    /// Height of a point above the plane in metres, positive inside the room.
    fn height_m(&self, point_m: Vec3) -> f64 {
        dot(self.normal, point_m) + self.offset_m
    }

    fn mirror(&self, point_m: Vec3) -> Vec3 {
        let height_m = self.height_m(point_m);
        std::array::from_fn(|i| point_m[i] - 2.0 * height_m * self.normal[i])
    }
}

/// A room with vertical walls over a convex polygon, a floor at height 0 and a flat ceiling.
#[derive(Debug, Clone, PartialEq)]
pub struct Room {
    faces: Vec<RoomFace>,
    pub(super) reflection: f64,
}

impl Room {
    /// A room over `corners_m` (counter-clockwise), `height_m` high. Each reflection multiplies the pressure by
    /// `reflection`, at all frequencies and angles.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the corners are no convex polygon in counter-clockwise order, or a number is out of
    /// range.
    pub fn new(corners_m: &[[f64; 2]], height_m: f64, reflection: f64) -> Result<Self, Error> {
        let refuse = |field: &str, problem: String, remedy: &str| {
            Err(Error::invalid("room", field, problem, remedy))
        };
        if !(height_m.is_finite() && height_m > 0.0) {
            return refuse(
                "height_m",
                format!("is {height_m}"),
                "give a positive number",
            );
        }
        if !(-1.0..=1.0).contains(&reflection) {
            return refuse("reflection", format!("is {reflection}"), "give -1 to 1");
        }
        let count = corners_m.len();
        let corner = |index: usize| corners_m[index % count];
        let convex = count >= 3
            && (0..count).all(|index| {
                let (a, b, c) = (corner(index), corner(index + 1), corner(index + 2));
                (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) > 0.0
            });
        if !convex {
            let problem = "are no convex polygon in counter-clockwise order".to_string();
            return refuse("corners_m", problem, "turn left at every corner");
        }
        let mut faces: Vec<RoomFace> = (0..count)
            .map(|index| {
                let (a, b) = (corner(index), corner(index + 1));
                let length_m = (b[0] - a[0]).hypot(b[1] - a[1]);
                let normal = [-(b[1] - a[1]) / length_m, (b[0] - a[0]) / length_m, 0.0];
                RoomFace {
                    normal,
                    offset_m: -(normal[0] * a[0] + normal[1] * a[1]),
                }
            })
            .collect();
        faces.push(RoomFace {
            normal: [0.0, 0.0, 1.0],
            offset_m: 0.0,
        });
        faces.push(RoomFace {
            normal: [0.0, 0.0, -1.0],
            offset_m: height_m,
        });
        Ok(Self { faces, reflection })
    }

    /// The walls in the order of the corners, the floor, the ceiling.
    pub fn faces(&self) -> &[RoomFace] {
        &self.faces
    }

    /// All sequences of faces up to `max_order` reflections, shortest first, the direct way (no face) included.
    pub fn sequences(&self, max_order: usize) -> Vec<Vec<usize>> {
        let mut all = vec![Vec::new()];
        let mut first = 0;
        for _ in 0..max_order {
            let longest = all.len();
            for index in first..longest {
                for next in 0..self.faces.len() {
                    if all[index].last() != Some(&next) {
                        let longer = [all[index].as_slice(), &[next]].concat();
                        all.push(longer);
                    }
                }
            }
            first = longest;
        }
        all
    }

    /// Image of a point by reflections in `sequence`, the first face first.
    pub fn image(&self, sequence: &[usize], point_m: [f64; 3]) -> [f64; 3] {
        sequence
            .iter()
            .fold(point_m, |image, &face| self.faces[face].mirror(image))
    }

    /// Visibility of a path: 0 or 1, and in between within `fade_m` of a border of visibility.
    pub fn visibility(
        &self,
        sequence: &[usize],
        source_m: [f64; 3],
        receiver_m: [f64; 3],
        fade_m: f64,
    ) -> f64 {
        let images: Vec<Vec3> = sequence
            .iter()
            .scan(source_m, |image, &face| {
                *image = self.faces[face].mirror(*image);
                Some(*image)
            })
            .collect();
        let mut clearance_m = f64::INFINITY;
        let mut end_m = receiver_m;
        for (&face, &image) in sequence.iter().zip(&images).rev() {
            let (above, below) = (
                self.faces[face].height_m(end_m),
                self.faces[face].height_m(image),
            );
            // The last leg must come from behind the face.
            if above <= 0.0 || below >= 0.0 {
                return 0.0;
            }
            let share = above / (above - below);
            end_m = std::array::from_fn(|i| end_m[i] + share * (image[i] - end_m[i]));
            for (other, plane) in self.faces.iter().enumerate() {
                if other != face {
                    clearance_m = clearance_m.min(plane.height_m(end_m));
                }
            }
        }
        fade(clearance_m, fade_m)
    }
}

pub(super) fn dot(a: Vec3, b: Vec3) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}
