//! Round walls: the field before, beside and behind a rigid cylinder, and standing waves in a round room.
//!
//! Layout, cylinder: a closed wall of 180 chords (10 mm, two cells) whose surface has a radius of 0.3 m, with its axis in three places of a cell; a burst of
//! 10 kHz from 0.42 m before the surface in the direction of 0, 10, 30 and 45 degrees. Heard 0.38 m before it on the same line, less a run without the
//! cylinder: the echo. Heard 0.1 m from the surface 120 degrees round the axis: in the shadow, 8.7 dB weaker, where the sound has crept along the wall.
//! Formula: the series of a rigid cylinder, [`crate::exact::cylinder`].
//! Bias: dispersion on the way, which is not the wall's; the reference is the field itself in an open grid, for the echo 0.8 m from the source towards
//! the axis, for the shadow where the microphone is, times what the series says of the ratio.
//! Tolerance: 0.3 dB and 2 us for the echo, 0.6 dB and 2 us in the shadow (m13, o13, d25). Stairs are shown beside it.
//!
//! Layout, room: the same wall seen from within, radius 0.3 m; the field starts as one standing wave and is left alone for 1200 steps (10 ms).
//! Formula: `J_m(kappa r) cos(m phi)`, `J_m'(kappa a) = 0`, at the frequency that the scheme's waves of the wave number `kappa` have in the mean over
//! directions.
//! Bias: the restoring quantum's share is taken off.
//! Tolerance: 2e-4 of the frequency, a radius right within 0.06 mm. Stairs are shown beside it.

use super::rig::{AIR, DT_S, DX_M, Rig, centre_m, decibels, difference, line, wrapped};
use super::{Depth, Measurement, larger};
use crate::Error;
use crate::exact::burst::Burst;
use crate::exact::cylinder::{mode, scattered, standing};
use crate::exact::hankel::hankel;
use crate::scheme::{RESTORING_QUANTUM, Scheme};
use crate::walls::{Wall, WallModel};
use std::f64::consts::{PI, TAU};

/// Frequency of the bursts in hertz.
const FREQUENCY_HZ: f64 = 10e3;
/// Radius of the surface in metres.
const RADIUS_M: f64 = 0.3;
/// Thickness of the wall in metres.
const THICKNESS_M: f64 = 4.0 * DX_M;
const CHORDS: usize = 180;

/// Directions of the source from the axis in degrees.
pub const BEARINGS_DEG: [f64; 4] = [0.0, 10.0, 30.0, 45.0];

/// Angles round the axis from the source to the microphone in degrees, and the largest errors of cut cells: level in dB, delay in s.
pub const ROUND: [(f64, [f64; 2]); 2] = [(0.0, [0.3, 2e-6]), (120.0, [0.6, 2e-6])];

/// Numbers of the standing waves: of periods round the axis, and of the zero.
pub const MODES: [(i32, usize); 6] = [(0, 1), (1, 1), (3, 2), (0, 6), (5, 4), (16, 2)];

/// Largest relative error of a standing wave's frequency.
pub const DETUNING: f64 = 2e-4;

/// Schemes that are held to it; slf is shown.
pub const SCHEMES: [Scheme; 3] = [Scheme::M13, Scheme::O13, Scheme::D25];

/// Places of the axis in a cell.
const PLACES: [[f64; 2]; 3] = [[0.0, 0.0], [0.31, 0.17], [0.62, 0.87]];

/// A closed wall whose outer (`side` 1) or inner (-1) surface has a mean distance of [`RADIUS_M`] from the axis.
fn ring(axis_m: [f64; 2], side: f64) -> Wall {
    // A chord lies up to `1 - cos` inside the circle through its ends, two thirds of it in the mean.
    let sagging = 2.0 / 3.0 * (1.0 - (PI / CHORDS as f64).cos());
    let middle_m = RADIUS_M / (1.0 - sagging) - side * 0.5 * THICKNESS_M;
    let mut points_m: Vec<[f64; 2]> = (0..CHORDS)
        .map(|chord| at(axis_m, middle_m, TAU * chord as f64 / CHORDS as f64))
        .collect();
    points_m.push(points_m[0]);
    Wall {
        points_m,
        thickness_m: THICKNESS_M,
        impedance: None,
    }
}

/// The point at a distance in metres from the axis, in a direction.
fn at(axis_m: [f64; 2], distance_m: f64, angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    [axis_m[0] + distance_m * cos, axis_m[1] + distance_m * sin]
}

/// Error of what is heard of a cylinder, `round_deg` round the axis from the source (0 for the echo): level in dB and delay in s.
///
/// # Errors
/// When the field becomes non-finite.
pub fn cylinder(
    scheme: Scheme,
    model: WallModel,
    bearing_deg: f64,
    round_deg: f64,
    place: [f64; 2],
) -> Result<[f64; 2], Error> {
    let open = Rig::open(scheme, 300, 300);
    let axis_m = place.map(|place| 0.58 + place * DX_M);
    let mut walled = open.clone();
    walled.walls = model.cells(&open.grid(), &[ring(axis_m, 1.0)]);
    let echo = round_deg == 0.0;
    let (bearing, round) = (bearing_deg.to_radians(), round_deg.to_radians());
    let source = RADIUS_M + 0.42;
    let heard = RADIUS_M + if echo { 0.38 } else { 0.1 };
    let source_m = at(axis_m, source, bearing);
    let burst = Burst::from_zero(FREQUENCY_HZ, 1000.0);
    let longest_s = if echo { 0.8 } else { 1.8 } / AIR.c_mps;
    let steps = ((longest_s + 2.0 * burst.centre_s) / DT_S) as usize;
    let hear = |rig: &Rig, microphone_m: [f64; 2]| -> Result<Vec<f64>, Error> {
        rig.run(
            &|_| source_m,
            &|_| microphone_m,
            &|t_s| burst.value(t_s),
            steps,
        )
    };
    let microphone_m = at(axis_m, heard, bearing + round);
    let measured = hear(&walled, microphone_m)?;
    let alone = hear(&open, microphone_m)?;
    let k = TAU * FREQUENCY_HZ / AIR.c_mps;
    let series = scattered(k * RADIUS_M, [k * source, k * heard], round);
    // What is measured, its reference, and their ratio by the series.
    let (measured, reference, exact) = if echo {
        let behind = hear(&open, at(axis_m, source - 0.8, bearing))?;
        (
            difference(&measured, &alone),
            behind,
            series / hankel(0, k * 0.8),
        )
    } else {
        let [dx, dy] = [0, 1].map(|axis| microphone_m[axis] - source_m[axis]);
        let incident = hankel(0, k * dx.hypot(dy));
        (measured, alone, (series + incident) / incident)
    };
    let expected = exact * line(&reference, FREQUENCY_HZ);
    let ratio = line(&measured, FREQUENCY_HZ) / expected;
    Ok([decibels(ratio.norm()), -ratio.arg() / (TAU * FREQUENCY_HZ)])
}

/// The largest errors of level in dB and delay in s over directions of the source and places of the axis (one in the shadow), with their signs.
///
/// # Errors
/// When the field becomes non-finite.
pub fn largest(scheme: Scheme, model: WallModel, round_deg: f64) -> Result<[f64; 2], Error> {
    let places = if round_deg == 0.0 {
        &PLACES[..]
    } else {
        &PLACES[1..2]
    };
    let mut most = [0.0_f64; 2];
    for bearing_deg in BEARINGS_DEG {
        for &place in places {
            let error = cylinder(scheme, model, bearing_deg, round_deg, place)?;
            most = [0, 1].map(|i| larger(most[i], error[i]));
        }
    }
    Ok(most)
}

/// Relative error of the frequency of a standing wave in a round room, the largest over places of the axis.
pub fn detuned(scheme: Scheme, model: WallModel, (m, which): (i32, usize)) -> f64 {
    PLACES
        .map(|place| detuned_at(scheme, model, (m, which), place))
        .into_iter()
        .fold(0.0, larger)
}

fn detuned_at(scheme: Scheme, model: WallModel, (m, which): (i32, usize), place: [f64; 2]) -> f64 {
    const STEPS: usize = 1200;
    let mut rig = Rig::open(scheme, 140, 140);
    rig.layer_cells = 0;
    let axis_m = place.map(|place| 0.35 + place * DX_M);
    rig.walls = model.cells(&rig.grid(), &[ring(axis_m, -1.0)]);
    let kappa = mode(m, which) / RADIUS_M;
    let omega_dt = wave(&rig, kappa);
    let [nx, ny] = rig.walls.size();
    let areas = rig.walls.areas();
    let shape: Vec<f64> = (0..nx * ny)
        .map(|cell| {
            let x_m = centre_m(cell % nx, cell / nx);
            let [x, y] = [x_m[0] - axis_m[0], x_m[1] - axis_m[1]];
            // Cells that the wall cuts have their middle up to a cell beyond it; what lies behind the wall is another room.
            if areas[cell] == 0.0 || x.hypot(y) > RADIUS_M + DX_M {
                return 0.0;
            }
            standing(m, kappa * x.hypot(y), y.atan2(x))
        })
        .collect();
    let phase = omega_dt * STEPS as f64;
    wrapped(rig.swing(&shape, omega_dt, STEPS).turned_rad - phase) / phase
}

/// Radians per step of a wave of `kappa` radians per metre, in the mean over directions, with the restoring quantum.
fn wave(rig: &Rig, kappa: f64) -> f64 {
    const DIRECTIONS: usize = 32;
    let polynomial = rig.scheme.polynomial(rig.courant());
    let mean = (0..DIRECTIONS)
        .map(|direction| {
            let angle = 0.25 * PI * (direction as f64 + 0.5) / DIRECTIONS as f64;
            let stiffness = |part: f64| 4.0 * (0.5 * kappa * DX_M * part).sin().powi(2);
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
            let mut push = |what: String, quantity, error, allowed| {
                let case = format!("{scheme}, {model}, {what}");
                found.push(Measurement::held(held, case, quantity, error, allowed));
            };
            for (round_deg, allowed) in ROUND {
                let error = largest(scheme, model, round_deg)?;
                let what = if round_deg == 0.0 {
                    "echo of the cylinder".to_string()
                } else {
                    format!("{round_deg} degrees round the cylinder")
                };
                push(what.clone(), "level, dB", error[0], allowed[0]);
                push(what, "delay, us", 1e6 * error[1], 1e6 * allowed[1]);
            }
            for (m, which) in MODES {
                let error = detuned(scheme, model, (m, which));
                push(
                    format!("round room, mode {m} {which}"),
                    "frequency - 1",
                    error,
                    DETUNING,
                );
            }
        }
    }
    Ok(found)
}
