//! What the wheels lack: how much is usual, how much a drive shows, and what that says against an estimate.

use super::graph::{Graph, STATES, STEADY};

/// Standard deviations of what the wheels' turn rate (rad/s) and speed (part of one) always lack.
pub(super) const STEADY_SIGMA: [f64; STEADY] = [0.02, 0.02];
/// What turn rate (rad/s) and speed (part of one) of the wheels lack for a while: standard deviations, and the time in
/// seconds over which they last (first-order Gauss-Markov processes).
pub(super) const PASSING: [f64; 2] = [0.02, 0.01];
pub(super) const PASSING_S: f64 = 1.0;
/// Least and largest part of these that a drive may show, and what its mean square is too small by: estimates are
/// drawn to zero.
const PASSING_PARTS: [f64; 2] = [0.15, 2.0];
const PASSING_MARGIN: f64 = 1.5;
/// Weight of what the wheels always lack in the strain.
const STEADY_PART: f64 = 0.6;
/// Blocks at the end that are looked at by themselves.
const LATE_NODES: usize = 40;

impl Graph {
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
}
