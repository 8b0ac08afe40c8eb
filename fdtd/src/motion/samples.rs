//! A drive through measured poses, joined by cubic splines that are C2 in x, y and heading.

use super::state::{MAX_DURATION_S, MAX_SPEED_MPS, MAX_TURN_RADPS, MotionState, relocate};
use crate::error::Error;
use std::path::Path;

/// A measured pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseSample {
    /// Time in seconds.
    pub t_s: f64,
    /// Position in metres.
    pub x_m: f64,
    /// Position in metres.
    pub y_m: f64,
    /// Heading in radians; a turn between two samples is taken the short way.
    pub heading_rad: f64,
}

/// Splines of x, y and heading over common knots.
#[derive(Debug, Clone)]
pub(super) struct SampledCourse {
    knots_s: Vec<f64>,
    /// x, y, heading at each knot.
    values: Vec<[f64; 3]>,
    /// Their derivatives with respect to time at each knot.
    slopes: Vec<[f64; 3]>,
}

impl SampledCourse {
    /// Checks the samples and fits the splines.
    pub(super) fn new(samples: &[PoseSample]) -> Result<Self, Error> {
        check(samples)?;
        let start_s = samples[0].t_s;
        let knots_s: Vec<f64> = samples.iter().map(|sample| sample.t_s - start_s).collect();
        let mut heading_rad = samples[0].heading_rad;
        let values: Vec<[f64; 3]> = samples
            .iter()
            .map(|sample| {
                let turn = (sample.heading_rad - heading_rad).rem_euclid(std::f64::consts::TAU);
                heading_rad += if turn > std::f64::consts::PI {
                    turn - std::f64::consts::TAU
                } else {
                    turn
                };
                [sample.x_m, sample.y_m, heading_rad]
            })
            .collect();
        let slopes = spline_slopes(&knots_s, &values);
        let course = Self {
            knots_s,
            values,
            slopes,
        };
        let (speed_mps, turn_radps) = (course.max_speed_mps(0.0), course.bound(2));
        if speed_mps > MAX_SPEED_MPS || turn_radps > MAX_TURN_RADPS {
            return Err(Error::invalid(
                "path",
                "samples",
                format!("they jump: up to {speed_mps:.3} m/s and {turn_radps:.3} rad/s"),
                format!("give a drive within {MAX_SPEED_MPS} m/s and {MAX_TURN_RADPS} rad/s"),
            ));
        }
        Ok(course)
    }

    pub(super) fn duration_s(&self) -> f64 {
        self.knots_s[self.knots_s.len() - 1]
    }

    pub(super) fn state_at(&self, t_s: f64) -> MotionState {
        let left = self
            .knots_s
            .partition_point(|&knot_s| knot_s <= t_s)
            .clamp(1, self.knots_s.len() - 1)
            - 1;
        let span_s = self.knots_s[left + 1] - self.knots_s[left];
        let u = (t_s - self.knots_s[left]) / span_s;
        let mut value = [0.0; 3];
        let mut slope = [0.0; 3];
        for axis in 0..3 {
            let rise = self.values[left + 1][axis] - self.values[left][axis];
            let first = self.slopes[left][axis] * span_s;
            let last = self.slopes[left + 1][axis] * span_s;
            // Cubic Hermite polynomial written from the left value, so that a resting robot rests exactly.
            let (quadratic, cubic) = (3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise);
            value[axis] = self.values[left][axis] + u * (first + u * (quadratic + u * cubic));
            slope[axis] = (first + u * (2.0 * quadratic + u * 3.0 * cubic)) / span_s;
        }
        let (sin, cos) = value[2].sin_cos();
        MotionState {
            x_m: value[0],
            y_m: value[1],
            heading_rad: value[2],
            v_mps: slope[0] * cos + slope[1] * sin,
            omega_radps: slope[2],
        }
    }

    pub(super) fn max_speed_mps(&self, radius_m: f64) -> f64 {
        self.bound(0).hypot(self.bound(1)) + self.bound(2) * radius_m
    }

    /// A bound on the slope of one of the three splines: the largest control value of its derivative (a quadratic).
    fn bound(&self, axis: usize) -> f64 {
        let mut largest: f64 = 0.0;
        for left in 0..self.knots_s.len() - 1 {
            let span_s = self.knots_s[left + 1] - self.knots_s[left];
            let mean = (self.values[left + 1][axis] - self.values[left][axis]) / span_s;
            let (first, last) = (self.slopes[left][axis], self.slopes[left + 1][axis]);
            let middle = 3.0 * mean - first - last;
            largest = largest.max(first.abs()).max(last.abs()).max(middle.abs());
        }
        largest
    }
}

/// Knot slopes of the C2 cubic splines through `values`, see [`axis_slopes`].
fn spline_slopes(knots_s: &[f64], values: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let along = |axis: usize| {
        let column: Vec<f64> = values.iter().map(|value| value[axis]).collect();
        axis_slopes(knots_s, &column)
    };
    let (x, y, heading) = (along(0), along(1), along(2));
    (0..knots_s.len())
        .map(|i| [x[i], y[i], heading[i]])
        .collect()
}

/// Knot slopes of the C2 cubic spline through `values`, with the end slopes of the parabola through the three outermost
/// knots (of the line for two knots).
fn axis_slopes(knots_s: &[f64], values: &[f64]) -> Vec<f64> {
    let last = knots_s.len() - 1;
    let span = |i: usize| knots_s[i + 1] - knots_s[i];
    let chord = |i: usize| (values[i + 1] - values[i]) / span(i);
    if last == 1 {
        return vec![chord(0); 2];
    }
    let end = |near: usize, far: usize| {
        let (h0, h1) = (span(near), span(far));
        ((2.0 * h0 + h1) * chord(near) - h0 * chord(far)) / (h0 + h1)
    };
    let mut slopes = vec![0.0; last + 1];
    let mut upper = vec![0.0; last + 1];
    slopes[0] = end(0, 1);
    slopes[last] = end(last - 1, last - 2);
    // Thomas's algorithm on h1 m[i-1] + 2 (h0 + h1) m[i] + h0 m[i+1] = 3 (h1 c[i-1] + h0 c[i]).
    for i in 1..last {
        let (h0, h1) = (span(i - 1), span(i));
        let right = 3.0 * (h1 * chord(i - 1) + h0 * chord(i));
        let pivot = 2.0 * (h0 + h1) - h1 * upper[i - 1];
        upper[i] = h0 / pivot;
        slopes[i] = (right - h1 * slopes[i - 1]) / pivot;
    }
    for i in (1..last).rev() {
        slopes[i] -= upper[i] * slopes[i + 1];
    }
    slopes
}

fn check(samples: &[PoseSample]) -> Result<(), Error> {
    if samples.len() < 2 {
        return Err(Error::invalid(
            "path",
            "samples",
            format!("there are {}", samples.len()),
            "give at least two poses",
        ));
    }
    for (index, sample) in samples.iter().enumerate() {
        let numbers = [sample.t_s, sample.x_m, sample.y_m, sample.heading_rad];
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(Error::invalid(
                "path",
                format!("samples[{index}]"),
                "a number is not finite",
                "give finite numbers",
            ));
        }
        if index > 0 && sample.t_s <= samples[index - 1].t_s {
            return Err(Error::invalid(
                "path",
                format!("samples[{index}]"),
                format!(
                    "time {} s does not come after {} s",
                    sample.t_s,
                    samples[index - 1].t_s
                ),
                "sort the lines by time and keep each time once",
            ));
        }
    }
    let duration_s = samples[samples.len() - 1].t_s - samples[0].t_s;
    if duration_s > MAX_DURATION_S {
        return Err(Error::invalid(
            "path",
            "samples",
            format!("they last {duration_s} s"),
            format!("keep to {MAX_DURATION_S} s"),
        ));
    }
    Ok(())
}

/// Reads the poses of a CSV or TUM file; see [`super::DrivePath::read`].
pub(super) fn read(file: &Path) -> Result<Vec<PoseSample>, Error> {
    let text = std::fs::read_to_string(file).map_err(|source| Error::io(file, source))?;
    let is_csv = file
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
    parse(&text, is_csv).map_err(|error| relocate(error, file.display(), ""))
}

pub(super) fn parse(text: &str, is_csv: bool) -> Result<Vec<PoseSample>, Error> {
    const HEADER: &str = "t_s,x_m,y_m,heading_rad";
    let (form, columns) = if is_csv {
        (HEADER, 4)
    } else {
        ("t x y z qx qy qz qw", 8)
    };
    let mut samples = Vec::new();
    let mut header_seen = !is_csv;
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let here = format!("line {}", index + 1);
        if !header_seen {
            if line != HEADER {
                return Err(Error::invalid(
                    "path",
                    here,
                    format!("`{}` is not the header", shorten(line)),
                    format!("begin with `{HEADER}`"),
                ));
            }
            header_seen = true;
            continue;
        }
        let fields: Vec<&str> = if is_csv {
            line.split(',').map(str::trim).collect()
        } else {
            line.split_whitespace().collect()
        };
        if fields.len() != columns {
            return Err(Error::invalid(
                "path",
                here,
                format!("{} columns", fields.len()),
                format!("write `{form}`"),
            ));
        }
        let mut numbers = [0.0; 8];
        for (number, field) in numbers.iter_mut().zip(&fields) {
            *number = match field.parse::<f64>() {
                Ok(value) if value.is_finite() => value,
                _ => {
                    return Err(Error::invalid(
                        "path",
                        here,
                        format!("`{}` is not a finite number", shorten(field)),
                        format!("write `{form}`"),
                    ));
                }
            };
        }
        let heading_rad = if is_csv {
            numbers[3]
        } else {
            let [qx, qy, qz, qw] = [numbers[4], numbers[5], numbers[6], numbers[7]];
            let norm = qx * qx + qy * qy + qz * qz + qw * qw;
            if !(0.9..1.1).contains(&norm) {
                return Err(Error::invalid(
                    "path",
                    here,
                    "the quaternion is not of unit length",
                    "give qx qy qz qw with norm 1",
                ));
            }
            (2.0 * (qw * qz + qx * qy)).atan2(1.0 - 2.0 * (qy * qy + qz * qz))
        };
        samples.push(PoseSample {
            t_s: numbers[0],
            x_m: numbers[1],
            y_m: numbers[2],
            heading_rad,
        });
    }
    Ok(samples)
}

/// The first characters of a file's content, for an error message of one line.
fn shorten(text: &str) -> String {
    let mut short: String = text.chars().take(40).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    short
}
