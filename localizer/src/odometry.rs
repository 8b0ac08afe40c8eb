//! Wheel odometry: speeds of the robot, sampled over time or as means over periods.

use serde::{Deserialize, Serialize};

use crate::error::Error;

/// Longest time between two samples, and between the samples and the ends of the signal, in seconds.
const LONGEST_GAP_S: f64 = 1.0;

/// Fastest turn of a robot in rad/s: once a second. Beyond it there is a wrong unit.
pub const FASTEST_TURN_RADPS: f64 = std::f64::consts::TAU;

/// Speeds of a two-wheel robot, from its wheel encoders.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Odometry {
    /// Speed along the heading in m/s, negative when reversing.
    pub v_mps: f64,
    /// Turning rate in rad/s, positive to the left.
    pub omega_radps: f64,
}

/// Speeds at one instant; linear between two samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometrySample {
    /// Time in seconds since the signal's first sample.
    pub t_s: f64,
    /// Speed along the heading in m/s.
    pub v_mps: f64,
    /// Turning rate in rad/s, positive to the left.
    pub omega_radps: f64,
}

/// Refuses speeds that are not finite, not small against the speed of sound, or turns that no robot makes.
pub(crate) fn check_speeds(
    origin: impl std::fmt::Display,
    field: impl std::fmt::Display,
    odometry: Odometry,
    fastest_mps: f64,
) -> Result<(), Error> {
    if odometry.v_mps.abs() <= fastest_mps && odometry.omega_radps.abs() <= FASTEST_TURN_RADPS {
        return Ok(());
    }
    let problem = format!(
        "v {} m/s and omega {} rad/s cannot be used",
        odometry.v_mps, odometry.omega_radps
    );
    let remedy = format!(
        "give v within {fastest_mps} m/s and omega within {FASTEST_TURN_RADPS:.2} rad/s, not in degrees"
    );
    Err(Error::invalid(origin, field, problem, remedy))
}

/// Checks that samples are sorted, usable, and cover 0 to `duration_s` without long gaps.
///
/// # Errors
/// [`Error::Invalid`] with the first sample that does not fit.
pub(crate) fn check_samples(
    samples: &[OdometrySample],
    duration_s: f64,
    fastest_mps: f64,
    origin: &str,
) -> Result<(), Error> {
    let refuse = |field: String, problem: String, remedy: &str| {
        Err(Error::invalid(origin, field, problem, remedy))
    };
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
        return refuse(
            "odometry.csv".to_owned(),
            "has no samples".to_owned(),
            "log the wheel speeds during the drive",
        );
    };
    for (index, sample) in samples.iter().enumerate() {
        let field = format!("odometry.csv sample {}", index + 1);
        if !sample.t_s.is_finite() {
            return refuse(
                field,
                "the time is not finite".to_owned(),
                "give finite numbers",
            );
        }
        let speeds = Odometry {
            v_mps: sample.v_mps,
            omega_radps: sample.omega_radps,
        };
        check_speeds(origin, &field, speeds, fastest_mps)?;
        let Some(before) = index.checked_sub(1).map(|before| samples[before].t_s) else {
            continue;
        };
        if sample.t_s <= before {
            return refuse(
                field,
                format!("time {} s follows {before} s", sample.t_s),
                "sort the lines by time",
            );
        }
        if sample.t_s - before > LONGEST_GAP_S {
            let problem = format!("no sample between {before} s and {} s", sample.t_s);
            return refuse(field, problem, "fill gaps above one second");
        }
    }
    if first.t_s > LONGEST_GAP_S || last.t_s < duration_s - LONGEST_GAP_S {
        let problem = format!(
            "covers {} s to {} s, the signal 0 s to {duration_s:.3} s",
            first.t_s, last.t_s
        );
        return refuse(
            "odometry.csv".to_owned(),
            problem,
            "cover the signal to within one second at both ends",
        );
    }
    Ok(())
}

/// Mean speeds from `start_s` to `end_s` (seconds), linear between the samples and continued beyond their ends.
///
/// Without samples the robot rests.
pub fn mean_over_time(samples: &[OdometrySample], start_s: f64, end_s: f64) -> Odometry {
    let length = end_s - start_s;
    if length <= 0.0 {
        return at(samples, start_s);
    }
    let first = samples.partition_point(|sample| sample.t_s <= start_s);
    let inner = samples[first..]
        .iter()
        .take_while(|sample| sample.t_s < end_s)
        .map(|sample| sample.t_s);
    let (mut mean, mut before_s, mut before) = (Odometry::default(), start_s, at(samples, start_s));
    for t_s in inner.chain([end_s]) {
        let here = at(samples, t_s);
        let share = 0.5 * (t_s - before_s) / length;
        mean.v_mps += share * (before.v_mps + here.v_mps);
        mean.omega_radps += share * (before.omega_radps + here.omega_radps);
        (before_s, before) = (t_s, here);
    }
    mean
}

fn at(samples: &[OdometrySample], t_s: f64) -> Odometry {
    let speeds = |sample: &OdometrySample| Odometry {
        v_mps: sample.v_mps,
        omega_radps: sample.omega_radps,
    };
    let next = samples.partition_point(|sample| sample.t_s <= t_s);
    let Some(before) = next.checked_sub(1) else {
        return samples.first().map(speeds).unwrap_or_default();
    };
    let Some(after) = samples.get(next) else {
        return speeds(&samples[before]);
    };
    let share = (t_s - samples[before].t_s) / (after.t_s - samples[before].t_s);
    let (a, b) = (speeds(&samples[before]), speeds(after));
    Odometry {
        v_mps: a.v_mps + share * (b.v_mps - a.v_mps),
        omega_radps: a.omega_radps + share * (b.omega_radps - a.omega_radps),
    }
}

/// Mean of one odometry entry per period between two instants, given in periods from the start of `odometry[0]`.
///
/// Beyond the ends the first and last entry continue. Without entries the robot rests.
pub fn mean_over_periods(odometry: &[Odometry], from_periods: f64, to_periods: f64) -> Odometry {
    let Some(last) = odometry.len().checked_sub(1) else {
        return Odometry::default();
    };
    let length = to_periods - from_periods;
    if length <= 0.0 {
        return odometry[(from_periods.max(0.0) as usize).min(last)];
    }
    let mut mean = Odometry::default();
    let mut start = from_periods;
    while start < to_periods {
        let end = (start.floor() + 1.0).min(to_periods);
        let entry = odometry[(start.floor().max(0.0) as usize).min(last)];
        let share = (end - start) / length;
        mean.v_mps += share * entry.v_mps;
        mean.omega_radps += share * entry.omega_radps;
        start = end;
    }
    mean
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A sample that turns at twice its speed.
    pub(crate) fn sample(t_s: f64, v_mps: f64) -> OdometrySample {
        OdometrySample {
            t_s,
            v_mps,
            omega_radps: 2.0 * v_mps,
        }
    }

    #[test]
    fn means_take_shares_of_periods() {
        let entry = |v_mps: f64| Odometry {
            v_mps,
            omega_radps: -v_mps,
        };
        let odometry = [entry(1.0), entry(2.0), entry(4.0)];
        assert_eq!(mean_over_periods(&odometry, 1.0, 2.0), entry(2.0));
        assert_eq!(mean_over_periods(&odometry, 0.5, 1.5), entry(1.5));
        assert_eq!(mean_over_periods(&odometry, 2.5, 4.5), entry(4.0));
        assert_eq!(mean_over_periods(&[], 0.0, 1.0), entry(0.0));
    }

    #[test]
    fn means_integrate_straight_lines() {
        let samples = [sample(0.0, 0.0), sample(1.0, 2.0), sample(2.0, 2.0)];
        assert!((mean_over_time(&samples, 0.0, 1.0).v_mps - 1.0).abs() < 1e-12);
        assert!((mean_over_time(&samples, 0.5, 1.5).v_mps - 1.75).abs() < 1e-12);
        assert!((mean_over_time(&samples, 0.5, 1.5).omega_radps - 3.5).abs() < 1e-12);
        assert!((mean_over_time(&samples, 3.0, 4.0).v_mps - 2.0).abs() < 1e-12);
        assert_eq!(mean_over_time(&[], 0.0, 1.0), Odometry::default());
    }

    #[test]
    fn unusable_logs_are_refused() {
        let message = |samples: &[OdometrySample]| {
            check_samples(samples, 2.0, 34.0, "x")
                .unwrap_err()
                .to_string()
        };
        assert!(message(&[]).contains("no samples"));
        assert!(
            message(&[sample(0.0, 0.1), sample(1.0, 0.1), sample(1.0, 0.1)]).contains("sample 3")
        );
        assert!(message(&[sample(0.0, 0.1), sample(1.5, 0.1)]).contains("no sample between"));
        assert!(message(&[sample(0.0, 0.1), sample(0.5, 0.1)]).contains("covers"));
        assert!(message(&[sample(0.0, f64::NAN)]).contains("cannot be used"));
        assert!(check_samples(&[sample(0.5, 0.1), sample(1.2, 0.1)], 2.0, 34.0, "x").is_ok());
    }

    proptest! {
        #[test]
        fn a_mean_lies_between_the_extremes(values in prop::collection::vec(-1.0..1.0, 1..10), start in -1.0..5.0) {
            let samples: Vec<_> = values.iter().enumerate().map(|(k, &v)| sample(0.3 * k as f64, v)).collect();
            let mean = mean_over_time(&samples, start, start + 1.0);
            let (low, high) = values.iter().fold((1.0_f64, -1.0_f64), |(l, h), &v| (l.min(v), h.max(v)));
            prop_assert!(mean.v_mps >= low - 1e-9 && mean.v_mps <= high + 1e-9);
        }
    }
}
