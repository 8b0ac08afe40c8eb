//! The equations between blocks, wheels and landmarks, as normal equations.

use nalgebra::DVector;
use nalgebra_sparse::CooMatrix;

use super::graph::{Graph, Match, NUMBERS, STATES, STEADY};
use super::wheels::{PASSING, PASSING_S, STEADY_SIGMA};
use crate::landmarks::Sighting;
use crate::landmarks::landmark::Shape;
use crate::pose::wrap_angle;

/// Standard deviations of the start's position (m) and heading (rad), which say where the frame of the map is.
pub(super) const START_SIGMA: [f64; 2] = [1e-4, 1e-4];
/// White noise of the wheels along the way and across it (metres per root second), and of the heading (radians per
/// root second): what they do not lack for a while or always.
const ALONG_M: f64 = 0.001;
const ACROSS_M: f64 = 0.001;
const TURN_RAD: f64 = 0.002;
/// Degrees of freedom of the residuals' heavy tails.
const TAILS: f64 = 4.0;

/// Normal equations under construction.
pub(super) struct Normal {
    pub(super) triplets: CooMatrix<f64>,
    pub(super) pull: DVector<f64>,
    /// Half the sum of the weighted squares of the residuals.
    cost: f64,
}

impl Normal {
    pub(super) fn new(size: usize) -> Self {
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
    pub(super) fn add_priors(&self, normal: &mut Normal, size: usize) {
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
    pub(super) fn add_wheels(&self, normal: &mut Normal, node: usize, size: usize) {
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
    pub(super) fn add_echo(
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::odometry::Odometry;
    use crate::pose::Pose;
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
