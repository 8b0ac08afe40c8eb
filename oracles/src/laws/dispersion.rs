//! Sound on the grid is as fast as the discrete dispersion relation says.
//!
//! Layout: 2.8 m x 2.8 m, with layers of 40 cells; a broad burst from a cell's centre, received 0.5 m and about 1.2 m
//! away along the axis and along the diagonal, with d25 also along 2:1.
//! Formula: `k` solves the scheme's symbol at `4 sin^2(omega dt/2)`; the phase between the two places is that of
//! `H0^(2)(k r)`, and the group delay between them, the derivative of the phase, is
//! `(1/v) Im[r H1^(2)(k r) / H0^(2)(k r)]` at the far place less that at the near one, v the symbol's group velocity.
//! The group delay of a recording p is the real part of the transform of `t p` over that of `p`.
//! Bias: the curvature of the slowness curve changes the near-field term, below 1e-5 here; between axis and diagonal
//! the phase also travels beside the ray, a second-order effect too small to see with d25 only. The group delay gives
//! weight to late arrivals such as the layers' reflection, which is why they are twice as wide here as in scenes.
//! Tolerance: 1e-4 of the phase velocity, while its own error is up to 2.6 % (slf) and 0.7 % (m13), and 2e-4 of the
//! group velocity, whose own error is three times as large (1e-4 below 18 kHz); with d25 the phase velocity also within
//! 0.1 % of the speed of sound to 18 kHz.

use super::measurement::{Depth, Measurement, named, schemes};
use super::rig::Rig;
use super::setting::Setting;
use crate::exact::hankel::{hankel0, hankel1};
use fdtd::Error;
use fdtd::scheme::Scheme;
use std::f64::consts::TAU;

/// Allowed relative errors of phase and group velocity against the dispersion relation.
pub const TOLERANCES: [f64; 2] = [1e-4, 2e-4];

/// A velocity by the dispersion relation over the speed of sound, and the measured one over that, minus 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Velocity {
    /// By the dispersion relation, over the speed of sound.
    pub expected: f64,
    /// Measured over expected value, minus 1.
    pub error: f64,
}

impl Velocity {
    /// Measured speed over the speed of sound, minus 1.
    pub fn off(&self) -> f64 {
        self.expected * (1.0 + self.error) - 1.0
    }
}

/// A measured speed of sound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Velocities {
    /// Where.
    pub setting: Setting,
    /// Scheme.
    pub scheme: Scheme,
    /// Direction from the x axis in radians.
    pub angle_rad: f64,
    /// Frequency in hertz on the papers' grid.
    pub frequency_hz: f64,
    /// Of the phase.
    pub phase: Velocity,
    /// Of a group of waves, whose delay is that of echoes.
    pub group: Velocity,
}

/// Measures the velocities along the direction of whole cells `step`, at frequencies on the papers' grid.
///
/// # Errors
/// When the field becomes non-finite.
pub fn velocities(
    setting: &Setting,
    scheme: Scheme,
    step: [usize; 2],
    frequencies_hz: &[f64],
) -> Result<Vec<Velocities>, Error> {
    let conditions = &setting.conditions;
    let c_mps = conditions.medium.c_mps;
    // As wide as the scheme carries: waves near its cut-off would trail behind.
    let burst = match scheme {
        Scheme::D25 => conditions.burst(9.5e3, 3.5e3),
        Scheme::Slf | Scheme::M13 | Scheme::O13 => conditions.burst(8.5e3, 3e3),
        Scheme::Iwb => conditions.burst(7e3, 2.5e3),
    };
    let strength = |t_s: f64| burst.value(t_s);
    let mut rig = Rig::open(setting, scheme, 560, 560);
    rig.layer_cells = 40;
    let (x, y) = (step[0] as f64, step[1] as f64);
    let angle_rad = y.atan2(x);
    let length_m = conditions.dx_m * x.hypot(y);
    let source = |_: f64| rig.centre_m(140, 140);
    let hear = |r_m: f64| -> Result<(f64, Vec<f64>), Error> {
        let count = (conditions.m(r_m) / length_m).round() as usize;
        let receiver = |_: f64| rig.centre_m(140 + count * step[0], 140 + count * step[1]);
        let signal = rig.run(&source, &receiver, &strength, conditions.steps(1100))?;
        Ok((count as f64 * length_m, signal))
    };
    let (near, far) = (hear(0.5)?, hear(if step[1] == 0 { 1.2 } else { 1.48 })?);
    let grid = scheme.polynomial(rig.courant());
    let measure = |&on_papers_grid_hz: &f64| {
        let frequency_hz = conditions.hz(on_papers_grid_hz);
        let omega_dt = TAU * frequency_hz * conditions.dt_s;
        let phase = grid.phase_velocity(omega_dt, angle_rad)?;
        let group = grid.group_velocity(omega_dt, angle_rad)?;
        let k = TAU * frequency_hz / (c_mps * phase);
        let measured = rig.line(&far.1, frequency_hz) / rig.line(&near.1, frequency_hz);
        let model = hankel0(k * far.0) / hankel0(k * near.0);
        let way = |r_m: f64| r_m * (hankel1(k * r_m) / hankel0(k * r_m)).im;
        let [far_s, near_s] = [&far, &near].map(|at| group_delay_s(&rig, &at.1, frequency_hz));
        let delay_s = far_s - near_s;
        Some(Velocities {
            setting: *setting,
            scheme,
            angle_rad,
            frequency_hz: on_papers_grid_hz,
            phase: Velocity {
                expected: phase,
                error: (measured / model).arg() / (k * (far.0 - near.0)),
            },
            group: Velocity {
                expected: group,
                error: (way(far.0) - way(near.0)) / (delay_s * c_mps * group) - 1.0,
            },
        })
    };
    Ok(frequencies_hz.iter().filter_map(measure).collect())
}

/// Group delay of a recording at a frequency, in seconds.
fn group_delay_s(rig: &Rig, signal: &[f64], frequency_hz: f64) -> f64 {
    let later = signal.iter().zip(0..).map(|(p, n)| p * rig.time_s(n));
    let later: Vec<f64> = later.collect();
    (rig.line(&later, frequency_hz) / rig.line(signal, frequency_hz)).re
}

/// Setting of a direction of whole cells.
pub fn drawn(scheme: Scheme, step: [usize; 2]) -> Setting {
    Setting::drawn("dispersion", &format!("{scheme}, {step:?}"))
}

/// All velocities, each direction of whole cells in its setting.
///
/// # Errors
/// When the field becomes non-finite.
pub fn all(setting: impl Fn(Scheme, [usize; 2]) -> Setting) -> Result<Vec<Velocities>, Error> {
    let mut found = Vec::new();
    for scheme in schemes() {
        // Further up the coarse schemes run into their cut-off.
        let (directions, frequencies_hz): (&[[usize; 2]], &[f64]) = match scheme {
            Scheme::D25 => (
                &[[1, 0], [1, 1], [2, 1]],
                &[4e3, 7e3, 10e3, 13e3, 16e3, 18e3],
            ),
            _ => (&[[1, 0], [1, 1]], &[4e3, 7e3, 10e3, 13e3]),
        };
        for &step in directions {
            let setting = setting(scheme, step);
            found.extend(velocities(&setting, scheme, step, frequencies_hz)?);
        }
    }
    Ok(found)
}

/// The law's measurements.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure(_: Depth) -> Result<Vec<Measurement>, Error> {
    let mut found = Vec::new();
    for velocity in all(drawn)? {
        let case = format!(
            "{}, {:.0} degrees, {} kHz",
            velocity.scheme,
            velocity.angle_rad.to_degrees(),
            velocity.frequency_hz / 1e3
        );
        let case = named(&case, &velocity.setting);
        let [of_phase, of_group] = TOLERANCES;
        for (quantity, velocity, allowed) in [
            (
                "phase velocity over the relation's - 1",
                velocity.phase,
                of_phase,
            ),
            (
                "group velocity over the relation's - 1",
                velocity.group,
                of_group,
            ),
        ] {
            found.push(Measurement::within(
                case.clone(),
                quantity,
                velocity.error,
                allowed,
            ));
        }
        let (quantity, off) = ("phase velocity over c - 1", velocity.phase.off());
        let held = velocity.scheme == Scheme::D25;
        found.push(Measurement::held(held, case.clone(), quantity, off, 1e-3));
        let (quantity, off) = ("group velocity over c - 1", velocity.group.off());
        found.push(Measurement::shown(case, quantity, off));
    }
    Ok(found)
}
