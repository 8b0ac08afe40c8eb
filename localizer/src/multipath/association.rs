//! Nearest association of measured and predicted arrival times (2021, eqs. (4) and (5)).

use super::prediction::Arrival;

/// The innovation of one measured arrival, eq. (5), with the Jacobian of its prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Innovation {
    /// Measured minus predicted time in seconds.
    pub error_s: f64,
    /// Derivatives of the predicted time by x, y (s/m) and heading (s/rad).
    pub jacobian: [f64; 3],
}

/// Gives every measured time its nearest prediction; errors beyond the gate are dropped.
pub fn associate(measured_s: &[f64], predicted: &[Arrival], gate_s: f64) -> Vec<Innovation> {
    let nearest = |time: f64| {
        let errors = predicted.iter().map(move |p| Innovation {
            error_s: time - p.time_s,
            jacobian: p.jacobian,
        });
        errors.min_by(|a, b| a.error_s.abs().total_cmp(&b.error_s.abs()))
    };
    measured_s
        .iter()
        .filter_map(|&time| nearest(time))
        .filter(|i| i.error_s.abs() <= gate_s)
        .collect()
}
