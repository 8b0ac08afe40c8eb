//! The offset between two logs of one drive, by their speeds and turns.

use crate::odometry::{OdometrySample, mean_over_time};
use crate::pose::wrap_angle;
use crate::trajectory::Trajectory;

/// Steps at which the logs are compared, in seconds.
const STEP_S: f64 = 0.05;

/// Steps between offsets that are tried first, in seconds.
const COARSE_S: f64 = 0.05;

/// Least share of the shorter log that the other must cover.
const LEAST_OVERLAP: f64 = 0.6;

/// Offsets at most, so that long logs take no longer than a moment.
const MOST_OFFSETS: usize = 20_000;

/// A clock's offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offset {
    /// What the other clock shows when the first shows 0, in seconds.
    pub offset_s: f64,
    /// Its standard deviation in seconds.
    pub sigma_s: f64,
}

/// Speeds and turn rates of a trajectory by differences over `[-half, half]` around every instant.
pub fn motion_of(trajectory: &Trajectory, half_s: f64) -> Vec<OdometrySample> {
    let (Some(&first), Some(&last)) = (trajectory.t_s.first(), trajectory.t_s.last()) else {
        return Vec::new();
    };
    let count = (((last - first) / STEP_S).max(0.0) as usize).min(10_000_000);
    (0..=count)
        .filter_map(|k| {
            let t_s = first + k as f64 * STEP_S;
            let (from, to) = ((t_s - half_s).max(first), (t_s + half_s).min(last));
            let (a, b) = (trajectory.pose_at(from)?, trajectory.pose_at(to)?);
            let length_s = to - from;
            if length_s <= 0.0 {
                return None;
            }
            let (dx, dy) = (b.x_m - a.x_m, b.y_m - a.y_m);
            let turn = wrap_angle(b.heading_rad - a.heading_rad);
            let (sine, cosine) = (a.heading_rad + 0.5 * turn).sin_cos();
            Some(OdometrySample {
                t_s,
                v_mps: (dx * cosine + dy * sine) / length_s,
                omega_radps: turn / length_s,
            })
        })
        .collect()
}

/// The offset at which the wheels' speeds and turns are those of the trajectory: what the trajectory's clock shows when
/// the wheels' shows 0. None when the drive has too few changes of speed and turn to tell.
pub fn match_logs(wheels: &[OdometrySample], truth: &Trajectory) -> Option<Offset> {
    let half_s = 0.1;
    let truth = motion_of(truth, half_s);
    let (first, last) = (wheels.first()?.t_s, wheels.last()?.t_s);
    let (from, to) = (truth.first()?.t_s, truth.last()?.t_s);
    let count = ((last - first) / STEP_S) as usize;
    if !(20..10_000_000).contains(&count) {
        return None;
    }
    let wheels: Vec<[f64; 2]> = (0..count)
        .map(|k| {
            let t_s = first + k as f64 * STEP_S;
            let mean = mean_over_time(wheels, t_s - half_s, t_s + half_s);
            [mean.v_mps, mean.omega_radps]
        })
        .collect();
    let scale = [0, 1].map(|axis| {
        let mean = wheels.iter().map(|w| w[axis]).sum::<f64>() / count as f64;
        let power: f64 = wheels.iter().map(|w| (w[axis] - mean).powi(2)).sum();
        // What never changes says nothing.
        (power / count as f64).sqrt().max([0.01, 0.03][axis])
    });
    let at = |t_s: f64| -> Option<[f64; 2]> {
        let place = (t_s - from) / STEP_S;
        let index = place.floor();
        if index < 0.0 {
            return None;
        }
        let (a, b) = (truth.get(index as usize)?, truth.get(index as usize + 1)?);
        let share = place - index;
        let between = |a: f64, b: f64| a + share * (b - a);
        Some([
            between(a.v_mps, b.v_mps),
            between(a.omega_radps, b.omega_radps),
        ])
    };
    let shorter = (last - first).min(to - from);
    let least = (LEAST_OVERLAP * shorter / STEP_S).max(20.0) as usize;
    // Mean square difference at an offset from the wheels' clock to the truth's.
    let cost = |offset_s: f64| -> Option<f64> {
        let (mut sum, mut number) = (0.0, 0_usize);
        for (k, wheel) in wheels.iter().enumerate() {
            let Some(truth) = at(first + k as f64 * STEP_S + offset_s) else {
                continue;
            };
            number += 1;
            let parts = [0, 1].map(|axis| ((wheel[axis] - truth[axis]) / scale[axis]).powi(2));
            sum += parts[0] + parts[1];
        }
        (number >= least).then(|| sum / number as f64)
    };
    let (low, high) = (from - last, to - first);
    let offsets = ((high - low) / COARSE_S) as usize;
    if offsets > MOST_OFFSETS {
        return None;
    }
    let costs: Vec<(f64, f64)> = (0..=offsets)
        .filter_map(|k| {
            let offset_s = low + k as f64 * COARSE_S;
            cost(offset_s).map(|cost| (offset_s, cost))
        })
        .collect();
    let best = costs.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let (mut offset_s, mut step_s) = (best.0, COARSE_S);
    // Two independent speeds a second, whose differences have the least mean square.
    let independent = count as f64 * STEP_S * 2.0;
    let mut bend = 0.0;
    for _ in 0..3 {
        let [before, here, after] =
            [-step_s, 0.0, step_s].map(|by| cost(offset_s + by).unwrap_or(f64::INFINITY));
        bend = (before - 2.0 * here + after) / (step_s * step_s);
        if !(bend.is_finite() && bend > 0.0) {
            return None;
        }
        offset_s += (0.5 * (before - after) / (bend * step_s)).clamp(-step_s, step_s);
        step_s *= 0.5;
    }
    let least_cost = cost(offset_s)?;
    let others = costs
        .iter()
        .filter(|(other, _)| (other - offset_s).abs() > 0.5)
        .fold(f64::INFINITY, |least, &(_, cost)| least.min(cost));
    let sigma_s = (2.0 * least_cost.max(1e-6) / (bend * independent)).sqrt();
    (sigma_s < 0.1 && others > 1.2 * least_cost).then_some(Offset { offset_s, sigma_s })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pose;

    /// A drive with changes of speed and turn.
    fn speeds(t_s: f64) -> [f64; 2] {
        let turn = if (3.0..6.0).contains(&t_s) || (9.0..14.0).contains(&t_s) {
            0.45
        } else {
            0.0
        };
        [
            0.3 + 0.05 * (0.7 * t_s).sin() + 0.03 * (1.9 * t_s).cos(),
            turn,
        ]
    }

    fn drive() -> (Vec<OdometrySample>, Trajectory) {
        let (mut truth, mut pose) = (Trajectory::default(), Pose::default());
        for k in 0..2000 {
            let t_s = 0.01 * f64::from(k);
            let [v, omega] = speeds(t_s);
            truth.t_s.push(1.7e9 + t_s);
            truth.poses.push(pose);
            pose.x_m += 0.01 * v * pose.heading_rad.cos();
            pose.y_m += 0.01 * v * pose.heading_rad.sin();
            pose.heading_rad += 0.01 * omega;
        }
        let wheels = (0..1000).map(|k| {
            let t_s = 0.02 * f64::from(k);
            let [v_mps, omega_radps] = speeds(t_s);
            // A steady slip, and a ripple.
            let omega_radps = omega_radps + 0.01 + 0.02 * (5.0 * t_s).sin();
            OdometrySample {
                t_s: 731.25 + t_s,
                v_mps: 1.01 * v_mps,
                omega_radps,
            }
        });
        (wheels.collect(), truth)
    }

    #[test]
    fn two_logs_of_one_drive_tell_their_offset() {
        let (wheels, truth) = drive();
        let found = match_logs(&wheels, &truth).unwrap();
        // The wheels' 50 Hz cannot tell a sudden turn from one half a sample earlier.
        let error_s = found.offset_s - (1.7e9 - 731.25);
        assert!(
            error_s.abs() < 0.02 && found.sigma_s < 0.05,
            "{error_s} {found:?}"
        );
        // The wheels' log may begin and end elsewhere.
        let part = match_logs(&wheels[150..900], &truth).unwrap();
        assert!((part.offset_s - (1.7e9 - 731.25)).abs() < 0.025, "{part:?}");
    }

    #[test]
    fn a_drive_without_changes_tells_nothing() {
        let (mut wheels, mut truth) = drive();
        for wheel in &mut wheels {
            (wheel.v_mps, wheel.omega_radps) = (0.3, 0.0);
        }
        for (k, pose) in truth.poses.iter_mut().enumerate() {
            *pose = Pose {
                x_m: 0.003 * k as f64,
                ..Pose::default()
            };
        }
        assert_eq!(match_logs(&wheels, &truth), None);
        assert_eq!(match_logs(&[], &truth), None);
    }
}
