//! Predicted arrival times and their Jacobians (2021, eqs. (2) and (3)).

use super::planes::{Plane, Reflection};
use crate::pose::Pose;

/// The reflections of a model (2021, section 3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// (a): one wall.
    Single,
    /// (b): one wall, or two walls in the plane.
    Planar,
    /// (c): one or two of walls, ceiling and floor.
    Spatial,
}

/// All paths of a model, from the loudspeaker to the microphone above the robot's position.
///
/// ```
/// use localizer::Pose;
/// use localizer::multipath::planes::Plane;
/// use localizer::multipath::prediction::{Model, Predictor};
///
/// // A wall at x = 4 m, loudspeaker and microphone at one height.
/// let wall = Plane::new([1.0, 0.0, 0.0], -4.0).ok_or("no normal")?;
/// let predictor = Predictor::new(&[wall], Model::Single, [0.3, 0.3], 340.0);
/// let arrivals = predictor.predict(&Pose { x_m: 1.0, ..Pose::default() });
/// assert!((arrivals[0].time_s - 6.0 / 340.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Predictor {
    paths: Vec<Path>,
    speaker_height_m: f64,
    microphone_height_m: f64,
    sound_speed_mps: f64,
}

/// One path: the planes in the order in which sound meets them, and the image's map.
#[derive(Debug, Clone)]
struct Path {
    planes: Vec<Plane>,
    reflection: Reflection,
}

/// One predicted arrival.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// Arrival time in seconds.
    pub time_s: f64,
    /// Its derivatives by x, y (s/m) and heading (s/rad).
    pub jacobian: [f64; 3],
}

impl Predictor {
    /// Lists the model's paths; two reflections in one plane cancel and are left out.
    pub fn new(planes: &[Plane], model: Model, heights_m: [f64; 2], sound_speed_mps: f64) -> Self {
        let single: Vec<Path> = planes
            .iter()
            .filter(|plane| model == Model::Spatial || plane.is_vertical())
            .map(|plane| Path {
                planes: vec![*plane],
                reflection: plane.reflection(),
            })
            .collect();
        let mut paths = single.clone();
        if model != Model::Single {
            for (i, first) in single.iter().enumerate() {
                let others = single.iter().enumerate().filter(|(j, _)| *j != i);
                paths.extend(others.map(|(_, second)| Path {
                    planes: [first.planes.as_slice(), &second.planes].concat(),
                    reflection: first.reflection.then(&second.reflection),
                }));
            }
        }
        let [speaker_height_m, microphone_height_m] = heights_m;
        Self {
            paths,
            speaker_height_m,
            microphone_height_m,
            sound_speed_mps,
        }
    }

    /// Arrival times at a pose, eq. (3), with their analytic Jacobians. Paths that miss a finite wall are left out.
    pub fn predict(&self, pose: &Pose) -> Vec<Arrival> {
        let speaker = [pose.x_m, pose.y_m, self.speaker_height_m];
        let microphone = [pose.x_m, pose.y_m, self.microphone_height_m];
        self.paths
            .iter()
            .filter(|path| path.is_open(speaker, microphone))
            .map(|path| self.arrival(&path.reflection, speaker, microphone))
            .collect()
    }

    fn arrival(&self, path: &Reflection, speaker: [f64; 3], microphone: [f64; 3]) -> Arrival {
        let image = path.apply(speaker);
        let ray: [f64; 3] = std::array::from_fn(|i| microphone[i] - image[i]);
        let length = ray.iter().map(|r| r * r).sum::<f64>().sqrt().max(1e-9);
        let slope = |axis: usize| {
            let along: f64 = (0..3).map(|i| ray[i] * path.linear[i][axis]).sum();
            (ray[axis] - along) / (length * self.sound_speed_mps)
        };
        Arrival {
            time_s: length / self.sound_speed_mps,
            jacobian: [slope(0), slope(1), 0.0],
        }
    }
}

impl Path {
    /// Whether every reflection point lies on its wall, from the microphone back to the loudspeaker.
    fn is_open(&self, speaker: [f64; 3], microphone: [f64; 3]) -> bool {
        let images: Vec<[f64; 3]> = self
            .planes
            .iter()
            .scan(speaker, |image, plane| {
                *image = plane.reflection().apply(*image);
                Some(*image)
            })
            .collect();
        let legs = self.planes.iter().zip(images).rev();
        let mut end = Some(microphone);
        for (plane, image) in legs {
            end = end.and_then(|end| plane.passage(image, end));
        }
        end.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::multipath::planes::tests::room;

    /// Domain: a room 4 m x 5 m x 2.5 m. Central differences over 2e-6 m; tolerance 1e-9 s/m.
    #[test]
    fn jacobians_match_finite_differences() {
        let planes = room([1., 0.2, 0.]);
        let predictor = Predictor::new(&planes, Model::Spatial, [0.3, 0.4], 343.2);
        let pose = Pose {
            x_m: 1.3,
            y_m: 2.1,
            heading_rad: 0.4,
        };
        let h = 1e-6;
        let at = |dx: f64, dy: f64| {
            predictor.predict(&Pose {
                x_m: 1.3 + dx,
                y_m: 2.1 + dy,
                ..pose
            })
        };
        let centre = at(0.0, 0.0);
        assert_eq!(centre.len(), 25);
        for (axis, (up, down)) in [(at(h, 0.), at(-h, 0.)), (at(0., h), at(0., -h))]
            .iter()
            .enumerate()
        {
            for ((c, u), d) in centre.iter().zip(up).zip(down) {
                assert!((c.jacobian[axis] - (u.time_s - d.time_s) / (2.0 * h)).abs() < 1e-9);
            }
        }
    }

    /// Formula: a wall at distance d answers after 2 d / c.
    #[test]
    fn a_wall_answers_after_twice_its_distance() {
        let wall = Plane::new([2.0, 0.0, 0.0], -8.0).unwrap();
        for c_mps in [333.0, 340.0, 350.0] {
            let predictor = Predictor::new(
                std::slice::from_ref(&wall),
                Model::Single,
                [0.3, 0.3],
                c_mps,
            );
            let arrivals = predictor.predict(&Pose {
                x_m: 1.0,
                ..Pose::default()
            });
            assert!((arrivals[0].time_s - 6.0 / c_mps).abs() < 1e-12);
        }
    }

    /// A corner of two walls, 3 m long each, at (0, 0): echoes of both walls and, through the apex, of the corner in
    /// both orders; beyond one wall's end that wall's echo is missing, and behind both there is none.
    #[test]
    fn finite_walls_echo_where_they_reflect() {
        let walls = [
            Plane::wall([[0.0, 0.0], [3.0, 0.0]]).unwrap(),
            Plane::wall([[0.0, 3.0], [0.0, 0.0]]).unwrap(),
        ];
        let predictor = Predictor::new(&walls, Model::Planar, [0.0, 0.0], 337.0);
        let lengths = |x_m: f64, y_m: f64| -> Vec<f64> {
            let pose = Pose {
                x_m,
                y_m,
                heading_rad: 0.0,
            };
            let arrivals = predictor.predict(&pose);
            arrivals.iter().map(|a| 337.0 * a.time_s).collect()
        };
        let near = lengths(1.0, 1.2);
        let expected = [2.4, 2.0, 2.0 * 1f64.hypot(1.2), 2.0 * 1f64.hypot(1.2)];
        assert_eq!(near.len(), 4, "{near:?}");
        assert!(near.iter().zip(expected).all(|(n, e)| (n - e).abs() < 1e-9));
        assert_eq!(lengths(4.0, 1.0).len(), 3);
        assert_eq!(lengths(-4.0, -1.0).len(), 0);
    }
}
