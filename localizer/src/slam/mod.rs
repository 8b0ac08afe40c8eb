//! Simultaneous localization and mapping: no map and no truth, only sound and wheels.
//!
//! Landmarks are learnt from the first seconds by the wheels alone. Then drive, errors of the wheels and landmarks are
//! estimated together ([`graph`]), learnt anew at the better poses, and estimated again ([`joint`]). Every few seconds
//! the drive is longer: until then a filter follows the newest blocks among the landmarks found so far
//! ([`estimator`]).

mod associate;
mod equations;
mod estimator;
mod graph;
mod joint;
mod wheels;

pub use self::estimator::{Drive, Newest, Slam};

use crate::echo::EchoSequence;
use crate::landmarks::Noise;
use crate::pose::Pose;

/// Estimates a drive whose echoes are measured, from a start.
pub fn slam(echoes: &EchoSequence, start: Pose, noise: Noise) -> Drive {
    let mut slam = Slam::new(&echoes.parameters, start, noise);
    for (index, block) in echoes.blocks.iter().enumerate() {
        slam.update(block, echoes.recent_odometry(index));
    }
    slam.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landmarks::Status;
    use crate::landmarks::simulated::{self, Block, Drive as Simulated};
    use crate::pose::wrap_angle;

    /// The blocks of a drive in a place of known landmarks, and what is made of them.
    fn estimate(seed: u64, blocks: usize, wheel_errors: [f64; 2]) -> (Vec<Block>, Drive) {
        let mut simulated = Simulated::new(seed, simulated::shapes());
        simulated.wheel_errors = wheel_errors;
        let parameters = simulated.parameters.clone();
        // The frame is that of the start, where the robot rests for a moment.
        let start = simulated.pose();
        let blocks: Vec<Block> = simulated.take(blocks).collect();
        let mut slam = Slam::new(&parameters, start, Noise::default());
        for (index, block) in blocks.iter().enumerate() {
            let t_s = (index + 1) as f64 * parameters.period_s();
            let recent = [block.odometry; 3];
            let recent = if index == 0 { &recent[..2] } else { &recent };
            slam.take(t_s, block.odometry, Some(block.sighting.clone()), recent);
        }
        (blocks, slam.finish())
    }

    #[test]
    fn drive_landmarks_and_errors_of_the_wheels_are_found_together() {
        for seed in 1..=8 {
            let errors = [[0.01, 0.01], [-0.015, 0.0], [0.0, -0.012]][seed as usize % 3];
            let (blocks, drive) = estimate(seed, 300, errors);
            let off: Vec<f64> = drive
                .estimates
                .iter()
                .zip(&blocks)
                .map(|(estimate, block)| estimate.pose.distance_m(&block.truth))
                .collect();
            let mean = off.iter().sum::<f64>() / off.len() as f64;
            assert!(mean < 0.01, "seed {seed}: {mean} m");
            assert!(drive.estimates.iter().all(|e| e.status == Status::Sure));
            let [turn_rate, speed] = drive.wheel_errors;
            assert!(
                (turn_rate + errors[0]).abs() < 0.002,
                "seed {seed}: {turn_rate}"
            );
            assert!((speed + errors[1]).abs() < 0.004, "seed {seed}: {speed}");
            let map = drive.map.expect("landmarks");
            assert_eq!(
                map.landmarks.len(),
                simulated::shapes().len(),
                "seed {seed}"
            );
            let last = drive.estimates[drive.estimates.len() - 1];
            let turned = wrap_angle(last.pose.heading_rad - blocks[299].truth.heading_rad);
            assert!(turned.abs() < 0.02, "seed {seed}: {turned} rad");
        }
    }

    #[test]
    fn the_same_blocks_give_the_same_bytes() {
        let text = || format!("{:?}", estimate(3, 120, [0.01, 0.01]).1);
        assert_eq!(text(), text());
    }

    #[test]
    fn without_echoes_nothing_is_sure() {
        let simulated = Simulated::new(1, Vec::new());
        let (parameters, start) = (simulated.parameters.clone(), simulated.pose());
        let mut slam = Slam::new(&parameters, start, Noise::default());
        for (index, block) in simulated.take(150).enumerate() {
            let t_s = (index + 1) as f64 * parameters.period_s();
            let mut sighting = block.sighting;
            sighting.peaks.clear();
            let newest = slam.take(t_s, block.odometry, Some(sighting), &[block.odometry; 3]);
            assert_eq!(newest.status, Status::Converging);
        }
        let drive = slam.finish();
        assert!(drive.map.is_none());
        assert!(drive.estimates.iter().all(|e| e.status == Status::Lost));
        let nothing = Slam::new(&parameters, start, Noise::default()).finish();
        assert!(nothing.estimates.is_empty() && nothing.map.is_none());
    }
}
