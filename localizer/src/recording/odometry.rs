//! Wheel odometry over time: `odometry.csv` with the header `t_s,v_mps,omega_radps`.

use std::fmt::Write as _;
use std::path::Path;

use crate::error::Error;
use crate::files;
use crate::pose::Odometry;
use crate::receiver::check_odometry;

/// The first line of the file.
const HEADER: &str = "t_s,v_mps,omega_radps";

/// Longest time between two samples, and between the samples and the ends of the signal, in seconds.
const LONGEST_GAP_S: f64 = 1.0;

/// Speeds at one instant; between two samples they change linearly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometrySample {
    /// Time in seconds since the signal's first sample.
    pub t_s: f64,
    /// Speed along the heading in m/s.
    pub v_mps: f64,
    /// Turning rate in rad/s, positive to the left.
    pub omega_radps: f64,
}

/// Reads `odometry.csv`.
///
/// # Errors
/// [`Error::Io`] when it cannot be read, otherwise those of [`parse`].
pub fn read(path: &Path) -> Result<Vec<OdometrySample>, Error> {
    parse(&files::read_text(path)?, &path.display().to_string())
}

/// Reads the text of an odometry file; `origin` names it in errors.
///
/// # Errors
/// [`Error::Invalid`] with the line that is not three finite numbers or the header that is missing.
pub fn parse(text: &str, origin: &str) -> Result<Vec<OdometrySample>, Error> {
    let mut lines = text.lines().enumerate();
    let remedy = format!("start with the line `{HEADER}`, then three numbers a line");
    let header = lines
        .next()
        .map_or("", |(_, line)| line.trim().trim_start_matches('\u{feff}'));
    if header.split(',').map(str::trim).ne(HEADER.split(',')) {
        return Err(Error::invalid(
            origin,
            "line 1",
            format!("`{header}` is not the header"),
            remedy,
        ));
    }
    lines
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(index, line)| {
            let numbers: Vec<f64> = line
                .split(',')
                .map(|part| {
                    part.trim()
                        .parse()
                        .ok()
                        .filter(|number: &f64| number.is_finite())
                })
                .collect::<Option<_>>()
                .unwrap_or_default();
            match *numbers.as_slice() {
                [t_s, v_mps, omega_radps] => Ok(OdometrySample {
                    t_s,
                    v_mps,
                    omega_radps,
                }),
                _ => {
                    let problem = format!("`{line}` is not three finite numbers");
                    Err(Error::invalid(
                        origin,
                        format!("line {}", index + 1),
                        problem,
                        &remedy,
                    ))
                }
            }
        })
        .collect()
}

/// Writes `odometry.csv` under a temporary name and renames it.
///
/// # Errors
/// [`Error::Io`] when that fails.
pub fn write(path: &Path, samples: &[OdometrySample]) -> Result<(), Error> {
    let mut text = format!("{HEADER}\n");
    for sample in samples {
        // Writing to a string cannot fail. Display prints the shortest text that reads back to the same number.
        let _ = writeln!(
            text,
            "{},{},{}",
            sample.t_s, sample.v_mps, sample.omega_radps
        );
    }
    files::write_bytes(path, text.as_bytes())
}

/// Checks that samples are sorted, usable, and cover 0 to `duration_s` without long gaps.
///
/// # Errors
/// [`Error::Invalid`] with the first sample that does not fit.
pub fn check(
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
        check_odometry(origin, &field, speeds, fastest_mps)?;
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

/// Mean speeds from `start_s` to `end_s`, the samples joined by straight lines and continued at their ends.
///
/// No samples are a robot at rest.
pub fn mean(samples: &[OdometrySample], start_s: f64, end_s: f64) -> Odometry {
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sample(t_s: f64, v_mps: f64) -> OdometrySample {
        OdometrySample {
            t_s,
            v_mps,
            omega_radps: 2.0 * v_mps,
        }
    }

    #[test]
    fn means_integrate_straight_lines() {
        let samples = [sample(0.0, 0.0), sample(1.0, 2.0), sample(2.0, 2.0)];
        assert!((mean(&samples, 0.0, 1.0).v_mps - 1.0).abs() < 1e-12);
        assert!((mean(&samples, 0.5, 1.5).v_mps - 1.75).abs() < 1e-12);
        assert!((mean(&samples, 0.5, 1.5).omega_radps - 3.5).abs() < 1e-12);
        assert!((mean(&samples, 3.0, 4.0).v_mps - 2.0).abs() < 1e-12);
        assert_eq!(mean(&[], 0.0, 1.0), Odometry::default());
    }

    #[test]
    fn unusable_logs_are_refused() {
        let message =
            |samples: &[OdometrySample]| check(samples, 2.0, 34.0, "x").unwrap_err().to_string();
        assert!(message(&[]).contains("no samples"));
        assert!(
            message(&[sample(0.0, 0.1), sample(1.0, 0.1), sample(1.0, 0.1)]).contains("sample 3")
        );
        assert!(message(&[sample(0.0, 0.1), sample(1.5, 0.1)]).contains("no sample between"));
        assert!(message(&[sample(0.0, 0.1), sample(0.5, 0.1)]).contains("covers"));
        assert!(message(&[sample(0.0, f64::NAN)]).contains("cannot be used"));
        assert!(check(&[sample(0.5, 0.1), sample(1.2, 0.1)], 2.0, 34.0, "x").is_ok());
    }

    #[test]
    fn parse_errors_name_the_line() {
        let message = |text: &str| parse(text, "odometry.csv").unwrap_err().to_string();
        assert!(message("").contains("line 1"));
        assert!(message("t,v,w\n").contains("header"));
        assert!(message("t_s,v_mps,omega_radps\n0,1\n").contains("line 2"));
        assert!(message("t_s,v_mps,omega_radps\n0,1,2\n0,inf,2\n").contains("line 3"));
        assert_eq!(
            parse("t_s, v_mps, omega_radps\r\n0, 1, 2\r\n\r\n", "x").unwrap(),
            [sample(0.0, 1.0)]
        );
    }

    proptest! {
        #[test]
        fn text_is_read_back(values in prop::collection::vec((-10.0..10.0, -5.0..5.0, -5.0..5.0), 0..30)) {
            let written: Vec<_> = values
                .iter()
                .map(|&(t_s, v_mps, omega_radps)| OdometrySample { t_s, v_mps, omega_radps })
                .collect();
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("odometry.csv");
            write(&path, &written).unwrap();
            prop_assert_eq!(read(&path).unwrap(), written);
        }

        #[test]
        fn no_text_panics(text in "[0-9,.eE+\\-\n ]{0,200}") {
            let _ = parse(&format!("{HEADER}\n{text}"), "text");
            let _ = parse(&text, "text");
        }

        #[test]
        fn a_mean_lies_between_the_extremes(values in prop::collection::vec(-1.0..1.0, 1..10), start in -1.0..5.0) {
            let samples: Vec<_> = values.iter().enumerate().map(|(k, &v)| sample(0.3 * k as f64, v)).collect();
            let mean = mean(&samples, start, start + 1.0);
            let (low, high) = values.iter().fold((1.0_f64, -1.0_f64), |(l, h), &v| (l.min(v), h.max(v)));
            prop_assert!(mean.v_mps >= low - 1e-9 && mean.v_mps <= high + 1e-9);
        }
    }
}
