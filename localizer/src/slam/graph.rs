//! Poses, errors of the wheels and landmarks of a drive as one sparse least-squares problem.
//!
//! Unknowns, in this order: for the start and each block x, y (m), heading (rad), and what the wheels' turn rate
//! (rad/s) and speed (part of one) lack there beside what they always lack; for each landmark its two numbers; what
//! turn rate and speed always lack. Blocks are tied to their neighbours by the wheels, to landmarks by ranges and
//! cosines. The normal equations keep this order: a band with a border, which the Cholesky factor keeps.

use nalgebra::{DMatrix, SMatrix};
use nalgebra_sparse::CscMatrix;
use nalgebra_sparse::factorization::CscCholesky;

use super::equations::Normal;
use crate::filter::motion_model::advance;
use crate::landmarks::Sighting;
use crate::landmarks::landmark::Shape;
use crate::odometry::Odometry;
use crate::parameters::Integration;
use crate::pose::{Pose, wrap_angle};

/// Numbers of a block.
pub(super) const STATES: usize = 5;
/// Numbers of what the wheels always lack.
pub(super) const STEADY: usize = 2;
/// Numbers of a landmark.
pub(super) const NUMBERS: usize = 2;
/// Largest change of a landmark's numbers in one step of the solver (rad, m).
const MOST_CHANGE: f64 = 0.5;

/// A peak and the landmark that it is held to come from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Match {
    /// Number of the block.
    pub(super) node: usize,
    /// Number of the peak in the block.
    pub(super) peak: usize,
    /// Number of the landmark.
    pub(super) landmark: usize,
}

/// The drive: what its blocks are thought to be, and the wheels between them.
#[derive(Debug, Clone)]
pub(super) struct Graph {
    /// Numbers of the start, and of every block.
    pub(super) nodes: Vec<[f64; STATES]>,
    /// Mean odometry from each of them to the next one, and the seconds between them.
    pub(super) wheels: Vec<(Odometry, f64)>,
    /// What turn rate (rad/s) and speed (part of one) of the wheels always lack.
    pub(super) steady: [f64; STEADY],
    /// The start.
    pub(super) start: Pose,
    /// Part of the usual standard deviation that what the wheels lack for a while has.
    pub(super) passing: f64,
}

impl Graph {
    /// A drive that has only a start.
    pub(super) fn new(start: Pose) -> Self {
        Self {
            nodes: vec![[start.x_m, start.y_m, start.heading_rad, 0.0, 0.0]],
            wheels: Vec::new(),
            steady: [0.0; STEADY],
            start,
            passing: 1.0,
        }
    }

    /// This drive's start alone.
    pub(super) fn start(&self) -> Self {
        Self::new(self.start)
    }

    /// The pose of a block.
    pub(super) fn pose(&self, node: usize) -> Pose {
        let [x_m, y_m, heading_rad, ..] = self.nodes[node];
        Pose {
            x_m,
            y_m,
            heading_rad,
        }
    }

    /// What turn rate and speed of the wheels lack at a block.
    pub(super) fn wheel_errors(&self, node: usize) -> [f64; 2] {
        [0, 1].map(|k| self.steady[k] + self.nodes[node][3 + k])
    }

    /// Number of unknowns with so many landmarks.
    pub(super) fn size(&self, landmarks: usize) -> usize {
        STATES * self.nodes.len() + NUMBERS * landmarks + STEADY
    }

    /// A sighting with pose and motion as the graph has them.
    pub(super) fn place(&self, node: usize, sighting: &mut Sighting, wheels: Odometry) {
        let [turn_rate, speed] = self.wheel_errors(node);
        sighting.pose = self.pose(node);
        sighting.motion.odometry = Odometry {
            v_mps: wheels.v_mps * (1.0 + speed),
            omega_radps: wheels.omega_radps + turn_rate,
        };
    }

    /// Improves blocks and landmarks by Gauss-Newton steps; `seen[k]` is what block k saw. Returns the factor of the
    /// last normal equations, none when they have no solution.
    pub(super) fn solve(
        &mut self,
        shapes: &mut [Shape],
        seen: &[Option<Sighting>],
        matches: &[Match],
        range_sigmas_m: &[f64],
        alike_blocks: f64,
        steps: usize,
    ) -> Option<CscCholesky<f64>> {
        let mut factor = None;
        for _ in 0..steps {
            let size = self.size(shapes.len());
            let mut normal = Normal::new(size);
            self.add_priors(&mut normal, size);
            for node in 1..self.nodes.len() {
                self.add_wheels(&mut normal, node, size);
            }
            for found in matches {
                if let Some(sighting) = &seen[found.node] {
                    let sigma_m = range_sigmas_m[found.landmark];
                    self.add_echo(&mut normal, sighting, shapes, found, sigma_m, alike_blocks);
                }
            }
            // A landmark that nothing holds stays where it is.
            for row in STATES * self.nodes.len()..size - STEADY {
                normal.triplets.push(row, row, 1e-6);
            }
            let matrix = CscMatrix::from(&normal.triplets);
            let root = CscCholesky::factor(&matrix).ok()?;
            let change = root.solve(&normal.pull);
            if !change.iter().all(|number| number.is_finite()) {
                return None;
            }
            let (of_nodes, of_shapes) = change.as_slice().split_at(STATES * self.nodes.len());
            for (node, change) in self.nodes.iter_mut().zip(of_nodes.chunks_exact(STATES)) {
                node.iter_mut().zip(change).for_each(|(a, b)| *a += b);
                node[2] = wrap_angle(node[2]);
            }
            let (of_shapes, of_steady) = of_shapes.split_at(NUMBERS * shapes.len());
            self.steady
                .iter_mut()
                .zip(of_steady)
                .for_each(|(a, b)| *a += b);
            for (shape, change) in shapes.iter_mut().zip(of_shapes.chunks_exact(NUMBERS)) {
                *shape = shape.moved([0, 1].map(|k| change[k].clamp(-MOST_CHANGE, MOST_CHANGE)));
            }
            factor = Some(root);
        }
        factor
    }

    /// Goes on where this graph ends by the wheels of a longer one, with what they always lack.
    pub(super) fn carry_on(&mut self, longer: &Self) {
        for &(wheels, duration_s) in &longer.wheels[self.wheels.len()..] {
            let last = self.nodes.len() - 1;
            let odometry = Odometry {
                v_mps: wheels.v_mps * (1.0 + self.steady[1]),
                omega_radps: wheels.omega_radps + self.steady[0],
            };
            let pose = advance(
                &self.pose(last),
                odometry,
                duration_s,
                Integration::Midpoint,
            );
            self.nodes
                .push([pose.x_m, pose.y_m, pose.heading_rad, 0.0, 0.0]);
            self.wheels.push((wheels, duration_s));
        }
    }

    /// Covariance of a block's pose and of what the wheels lack there in all, by the factor that [`Graph::solve`]
    /// returned.
    pub(super) fn covariance(
        &self,
        factor: &CscCholesky<f64>,
        node: usize,
        size: usize,
    ) -> SMatrix<f64, STATES, STATES> {
        let (own, always) = (STATES * node, size - STEADY);
        // Columns of the sums that are asked for.
        let parts = |k: usize| [Some(own + k), k.checked_sub(3).map(|k| always + k)];
        let mut wanted = DMatrix::zeros(size, STATES);
        for column in 0..STATES {
            for part in parts(column).into_iter().flatten() {
                wanted[(part, column)] = 1.0;
            }
        }
        let solved = factor.solve(&wanted);
        SMatrix::from_fn(|row, column| {
            let parts = parts(row).into_iter().flatten();
            parts.map(|part| solved[(part, column)]).sum()
        })
    }

    /// Covariance of a landmark's two numbers.
    pub(super) fn landmark_covariance(
        &self,
        factor: &CscCholesky<f64>,
        landmark: usize,
        size: usize,
    ) -> [[f64; 2]; 2] {
        let first = STATES * self.nodes.len() + NUMBERS * landmark;
        let mut units = DMatrix::zeros(size, NUMBERS);
        for column in 0..NUMBERS {
            units[(first + column, column)] = 1.0;
        }
        let columns = factor.solve(&units);
        [0, 1].map(|row| [0, 1].map(|column| columns[(first + row, column)]))
    }
}
