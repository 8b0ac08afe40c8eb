//! Level of a moving source's tone, and the false sidebands that spreading onto the grid puts beside it.
//!
//! Layout: 1.3 m x 1.1 m; a source at 4 m/s along one axis and 0.3 of a cell off the cells' centres along the other; a
//! microphone at rest 0.5 m away. The tone is switched on over 3 ms and recorded for 10 ms, eight cells of the source's
//! way.
//! Formula: the closed form of the tone in uniform motion ([`crate::exact::tone`]). Received over exact, as complex
//! numbers over time, would be 1; its mean is the error of the level, its lines at the rate at which the source passes
//! cells (800 Hz) and at twice that are the spreading's false sidebands. At a robot's 0.3 m/s they lie at 60 Hz, within
//! the echoes' Doppler band.
//! Bias: dispersion in level (c over the group velocity).
//! Tolerance: 0.1 dB and -60 dB at 2 to 15 kHz with kaiser8 and d25. The other combinations are shown beside it. A
//! Gaussian is a low-pass at the source and at the microphone: its level is low by `sigma^2 k^2` nepers (0.64 of
//! `(k dx)^2`: 4.7 dB at 10 kHz), its sidebands are weak.

use super::conditions::Conditions;
use super::measurement::{Depth, Measurement, named};
use super::rig::{Rig, decibels};
use super::setting::Setting;
use crate::exact::tone::in_uniform_motion;
use fdtd::Error;
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

const SPEED_MPS: f64 = 4.0;
const RAMP_S: f64 = 3e-3;
/// Start and end of the measured part.
const WINDOW_S: [f64; 2] = [6e-3, 16e-3];
const SOURCE_M: [f64; 2] = [0.4012, 0.4 + 0.3 * Conditions::PAPERS.dx_m];
const RECEIVER_M: [f64; 2] = [0.762, 0.783];

/// Level error in dB and strongest sideband in dB below the tone of a frequency on the papers' grid.
///
/// # Errors
/// When the field becomes non-finite.
pub fn level_and_sidebands(
    setting: &Setting,
    scheme: Scheme,
    spread: Spread,
    frequency_hz: f64,
) -> Result<[f64; 2], Error> {
    let conditions = &setting.conditions;
    let mut rig = Rig::open(setting, scheme, 260, 220);
    rig.spread = spread;
    let frequency_hz = conditions.hz(frequency_hz);
    let (speed_mps, ramp_s) = (conditions.mps(SPEED_MPS), conditions.s(RAMP_S));
    let [source_m, receiver_m] = [SOURCE_M, RECEIVER_M].map(|point| conditions.point(point));
    let source = |t_s: f64| [source_m[0] + speed_mps * t_s, source_m[1]];
    let strength = |t_s: f64| {
        let ramp = 0.5 - 0.5 * (TAU * 0.5 * (t_s / ramp_s).clamp(0.0, 1.0)).cos();
        ramp * (TAU * frequency_hz * t_s).cos()
    };
    let [from, end] = WINDOW_S.map(|t_s| (conditions.s(t_s) / conditions.dt_s).round() as usize);
    let recorded = rig.run(&source, &|_| receiver_m, &strength, end)?;
    // The tone's quadrature is the tone a quarter period earlier, from the source's place at that time.
    let exact = |t_s: f64, earlier_s: f64| {
        let x_m = [
            receiver_m[0] - source_m[0] - speed_mps * earlier_s,
            receiver_m[1] - source_m[1],
        ];
        let medium = &conditions.medium;
        in_uniform_motion(medium, frequency_hz, 1.0, speed_mps, x_m, t_s - earlier_s)
    };
    let ratio: Vec<Complex<f64>> = (from..end)
        .map(|n| {
            let t_s = rig.time_s(n);
            let tone = Complex::new(exact(t_s, 0.0), exact(t_s, 0.25 / frequency_hz));
            tone.conj() * (2.0 * recorded[n] / tone.norm_sqr())
        })
        .collect();
    let part = |offset_hz: f64| -> f64 {
        let count = ratio.len() as f64;
        let windowed = ratio.iter().enumerate().map(|(n, value)| {
            let hann = 1.0 - (TAU * (n as f64 + 0.5) / count).cos();
            value * Complex::from_polar(hann / count, -TAU * offset_hz * rig.time_s(n))
        });
        windowed.sum::<Complex<f64>>().norm()
    };
    let passing_hz = speed_mps / conditions.dx_m;
    let sideband = [-2.0, -1.0, 1.0, 2.0]
        .map(|order| part(order * passing_hz))
        .into_iter()
        .fold(0.0, f64::max);
    Ok([decibels(part(0.0)), decibels(sideband / part(0.0))])
}

/// The law's measurements.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let frequencies_hz: &[f64] = match depth {
        Depth::Quick => &[2e3, 10e3, 15e3],
        Depth::Full => &[2e3, 4e3, 6e3, 8e3, 10e3, 12e3, 14e3, 15e3],
    };
    let mut found = Vec::new();
    for (scheme, spread) in [
        (Scheme::D25, Spread::Kaiser8),
        (Scheme::D25, Spread::Bilinear),
        (Scheme::D25, Spread::Gaussian),
        (Scheme::M13, Spread::Kaiser8),
        (Scheme::Slf, Spread::Bilinear),
    ] {
        for &frequency_hz in frequencies_hz {
            let case = format!("{scheme}, {spread}, {} kHz", frequency_hz / 1e3);
            let setting = Setting::drawn("direct method", &case);
            let [level_db, sideband_db] =
                level_and_sidebands(&setting, scheme, spread, frequency_hz)?;
            let case = named(&case, &setting);
            let (level, sideband) = ("level, dB", "sidebands, dB");
            if (scheme, spread) == (Scheme::D25, Spread::Kaiser8) {
                found.push(Measurement::within(case.clone(), level, level_db, 0.1));
                found.push(Measurement::below(case, sideband, sideband_db, -60.0));
            } else {
                found.push(Measurement::shown(case.clone(), level, level_db));
                found.push(Measurement::shown(case, sideband, sideband_db));
            }
        }
    }
    Ok(found)
}
