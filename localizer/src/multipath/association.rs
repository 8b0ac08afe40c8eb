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

#[cfg(test)]
mod tests {
    use super::*;

    fn arrival(time_s: f64) -> Arrival {
        Arrival {
            time_s,
            jacobian: [time_s, 0.0, 0.0],
        }
    }

    #[test]
    fn every_time_takes_its_nearest_prediction_within_the_gate() {
        let predicted = [arrival(0.020), arrival(0.010), arrival(0.013)];
        let found = associate(&[0.0105, 0.0121, 0.0165, 0.0195], &predicted, 0.001);
        let pairs: Vec<(f64, f64)> = found
            .iter()
            .map(|i| (i.jacobian[0], (i.error_s * 1e7).round() * 1e-7))
            .collect();
        // 16.5 ms is 3.5 ms from its neighbours.
        assert_eq!(pairs.len(), 3);
        let expected = [(0.010, 0.0005), (0.013, -0.0009), (0.020, -0.0005)];
        for ((time, error), (known, by)) in pairs.iter().zip(expected) {
            assert!((time - known).abs() < 1e-12 && (error - by).abs() < 1e-9);
        }
    }

    #[test]
    fn nothing_predicted_or_measured_gives_no_innovation() {
        assert!(associate(&[0.01], &[], 1.0).is_empty());
        assert!(associate(&[], &[arrival(0.01)], 1.0).is_empty());
    }
}
