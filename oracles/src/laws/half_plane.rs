//! Diffraction at the edge of a rigid half plane.
//!
//! Layout: 1.6 m x 1.5 m; a wall one cell thick ends in the middle and runs through the layer; a burst of 2 kHz from
//! 0.4 m at 60 degrees to the wall, received at 0.32 m from the edge at several angles: where the face reflects, in the
//! light, at the shadow's border (240 degrees) and down to 20 degrees behind the wall.
//! Formula: Sommerfeld's half plane in time, [`crate::exact::half_plane`], which coincides with the wall's face on the
//! source's side and with its middle behind it. Its edge lies beyond the wall's end: the potential flow round the
//! square end of a plate of thickness d is, at a distance r, that round an edge further out by
//! ```text
//! e = d / (2 pi) (1 + ln(4 pi r / d)),    z = (d / pi) (w sqrt(w^2 - 1) - arcosh w)  (Schwarz and Christoffel)
//! ```
//! and the flow turns into waves at `r = 1/k`: 4.1 mm here. With the edge at the wall's end the deep shadow would be
//! 0.18 rad early, because the path round the edge is shorter by `e` times the sum of both cosines.
//! Bias: other terms of the order of `k d` = 0.18 behind the wall. They halve with the thickness in wavelengths: one
//! row has twice the wavelength, and all lengths but the thickness doubled.
//! Tolerance: 2.5 % and 0.15 dB on the source's side (iwb, whose waves along the diagonals are later by a third than
//! those of slf along the axes, 5.5 %), 6.5 % and 0.55 dB behind the wall, half of that at twice the
//! wavelength. Without diffraction the shadow would be silent.

use super::measurement::{Depth, Measurement, named};
use super::rig::{Rig, decibels, difference, norm};
use super::setting::Setting;
use crate::exact::half_plane::HalfPlane;
use fdtd::Error;
use fdtd::scheme::Scheme;
use std::f64::consts::{PI, TAU};

/// Source from the edge in metres on the papers' grid, as all that follows.
const SOURCE_M: [f64; 2] = [0.2, 0.346_410_161_513_775_5];
/// Microphone from the edge in metres.
const DISTANCE_M: f64 = 0.32;
const FREQUENCY_HZ: f64 = 2e3;

/// Errors at one angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diffraction {
    /// Of the waveform, relative.
    pub waveform: f64,
    /// Of the level, dB.
    pub level_db: f64,
    /// Of the waveform with the edge at the wall's end, relative.
    pub naive: f64,
}

/// How far beyond the square end of a plate its edge lies for waves of this wave number, in metres.
pub fn edge_beyond_m(thickness_m: f64, wave_number: f64) -> f64 {
    thickness_m / TAU * (1.0 + (4.0 * PI / (wave_number * thickness_m)).ln())
}

/// Compares the field at an angle from the wall, counter-clockwise over the source's side; `times` 2 doubles wavelength
/// and distances.
///
/// # Errors
/// When the field becomes non-finite.
pub fn half_plane(
    setting: &Setting,
    scheme: Scheme,
    degrees: f64,
    times: usize,
) -> Result<Diffraction, Error> {
    let conditions = &setting.conditions;
    let dx_m = conditions.dx_m;
    let longer = times as f64;
    let burst = conditions.burst(FREQUENCY_HZ / longer, 500.0 / longer);
    let strength = |t_s: f64| burst.value(t_s);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let source_m = conditions.point(SOURCE_M.map(|x| longer * x));
    let place_m = conditions.point([cos, sin].map(|x| longer * DISTANCE_M * x));
    let edge = [150 * times, 150 * times];
    let edge_m = [edge[0] as f64 * dx_m, (edge[1] as f64 + 0.5) * dx_m];
    let from_edge = |[x, y]: [f64; 2]| [edge_m[0] + x, edge_m[1] + y];
    let rig = Rig::open(setting, scheme, 320 * times, 300 * times)
        .with_walls(|ix, iy| iy == edge[1] && ix >= edge[0]);
    let steps = conditions.steps(920 * times);
    let recorded = rig.run(
        &|_| from_edge(source_m),
        &|_| from_edge(place_m),
        &strength,
        steps,
    )?;
    let exact = |beyond_m: f64| -> Vec<f64> {
        let face_m = if place_m[1] > 0.0 { 0.5 * dx_m } else { 0.0 };
        let shifted = |[x, y]: [f64; 2]| [x + beyond_m, y - face_m];
        let exact = HalfPlane {
            medium: conditions.medium,
            burst,
            source_m: shifted(source_m),
        };
        (0..steps)
            .step_by(2)
            .map(|n| exact.pressure(shifted(place_m), rig.time_s(n)))
            .collect()
    };
    let recorded: Vec<f64> = recorded.into_iter().step_by(2).collect();
    let off = |expected: &[f64]| norm(&difference(&recorded, expected)) / norm(expected);
    let wave_number = TAU * burst.frequency_hz / conditions.medium.c_mps;
    let expected = exact(edge_beyond_m(dx_m, wave_number));
    Ok(Diffraction {
        waveform: off(&expected),
        level_db: decibels(norm(&recorded) / norm(&expected)),
        naive: off(&exact(0.0)),
    })
}

/// Allowed errors of waveform and level in dB at an angle; `times` as in [`half_plane`].
pub fn tolerance(scheme: Scheme, degrees: f64, times: usize) -> [f64; 2] {
    let longer = times as f64;
    if degrees < 225.0 {
        [if scheme == Scheme::Iwb { 0.055 } else { 0.025 }, 0.15]
    } else {
        [0.065 / longer, 0.55 / longer]
    }
}

/// Scheme, angle in degrees and times of each case.
pub fn cases(depth: Depth) -> Vec<(Scheme, f64, usize)> {
    let (schemes, angles): (&[Scheme], &[f64]) = match depth {
        Depth::Quick => (&[Scheme::O13], &[60.0, 150.0, 240.0, 340.0]),
        Depth::Full => (
            &Scheme::ALL,
            &[60.0, 120.0, 150.0, 210.0, 240.0, 270.0, 300.0, 340.0],
        ),
    };
    let mut cases: Vec<_> = schemes
        .iter()
        .flat_map(|&scheme| angles.iter().map(move |&degrees| (scheme, degrees, 1)))
        .collect();
    if depth == Depth::Full {
        cases.extend([150.0, 240.0, 340.0].map(|degrees| (Scheme::M13, degrees, 2)));
    }
    cases
}

/// The law's measurements.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let mut found = Vec::new();
    for (scheme, degrees, times) in cases(depth) {
        let khz = 1e-3 * FREQUENCY_HZ / times as f64;
        let case = format!("{scheme}, {degrees} degrees, {khz} kHz");
        let setting = Setting::drawn("half plane", &case);
        let error = half_plane(&setting, scheme, degrees, times)?;
        let case = named(&case, &setting);
        let allowed = tolerance(scheme, degrees, times);
        let measured = [error.waveform, error.level_db];
        found.extend(Measurement::waveform_and_level(&case, measured, allowed));
        if degrees > 330.0 {
            let quantity = "waveform, edge at the wall's end";
            found.push(Measurement::shown(case, quantity, error.naive));
        }
    }
    Ok(found)
}
