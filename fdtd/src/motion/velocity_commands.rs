//! A drive of velocity commands with limited accelerations: speeds are piecewise linear in time, the heading piecewise
//! quadratic.

use super::state::{MAX_DURATION_S, MAX_SPEED_MPS, MAX_TURN_RADPS, MotionState};
use crate::error::Error;

/// One command: drive at this speed and turn rate for this long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityCommand {
    /// Duration in seconds, including the time to reach the commanded speeds.
    pub duration_s: f64,
    /// Commanded speed along the heading in m/s.
    pub v_mps: f64,
    /// Commanded turn rate in rad/s, counter-clockwise.
    pub omega_radps: f64,
}

/// How fast the speeds follow their commands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveLimits {
    /// Acceleration along the heading in m/s^2.
    pub acceleration_mps2: f64,
    /// Angular acceleration in rad/s^2.
    pub angular_acceleration_radps2: f64,
}

impl Default for DriveLimits {
    fn default() -> Self {
        Self {
            acceleration_mps2: 0.5,
            angular_acceleration_radps2: 1.0,
        }
    }
}

/// Longest stretch in seconds over which a position is integrated from a stored one.
const NODE_S: f64 = 2e-3;

/// A stretch of time over which both accelerations are constant.
#[derive(Debug, Clone)]
struct Stretch {
    start_s: f64,
    v_mps: f64,
    acceleration_mps2: f64,
    omega_radps: f64,
    angular_acceleration_radps2: f64,
    heading_rad: f64,
    node_s: f64,
    /// Positions at `start_s + k node_s`, so that a position is one short integral away from a stored one.
    nodes_m: Vec<[f64; 2]>,
}

/// A drive made of stretches in the order of time.
#[derive(Debug, Clone)]
pub(super) struct CommandedCourse {
    stretches: Vec<Stretch>,
    duration_s: f64,
}

impl CommandedCourse {
    /// Checks the numbers and integrates the drive once.
    pub(super) fn new(
        start: MotionState,
        commands: &[VelocityCommand],
        limits: DriveLimits,
    ) -> Result<Self, Error> {
        check(&start, commands, &limits)?;
        let mut stretches = Vec::new();
        let mut now = start;
        let mut command_start_s = 0.0;
        for command in commands {
            let to_v = Ramp::new(now.v_mps, command.v_mps, limits.acceleration_mps2);
            let to_omega = Ramp::new(
                now.omega_radps,
                command.omega_radps,
                limits.angular_acceleration_radps2,
            );
            let mut breaks_s = [
                0.0,
                to_v.duration_s,
                to_omega.duration_s,
                command.duration_s,
            ]
            .map(|t| t.min(command.duration_s));
            breaks_s.sort_by(f64::total_cmp);
            for pair in breaks_s.windows(2) {
                let length_s = pair[1] - pair[0];
                if length_s <= 0.0 {
                    continue;
                }
                let mut stretch = Stretch {
                    start_s: command_start_s + pair[0],
                    v_mps: to_v.value(pair[0]),
                    acceleration_mps2: to_v.rate_after(pair[0]),
                    omega_radps: to_omega.value(pair[0]),
                    angular_acceleration_radps2: to_omega.rate_after(pair[0]),
                    heading_rad: now.heading_rad,
                    node_s: 0.0,
                    nodes_m: Vec::new(),
                };
                stretch.integrate([now.x_m, now.y_m], length_s);
                now = stretch.state(length_s);
                stretches.push(stretch);
            }
            now.v_mps = to_v.value(command.duration_s);
            now.omega_radps = to_omega.value(command.duration_s);
            command_start_s += command.duration_s;
        }
        Ok(Self {
            stretches,
            duration_s: command_start_s,
        })
    }

    pub(super) fn duration_s(&self) -> f64 {
        self.duration_s
    }

    pub(super) fn state_at(&self, t_s: f64) -> MotionState {
        let after = self
            .stretches
            .partition_point(|stretch| stretch.start_s <= t_s);
        let stretch = &self.stretches[after.saturating_sub(1)];
        stretch.state(t_s - stretch.start_s)
    }

    pub(super) fn max_speed_mps(&self, radius_m: f64) -> f64 {
        // Speeds are linear within a stretch, so their extremes are at its ends.
        let ends = self
            .stretches
            .iter()
            .map(|stretch| stretch.start_s)
            .chain([self.duration_s]);
        ends.map(|t_s| {
            let state = self.state_at(t_s);
            state.v_mps.abs() + state.omega_radps.abs() * radius_m
        })
        .fold(0.0, f64::max)
    }
}

impl Stretch {
    /// Fills the table of positions.
    fn integrate(&mut self, start_m: [f64; 2], length_s: f64) {
        let count = (length_s / NODE_S).ceil().max(1.0);
        self.node_s = length_s / count;
        let mut position_m = start_m;
        self.nodes_m.push(position_m);
        for node in 0..count as usize {
            let [dx_m, dy_m] = self.displacement(node as f64 * self.node_s, self.node_s);
            position_m = [position_m[0] + dx_m, position_m[1] + dy_m];
            self.nodes_m.push(position_m);
        }
    }

    /// State at `t_s` after the stretch's start.
    fn state(&self, t_s: f64) -> MotionState {
        let node = ((t_s / self.node_s).floor().max(0.0) as usize).min(self.nodes_m.len() - 1);
        let node_t_s = node as f64 * self.node_s;
        let [dx_m, dy_m] = self.displacement(node_t_s, t_s - node_t_s);
        MotionState {
            x_m: self.nodes_m[node][0] + dx_m,
            y_m: self.nodes_m[node][1] + dy_m,
            heading_rad: self.heading(t_s),
            v_mps: self.v_mps + self.acceleration_mps2 * t_s,
            omega_radps: self.omega_radps + self.angular_acceleration_radps2 * t_s,
        }
    }

    fn heading(&self, t_s: f64) -> f64 {
        self.heading_rad + t_s * (self.omega_radps + 0.5 * self.angular_acceleration_radps2 * t_s)
    }

    /// Displacement from `from_s` over `span_s` by Gauss's two-point rule: its error is of the order of
    /// (omega span)^4 v span / 4320, below 1e-12 m here.
    fn displacement(&self, from_s: f64, span_s: f64) -> [f64; 2] {
        const NODE: f64 = 0.211_324_865_405_187_1; // (1 - 1/sqrt 3) / 2
        let mut sum = [0.0, 0.0];
        for place in [NODE, 1.0 - NODE] {
            let t_s = from_s + place * span_s;
            let (sin, cos) = self.heading(t_s).sin_cos();
            let half_step_m = 0.5 * span_s * (self.v_mps + self.acceleration_mps2 * t_s);
            sum[0] += half_step_m * cos;
            sum[1] += half_step_m * sin;
        }
        sum
    }
}

/// A quantity that runs linearly to its command and stays there.
struct Ramp {
    from: f64,
    to: f64,
    rate: f64,
    duration_s: f64,
}

impl Ramp {
    fn new(from: f64, to: f64, max_rate: f64) -> Self {
        Self {
            from,
            to,
            rate: if to == from {
                0.0
            } else {
                max_rate.copysign(to - from)
            },
            duration_s: (to - from).abs() / max_rate,
        }
    }

    fn value(&self, t_s: f64) -> f64 {
        if t_s >= self.duration_s {
            self.to
        } else {
            self.from + self.rate * t_s
        }
    }

    fn rate_after(&self, t_s: f64) -> f64 {
        if t_s >= self.duration_s {
            0.0
        } else {
            self.rate
        }
    }
}

/// Refuses drives that the limits exclude.
fn check(
    start: &MotionState,
    commands: &[VelocityCommand],
    limits: &DriveLimits,
) -> Result<(), Error> {
    let within = |field: String, value: f64, low: f64, high: f64, unit: &str| {
        if value.is_finite() && (low..=high).contains(&value) {
            return Ok(());
        }
        Err(Error::invalid(
            "path",
            field,
            format!("{value} is out of range"),
            format!("give a number from {low} to {high} {unit}"),
        ))
    };
    const FAR_M: f64 = 1e6;
    within("start.x_m".into(), start.x_m, -FAR_M, FAR_M, "m")?;
    within("start.y_m".into(), start.y_m, -FAR_M, FAR_M, "m")?;
    within(
        "start.heading_rad".into(),
        start.heading_rad,
        -1e3,
        1e3,
        "rad",
    )?;
    within(
        "start.v_mps".into(),
        start.v_mps,
        -MAX_SPEED_MPS,
        MAX_SPEED_MPS,
        "m/s",
    )?;
    within(
        "start.omega_radps".into(),
        start.omega_radps,
        -MAX_TURN_RADPS,
        MAX_TURN_RADPS,
        "rad/s",
    )?;
    within(
        "acceleration_mps2".into(),
        limits.acceleration_mps2,
        1e-3,
        1e6,
        "m/s^2",
    )?;
    within(
        "angular_acceleration_radps2".into(),
        limits.angular_acceleration_radps2,
        1e-3,
        1e6,
        "rad/s^2",
    )?;
    if commands.is_empty() {
        return Err(Error::invalid(
            "path",
            "legs",
            "there is no leg",
            "give at least one {duration_s, v_mps, omega_radps}",
        ));
    }
    for (index, command) in commands.iter().enumerate() {
        within(
            format!("legs[{index}].duration_s"),
            command.duration_s,
            1e-6,
            MAX_DURATION_S,
            "s",
        )?;
        within(
            format!("legs[{index}].v_mps"),
            command.v_mps,
            -MAX_SPEED_MPS,
            MAX_SPEED_MPS,
            "m/s",
        )?;
        within(
            format!("legs[{index}].omega_radps"),
            command.omega_radps,
            -MAX_TURN_RADPS,
            MAX_TURN_RADPS,
            "rad/s",
        )?;
    }
    let total_s: f64 = commands.iter().map(|command| command.duration_s).sum();
    if total_s > MAX_DURATION_S {
        return Err(Error::invalid(
            "path",
            "legs",
            format!("they last {total_s} s together"),
            format!("keep to {MAX_DURATION_S} s"),
        ));
    }
    Ok(())
}
