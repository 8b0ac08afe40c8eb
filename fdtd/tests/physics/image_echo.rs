//! Arrival and level of the echo of a rigid wall.
//!
//! Layout: 2 m x 2 m, a wall over the whole height through the layers; source and microphone 0.6 m and 0.45 m in front of it, side by side or 0.7 m apart along
//! it. A run without the wall is subtracted.
//! Formula: the image source of equal sign behind the wall's face, which lies on the cells' border; [`fdtd::exact::monopole`].
//! Bias: as in free field over the echo's way.
//! Tolerance: 1.2 % of the waveform, 0.02 dB, 0.3 us at 4 kHz (m13); 6 %, 0.06 dB, 4 us at 2 kHz (slf). Half a cell of error in the wall's place would be 15 us, a
//! wall that takes the pressure instead of the flow would turn the sign.

use crate::rig::{AIR, DX_M, Rig, decibels, difference, exact, line, norm};
use fdtd::exact::burst::Burst;
use fdtd::exact::monopole::burst_on_path;
use fdtd::scheme::Scheme;
use std::f64::consts::TAU;

fn check(scheme: Scheme, frequency_hz: f64, apart_m: f64, vertical: bool, tolerance: [f64; 3]) {
    let wall_m = 300.0 * DX_M;
    let turn = move |p: [f64; 2]| if vertical { p } else { [p[1], p[0]] };
    let open = Rig::open(scheme, 400, 400);
    let walled = open
        .clone()
        .with_walls(|ix, iy| (300..304).contains(&if vertical { ix } else { iy }));
    let burst = Burst::from_zero(frequency_hz, 500.0);
    let strength = |t_s: f64| burst.value(t_s);
    let source = |_: f64| turn([wall_m - 0.6, 0.65]);
    let image = |_: f64| turn([wall_m + 0.6, 0.65]);
    let receiver = |_: f64| turn([wall_m - 0.45, 0.65 + apart_m]);
    let steps = 1100;
    let hear = |rig: &Rig| rig.run(&source, &receiver, &strength, steps);
    let echo = difference(&hear(&walled), &hear(&open));
    let expected = exact(
        &burst_on_path(AIR, burst, &strength, &image),
        &receiver,
        steps,
    );
    let waveform = norm(&difference(&echo, &expected)) / norm(&expected);
    let ratio = line(&echo, frequency_hz) / line(&expected, frequency_hz);
    let (level_db, late_s) = (
        decibels(norm(&echo) / norm(&expected)),
        -ratio.arg() / (TAU * frequency_hz),
    );
    println!(
        "echo, {scheme}, {apart_m} m apart: waveform {waveform:.4}, level {level_db:+.3} dB, late {:+.2} us",
        late_s * 1e6
    );
    assert!(
        waveform < tolerance[0],
        "{scheme}: waveform off by {waveform}"
    );
    assert!(
        level_db.abs() < tolerance[1],
        "{scheme}: level off by {level_db} dB"
    );
    assert!(late_s.abs() < tolerance[2], "{scheme}: late by {late_s} s");
}

#[test]
fn a_wall_straight_ahead() {
    check(Scheme::M13, 4e3, 0.0, true, [0.012, 0.02, 0.3e-6]);
    check(Scheme::Slf, 2e3, 0.0, true, [0.06, 0.06, 4e-6]);
}

#[test]
fn a_wall_met_at_an_angle() {
    check(Scheme::M13, 4e3, 0.7, false, [0.012, 0.02, 0.3e-6]);
    check(Scheme::Slf, 2e3, 0.7, false, [0.06, 0.06, 4e-6]);
}
