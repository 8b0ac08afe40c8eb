//! Poses, errors of the wheels and landmarks of a drive as one sparse least-squares problem.
//!
//! Unknowns, in this order: for the start and each block x, y (m), heading (rad), and what the wheels' turn rate
//! (rad/s) and speed (part of one) lack there beside what they always lack; for each landmark its two numbers; what
//! turn rate and speed always lack. Blocks are tied to their neighbours by the wheels, to landmarks by ranges and
//! cosines. The normal equations keep this order: a band with a border, which the Cholesky factor keeps.

use nalgebra::{DMatrix, DVector, SMatrix};
use nalgebra_sparse::factorization::CscCholesky;
use nalgebra_sparse::{CooMatrix, CscMatrix};

use crate::filter::motion_model::advance;
use crate::landmarks::Sighting;
use crate::landmarks::landmark::Shape;
use crate::odometry::Odometry;
use crate::parameters::Integration;
use crate::pose::{Pose, wrap_angle};

/// Numbers of a block.
pub(super) const STATES: usize = 5;
/// Numbers of what the wheels always lack.
const STEADY: usize = 2;
/// Numbers of a landmark.
const NUMBERS: usize = 2;
/// Standard deviations of the start's position (m) and heading (rad), which say where the frame of the map is.
pub(super) const START_SIGMA: [f64; 2] = [1e-4, 1e-4];
/// Standard deviations of what the wheels' turn rate (rad/s) and speed (part of one) always lack.
const STEADY_SIGMA: [f64; STEADY] = [0.02, 0.02];
/// White noise of the wheels along the way and across it (metres per root second), and of the heading (radians per
/// root second): what they do not lack for a while or always.
const ALONG_M: f64 = 0.001;
const ACROSS_M: f64 = 0.001;
const TURN_RAD: f64 = 0.002;
/// What turn rate (rad/s) and speed (part of one) of the wheels lack for a while: standard deviations, and the time in
/// seconds over which they last (first-order Gauss-Markov processes).
const PASSING: [f64; 2] = [0.02, 0.01];
const PASSING_S: f64 = 1.0;
/// Least and largest part of these that a drive may show, and what its mean square is too small by: estimates are
/// drawn to zero.
const PASSING_PARTS: [f64; 2] = [0.15, 2.0];
const PASSING_MARGIN: f64 = 1.5;
/// Weight of what the wheels always lack in the strain.
const STEADY_PART: f64 = 0.6;
/// Blocks at the end that are looked at by themselves.
const LATE_NODES: usize = 40;
/// Degrees of freedom of the residuals' heavy tails.
const TAILS: f64 = 4.0;
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
    start: Pose,
    /// Part of the usual standard deviation that what the wheels lack for a while has.
    passing: f64,
}

/// Normal equations under construction.
struct Normal {
    triplets: CooMatrix<f64>,
    pull: DVector<f64>,
    /// Half the sum of the weighted squares of the residuals.
    cost: f64,
}

impl Normal {
    fn new(size: usize) -> Self {
        Self {
            triplets: CooMatrix::new(size, size),
            pull: DVector::zeros(size),
            cost: 0.0,
        }
    }

    /// A residual, its derivatives by some unknowns, and its weight.
    fn add(&mut self, residual: f64, by: &[(usize, f64)], weight: f64) {
        self.cost += 0.5 * weight * residual * residual;
        for &(row, a) in by {
            self.pull[row] -= weight * a * residual;
            for &(column, b) in by {
                self.triplets.push(row, column, weight * a * b);
            }
        }
    }
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

    /// Learns from the drive how much the wheels lack for a while, as a part of the usual.
    pub(super) fn learn_passing(&mut self) {
        let squares = |node: &[f64; STATES]| {
            let parts = [0, 1].map(|k| (node[3 + k] / PASSING[k]).powi(2));
            0.5 * (parts[0] + parts[1])
        };
        let mean = self.nodes.iter().map(squares).sum::<f64>() / self.nodes.len() as f64;
        let [least, most] = PASSING_PARTS;
        self.passing = (PASSING_MARGIN * mean).sqrt().clamp(least, most);
    }

    /// What the wheels lack over the usual, the most of: always; for a while, root mean square over the whole drive;
    /// the same over the last seconds.
    pub(super) fn strain(&self) -> f64 {
        let squares = |node: &[f64; STATES]| {
            let parts = [0, 1].map(|k| (node[3 + k] / PASSING[k]).powi(2));
            0.5 * (parts[0] + parts[1])
        };
        let rms = |nodes: &[[f64; STATES]]| {
            (nodes.iter().map(squares).sum::<f64>() / nodes.len().max(1) as f64).sqrt()
        };
        let late = self.nodes.len().saturating_sub(LATE_NODES);
        let always = [0, 1].map(|k| STEADY_PART * (self.steady[k] / STEADY_SIGMA[k]).abs());
        let passing = rms(&self.nodes).max(rms(&self.nodes[late..]));
        passing.max(always[0]).max(always[1])
    }

    /// What the wheels say against the drive, in nats: minus the logarithm of the likelihood of what they lack for a
    /// while, at the most likely size of it, but for a constant.
    pub(super) fn wheel_cost(&self) -> f64 {
        let (mut squares, mut count) = (0.0, 0.0);
        for (pair, (_, dt)) in self.nodes.windows(2).zip(&self.wheels) {
            let kept = (-dt / PASSING_S).exp();
            for (k, sigma) in PASSING.into_iter().enumerate() {
                let fresh = pair[1][3 + k] - kept * pair[0][3 + k];
                squares += fresh.powi(2) / (sigma.powi(2) * (1.0 - kept * kept));
                count += 1.0;
            }
        }
        let size = (squares / f64::max(count, 1.0))
            .sqrt()
            .max(PASSING_PARTS[0]);
        0.5 * squares / size.powi(2) + count * size.ln()
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

    fn add_priors(&self, normal: &mut Normal, size: usize) {
        let [x, y, heading, turn_rate, speed] = self.nodes[0];
        let [sigma_m, sigma_rad] = START_SIGMA;
        let off = [
            (x - self.start.x_m, sigma_m),
            (y - self.start.y_m, sigma_m),
            (wrap_angle(heading - self.start.heading_rad), sigma_rad),
            (turn_rate, PASSING[0] * self.passing),
            (speed, PASSING[1] * self.passing),
        ];
        for (k, (off, sigma)) in off.into_iter().enumerate() {
            normal.add(off, &[(k, 1.0)], sigma.powi(-2));
        }
        for (k, sigma) in STEADY_SIGMA.into_iter().enumerate() {
            normal.add(self.steady[k], &[(size - STEADY + k, 1.0)], sigma.powi(-2));
        }
    }

    /// Eq. (8) with the wheels' errors as unknowns, from a block to the next one.
    fn add_wheels(&self, normal: &mut Normal, node: usize, size: usize) {
        let (a, b) = (STATES * (node - 1), STATES * node);
        let [always_turn, always_speed] = [size - STEADY, size - STEADY + 1];
        let (from, to) = (self.nodes[node - 1], self.nodes[node]);
        let (wheels, dt) = self.wheels[node - 1];
        let [turn_rate, speed] = self.wheel_errors(node - 1);
        let turn = (wheels.omega_radps + turn_rate) * dt;
        let (sine, cosine) = (from[2] + 0.5 * turn).sin_cos();
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let (along, across) = (dx * cosine + dy * sine, dy * cosine - dx * sine);
        let way = wheels.v_mps * (1.0 + speed) * dt;
        let weight = |density: f64| 1.0 / (density.powi(2) * dt);
        normal.add(
            along - way,
            &[
                (a, -cosine),
                (a + 1, -sine),
                (a + 2, across),
                (a + 3, 0.5 * dt * across),
                (a + 4, -wheels.v_mps * dt),
                (b, cosine),
                (b + 1, sine),
                (always_turn, 0.5 * dt * across),
                (always_speed, -wheels.v_mps * dt),
            ],
            weight(ALONG_M),
        );
        normal.add(
            across,
            &[
                (a, sine),
                (a + 1, -cosine),
                (a + 2, -along),
                (a + 3, -0.5 * dt * along),
                (b, -sine),
                (b + 1, cosine),
                (always_turn, -0.5 * dt * along),
            ],
            weight(ACROSS_M),
        );
        normal.add(
            wrap_angle(to[2] - from[2] - turn),
            &[
                (a + 2, -1.0),
                (a + 3, -dt),
                (b + 2, 1.0),
                (always_turn, -dt),
            ],
            weight(TURN_RAD),
        );
        let kept = (-dt / PASSING_S).exp();
        for (k, sigma) in PASSING.into_iter().enumerate() {
            normal.add(
                to[3 + k] - kept * from[3 + k],
                &[(a + 3 + k, -kept), (b + 3 + k, 1.0)],
                1.0 / ((sigma * self.passing).powi(2) * (1.0 - kept * kept)),
            );
        }
    }

    /// Range and cosine of a peak.
    fn add_echo(
        &self,
        normal: &mut Normal,
        sighting: &Sighting,
        shapes: &[Shape],
        found: &Match,
        range_sigma_m: f64,
        alike_blocks: f64,
    ) {
        let node = STATES * found.node;
        let landmark = STATES * self.nodes.len() + NUMBERS * found.landmark;
        let always_speed = self.size(shapes.len()) - 1;
        let [_, speed] = self.wheel_errors(found.node);
        let echo = shapes[found.landmark].echo(&self.pose(found.node), &sighting.motion);
        let peak = &sighting.peaks[found.peak];
        // Cosines are read with the wheels' speed.
        let slant = 1.0 + speed;
        let range = (peak.range_m - echo.range_m, range_sigma_m);
        let cosine = (peak.cosine - echo.cosine * slant, sighting.cosine_sigma);
        let squares = [range, cosine].map(|(off, sigma)| (off / sigma).powi(2));
        let robust = (TAILS + 2.0) / (TAILS + squares[0] + squares[1]) / alike_blocks;
        let by_pose = |row: &nalgebra::RowVector3<f64>, scale: f64| {
            [0, 1, 2].map(|k| (node + k, -scale * row[k]))
        };
        let by_shape = |by: [f64; 2], scale: f64| [0, 1].map(|k| (landmark + k, -scale * by[k]));
        let [x, y, h] = by_pose(&echo.range_by_pose, 1.0);
        let [one, other] = by_shape(echo.range_by_shape, 1.0);
        normal.add(
            range.0,
            &[x, y, h, one, other],
            robust / range_sigma_m.powi(2),
        );
        let [x, y, h] = by_pose(&echo.cosine_by_pose, slant);
        let [one, other] = by_shape(echo.cosine_by_shape, slant);
        normal.add(
            cosine.0,
            &[
                x,
                y,
                h,
                (node + 4, -echo.cosine),
                one,
                other,
                (always_speed, -echo.cosine),
            ],
            robust / sighting.cosine_sigma.powi(2),
        );
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Priors and wheels of a drive of two steps.
    fn normal(graph: &Graph) -> Normal {
        let size = graph.size(0);
        let mut normal = Normal::new(size);
        graph.add_priors(&mut normal, size);
        for node in 1..graph.nodes.len() {
            graph.add_wheels(&mut normal, node, size);
        }
        normal
    }

    proptest! {
        #[test]
        fn the_wheels_pull_is_the_slope_of_their_cost(
            x in -3.0..3.0, y in -3.0..3.0, heading in -3.0..3.0, v in -0.5..0.5, omega in -1.0..1.0,
            offs in prop::collection::vec(-0.01..0.01, 3 * STATES), steady in prop::array::uniform2(-0.02..0.02),
        ) {
            let start = Pose { x_m: x, y_m: y, heading_rad: heading };
            let wheels = Odometry { v_mps: v, omega_radps: omega };
            let mut graph = Graph::new(start);
            let mut longer = graph.clone();
            longer.wheels = vec![(wheels, 0.1); 2];
            graph.carry_on(&longer);
            graph.steady = steady;
            for (node, offs) in graph.nodes.iter_mut().zip(offs.chunks_exact(STATES)) {
                node.iter_mut().zip(offs).for_each(|(number, off)| *number += off);
            }
            let here = normal(&graph);
            let step = 1e-6;
            for unknown in 0..graph.size(0) {
                let moved = |sign: f64| {
                    let mut moved = graph.clone();
                    let nodes = STATES * moved.nodes.len();
                    let number = match unknown.checked_sub(nodes) {
                        Some(always) => &mut moved.steady[always],
                        None => &mut moved.nodes[unknown / STATES][unknown % STATES],
                    };
                    *number += sign * step;
                    normal(&moved).cost
                };
                let slope = (moved(1.0) - moved(-1.0)) / (2.0 * step);
                let scale = 1.0 + slope.abs();
                prop_assert!((slope + here.pull[unknown]).abs() < 1e-3 * scale, "{unknown}: {slope}");
            }
        }
    }
}
