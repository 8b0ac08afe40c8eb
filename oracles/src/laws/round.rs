//! Round walls: the field before, beside and behind a rigid cylinder, and standing waves in a round room.
//!
//! Layout, cylinder: a closed wall of 180 chords (10 mm, two cells) whose surface has a radius of 0.3 m, with its axis
//! in three places of a cell; a burst of 10 kHz from 0.42 m before the surface in the direction of 0, 10, 30 and 45
//! degrees. Received 0.38 m before it on the same line, less a run without the cylinder: the echo. Received 0.1 m from
//! the surface 120 degrees round the axis: in the shadow, reached by the creeping wave.
//! Formula: the series of a rigid cylinder, [`crate::exact::cylinder`].
//! Bias: dispersion on the way, which is not the wall's; the reference is the field itself in an open grid, for the
//! echo 0.8 m from the source towards the axis, for the shadow where the microphone is, times the ratio by
//! the series.
//! Tolerance: 0.3 dB and 2 us for the echo, 0.6 dB and 2 us in the shadow (m13, o13, d25). Stairs are shown beside it.
//!
//! Layout, room: the same wall seen from within, radius 0.3 m; the field starts as one standing wave and is left alone
//! for 1200 steps (10 ms).
//! Formula: `J_m(kappa r) cos(m phi)`, `J_m'(kappa a) = 0`, at the frequency that the scheme's waves of the wave number
//! `kappa` have in the mean over directions.
//! Bias: the restoring quantum's share is taken off.
//! Tolerance: 2e-4 of the frequency, a radius right within 0.06 mm. Stairs are shown beside it.

use super::conditions::Conditions;
use super::measurement::{Depth, Measurement, larger, named};
use super::rig::{Rig, decibels, difference, wrapped};
use super::setting::Setting;
use crate::exact::cylinder::{mode, scattered, standing};
use crate::exact::hankel::hankel;
use fdtd::Error;
use fdtd::scheme::{RESTORING_QUANTUM, Scheme};
use fdtd::walls::{Wall, WallModel};
use std::f64::consts::{PI, TAU};

/// Frequency of the bursts in hertz, on the papers' grid as all that follows.
const FREQUENCY_HZ: f64 = 10e3;
/// Radius of the surface in metres.
const RADIUS_M: f64 = 0.3;
/// Thickness of the wall in metres.
const THICKNESS_M: f64 = 0.02;
const CHORDS: usize = 180;

/// Directions of the source from the axis in degrees.
pub const BEARINGS_DEG: [f64; 4] = [0.0, 10.0, 30.0, 45.0];

/// Angles round the axis from the source to the microphone in degrees, and the largest errors of cut cells: level in
/// dB, delay in s.
pub const ROUND: [(f64, [f64; 2]); 2] = [(0.0, [0.3, 2e-6]), (120.0, [0.6, 2e-6])];

/// Numbers of the standing waves: of periods round the axis, and of the zero.
pub const MODES: [(i32, usize); 6] = [(0, 1), (1, 1), (3, 2), (0, 6), (5, 4), (16, 2)];

/// Largest relative error of a standing wave's frequency.
pub const DETUNING: f64 = 2e-4;

/// Schemes that the tolerance applies to; slf is shown.
pub const SCHEMES: [Scheme; 3] = [Scheme::M13, Scheme::O13, Scheme::D25];

/// Places of the axis in a cell.
const PLACES: [[f64; 2]; 3] = [[0.0, 0.0], [0.31, 0.17], [0.62, 0.87]];

/// A closed wall whose outer (`side` 1) or inner (-1) surface has a mean distance of [`RADIUS_M`] from the axis.
fn ring(conditions: &Conditions, axis_m: [f64; 2], side: f64) -> Wall {
    // A chord lies up to `1 - cos` inside the circle through its ends, two thirds of it in the mean.
    let sagging = 2.0 / 3.0 * (1.0 - (PI / CHORDS as f64).cos());
    let middle_m = conditions.m(RADIUS_M / (1.0 - sagging) - side * 0.5 * THICKNESS_M);
    let mut points_m: Vec<[f64; 2]> = (0..CHORDS)
        .map(|chord| at(axis_m, middle_m, TAU * chord as f64 / CHORDS as f64))
        .collect();
    points_m.push(points_m[0]);
    Wall {
        points_m,
        thickness_m: conditions.m(THICKNESS_M),
        impedance: None,
    }
}

/// The point at a distance in metres from the axis, in a direction.
fn at(axis_m: [f64; 2], distance_m: f64, angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    [axis_m[0] + distance_m * cos, axis_m[1] + distance_m * sin]
}

/// Error of the signal of a cylinder, `round_deg` round the axis from the source (0 for the echo): level in dB and
/// delay in s on the papers' grid.
///
/// # Errors
/// When the field becomes non-finite.
pub fn cylinder(
    setting: &Setting,
    scheme: Scheme,
    model: WallModel,
    bearing_deg: f64,
    round_deg: f64,
    place: [f64; 2],
) -> Result<[f64; 2], Error> {
    let conditions = &setting.conditions;
    let open = Rig::open(setting, scheme, 300, 300);
    let axis_m = place.map(|place| conditions.m(0.58) + place * conditions.dx_m);
    let walled = open
        .clone()
        .with_model(model, &[ring(conditions, axis_m, 1.0)]);
    let echo = round_deg == 0.0;
    let (bearing, round) = (bearing_deg.to_radians(), round_deg.to_radians());
    let radius = conditions.m(RADIUS_M);
    let source = radius + conditions.m(0.42);
    let recorded = radius + conditions.m(if echo { 0.38 } else { 0.1 });
    let source_m = at(axis_m, source, bearing);
    let burst = conditions.burst(FREQUENCY_HZ, 1000.0);
    let longest_s = conditions.m(if echo { 0.8 } else { 1.8 }) / conditions.medium.c_mps;
    let steps = ((longest_s + 2.0 * burst.centre_s) / conditions.dt_s) as usize;
    let hear = |rig: &Rig, microphone_m: [f64; 2]| -> Result<Vec<f64>, Error> {
        rig.run(
            &|_| source_m,
            &|_| microphone_m,
            &|t_s| burst.value(t_s),
            steps,
        )
    };
    let microphone_m = at(axis_m, recorded, bearing + round);
    let measured = hear(&walled, microphone_m)?;
    let alone = hear(&open, microphone_m)?;
    let k = TAU * burst.frequency_hz / conditions.medium.c_mps;
    let series = scattered(k * radius, [k * source, k * recorded], round);
    // The measured signal, its reference, and their ratio by the series.
    let (measured, reference, exact) = if echo {
        let way = conditions.m(0.8);
        let behind = hear(&open, at(axis_m, source - way, bearing))?;
        (
            difference(&measured, &alone),
            behind,
            series / hankel(0, k * way),
        )
    } else {
        let [dx, dy] = [0, 1].map(|axis| microphone_m[axis] - source_m[axis]);
        let incident = hankel(0, k * dx.hypot(dy));
        (measured, alone, (series + incident) / incident)
    };
    let expected = exact * open.line(&reference, burst.frequency_hz);
    let ratio = open.line(&measured, burst.frequency_hz) / expected;
    Ok([decibels(ratio.norm()), -ratio.arg() / (TAU * FREQUENCY_HZ)])
}

/// Setting of a case, the same for all models of the wall.
pub fn setting(scheme: Scheme, what: &str) -> Setting {
    Setting::drawn("round walls", &format!("{scheme}, {what}"))
}

/// The largest errors of level in dB and delay in s over directions of the source and places of the axis (one in the
/// shadow), with their signs.
///
/// # Errors
/// When the field becomes non-finite.
pub fn largest(
    setting: &Setting,
    scheme: Scheme,
    model: WallModel,
    round_deg: f64,
) -> Result<[f64; 2], Error> {
    let places = if round_deg == 0.0 {
        &PLACES[..]
    } else {
        &PLACES[1..2]
    };
    let mut most = [0.0_f64; 2];
    for bearing_deg in BEARINGS_DEG {
        for &place in places {
            let error = cylinder(setting, scheme, model, bearing_deg, round_deg, place)?;
            most = [0, 1].map(|i| larger(most[i], error[i]));
        }
    }
    Ok(most)
}

/// Relative error of the frequency of a standing wave in a round room, the largest over places of the axis.
pub fn detuned(setting: &Setting, scheme: Scheme, model: WallModel, mode: (i32, usize)) -> f64 {
    PLACES
        .map(|place| detuned_at(setting, scheme, model, mode, place))
        .into_iter()
        .fold(0.0, larger)
}

fn detuned_at(
    setting: &Setting,
    scheme: Scheme,
    model: WallModel,
    (m, which): (i32, usize),
    place: [f64; 2],
) -> f64 {
    let conditions = &setting.conditions;
    let mut rig = Rig::open(setting, scheme, 140, 140);
    rig.layer_cells = 0;
    let axis_m = place.map(|place| conditions.m(0.35) + place * conditions.dx_m);
    let rig = rig.with_model(model, &[ring(conditions, axis_m, -1.0)]);
    let radius_m = conditions.m(RADIUS_M);
    let kappa = mode(m, which) / radius_m;
    let omega_dt = wave(&rig, kappa);
    let mut shape = rig.cells(|ix, iy| {
        let x_m = rig.centre_m(ix, iy);
        let [x, y] = [x_m[0] - axis_m[0], x_m[1] - axis_m[1]];
        // Cells that the wall cuts have their middle up to a cell beyond it; beyond the wall is another room.
        if x.hypot(y) > radius_m + conditions.dx_m {
            return 0.0;
        }
        standing(m, kappa * x.hypot(y), y.atan2(x))
    });
    for (pressure, area) in shape.iter_mut().zip(rig.walls.areas()) {
        if area == 0.0 {
            *pressure = 0.0;
        }
    }
    let steps = conditions.steps(1200);
    let phase = omega_dt * steps as f64;
    wrapped(rig.swing(&shape, omega_dt, steps).turned_rad - phase) / phase
}

/// Radians per step of a wave of `kappa` radians per metre, in the mean over directions, with the restoring quantum.
fn wave(rig: &Rig, kappa: f64) -> f64 {
    const DIRECTIONS: usize = 32;
    let polynomial = rig.polynomial();
    let mean = (0..DIRECTIONS)
        .map(|direction| {
            let angle = 0.25 * PI * (direction as f64 + 0.5) / DIRECTIONS as f64;
            let stiffness =
                |part: f64| 4.0 * (0.5 * kappa * rig.conditions().dx_m * part).sin().powi(2);
            polynomial.symbol(stiffness(angle.cos()), stiffness(angle.sin()))
        })
        .sum::<f64>()
        / DIRECTIONS as f64;
    2.0 * (0.5 * (mean + f64::from(RESTORING_QUANTUM)).sqrt()).asin()
}

/// The law's measurements.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let schemes = match depth {
        Depth::Quick => &SCHEMES[1..2],
        Depth::Full => &Scheme::ALL[..],
    };
    let mut found = Vec::new();
    for &scheme in schemes {
        for model in WallModel::ALL {
            let held = model == WallModel::CutCells && SCHEMES.contains(&scheme);
            let mut push = |what: String, setting: &Setting, quantity, error, allowed| {
                let case = named(&format!("{scheme}, {model}, {what}"), setting);
                found.push(Measurement::held(held, case, quantity, error, allowed));
            };
            for (round_deg, allowed) in ROUND {
                let setting = setting(scheme, &format!("{round_deg} degrees"));
                let error = largest(&setting, scheme, model, round_deg)?;
                let what = if round_deg == 0.0 {
                    "echo of the cylinder".to_string()
                } else {
                    format!("{round_deg} degrees round the cylinder")
                };
                let (level, delay) = ("level, dB", "delay, us");
                push(what.clone(), &setting, level, error[0], allowed[0]);
                push(what, &setting, delay, 1e6 * error[1], 1e6 * allowed[1]);
            }
            for (m, which) in MODES {
                let what = format!("mode {m} {which}");
                let setting = setting(scheme, &what);
                let error = detuned(&setting, scheme, model, (m, which));
                let (what, quantity) = (format!("round room, {what}"), "frequency - 1");
                push(what, &setting, quantity, error, DETUNING);
            }
        }
    }
    Ok(found)
}
