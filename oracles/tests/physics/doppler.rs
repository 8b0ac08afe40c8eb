//! Time scale of the echo of a rigid wall, for a source and a microphone that move as one.
//!
//! Layout: 1.6 m x 1.6 m, a wall over the whole height through the layers, 0.7 m ahead; a pair in one point anywhere
//! along it at 0.4 m/s towards the wall, at 60 degrees to it and away; a tone for 60 ms. A run without the wall is
//! subtracted, which leaves the echo.
//! Formula: `(e + M cos theta) / (e - M cos theta)`, [`oracles::exact::time_scale::plane_wall`].
//! Bias: the scheme's phase velocity stands for c: relative error of (scale - 1) 2.5e-3 (m13, 10 kHz), 6.4e-3 (slf, 5
//! kHz), 5e-4 (d25, 15 kHz), at this speed 6e-6, 1.5e-5 and 1e-6.
//! Tolerance: 2e-5 of the time scale; the scale differs from 1 by up to 2.4e-3.

use crate::rig::{Rig, Setting, difference};
use fdtd::scheme::Scheme;
use oracles::exact::time_scale::plane_wall;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

const SPEED_MPS: f64 = 0.4;
const STEPS: usize = 7200;

/// Rate of the phase of a narrow-band signal against `expected_hz`, as a fraction of it, by least squares over windows.
fn relative_shift(rig: &Rig, signal: &[f64], expected_hz: f64, from: usize) -> f64 {
    let window = (10.0 / (expected_hz * rig.conditions().dt_s)).round() as usize;
    let time_s = |n| rig.time_s(n);
    let mut turned = 0.0;
    let mut last: Option<Complex<f64>> = None;
    let points: Vec<[f64; 2]> = signal[from..]
        .chunks_exact(window)
        .enumerate()
        .map(|(k, chunk)| {
            let first = from + k * window;
            let phasor: Complex<f64> = chunk
                .iter()
                .enumerate()
                .map(|(n, &p)| Complex::from_polar(p, -TAU * expected_hz * time_s(first + n)))
                .sum();
            if let Some(last) = last {
                turned += (phasor * last.conj()).arg();
            }
            last = Some(phasor);
            [time_s(first), turned]
        })
        .collect();
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let (t, phase) = (mean(0), mean(1));
    let covariance: f64 = points
        .iter()
        .map(|point| (point[0] - t) * (point[1] - phase))
        .sum();
    let variance: f64 = points.iter().map(|point| (point[0] - t).powi(2)).sum();
    covariance / variance / (TAU * expected_hz)
}

fn check(scheme: Scheme, frequency_hz: f64, theta_rad: f64) {
    let case = format!("{scheme}, {:.0} degrees", theta_rad.to_degrees());
    let setting = Setting::drawn("Doppler", &case);
    let conditions = &setting.conditions;
    let open = Rig::open(&setting, scheme, 320, 320);
    let walled = open.clone().with_walls(|ix, _| (280..284).contains(&ix));
    let [_, along_m] = setting.between([[0.0, 0.0], [0.4, 1.2]]);
    let start_m = [280.0 * conditions.dx_m - conditions.m(0.7), along_m];
    let speed_mps = conditions.mps(SPEED_MPS);
    let v_mps = [speed_mps * theta_rad.cos(), speed_mps * theta_rad.sin()];
    let (frequency_hz, ramp_s) = (conditions.hz(frequency_hz), conditions.s(5e-3));
    let steps = conditions.steps(STEPS);
    let pair = |t_s: f64| [start_m[0] + v_mps[0] * t_s, start_m[1] + v_mps[1] * t_s];
    // Switched on over 5 ms: no onset transient in the measured part.
    let strength = |t_s: f64| {
        let ramp = 0.5 - 0.5 * (TAU * 0.5 * (t_s / ramp_s).clamp(0.0, 1.0)).cos();
        1e-2 * ramp * (TAU * frequency_hz * t_s).sin()
    };
    let hear = |rig: &Rig| {
        rig.run(&pair, &pair, &strength, steps)
            .expect("a finite field")
    };
    let echo = difference(&hear(&walled), &hear(&open));
    let scale = plane_wall(speed_mps / conditions.medium.c_mps, theta_rad);
    let error = relative_shift(&open, &echo, frequency_hz * scale, conditions.steps(1500)) * scale;
    println!("Doppler, {case}, {setting}: time scale {scale:.6}, error {error:+.1e}");
    assert!(
        error.abs() < 2e-5,
        "{case}, {setting}: error of the time scale {error}"
    );
}

#[test]
fn towards_a_wall() {
    check(Scheme::M13, 10e3, 0.0);
    check(Scheme::Slf, 5e3, 0.0);
    check(Scheme::D25, 15e3, 0.0);
}

#[test]
fn obliquely_and_away_from_a_wall() {
    check(Scheme::M13, 10e3, TAU / 6.0);
    check(Scheme::M13, 10e3, TAU / 2.0);
    check(Scheme::D25, 15e3, TAU / 6.0);
}
