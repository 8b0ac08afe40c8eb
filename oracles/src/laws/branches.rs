//! Reflection over frequency and angle of walls whose impedance is made of branches of resistance, inertance and
//! compliance.
//!
//! Layout: the duct of [`super::impedance`], its end of several branches ([`walls`]), met at 0 to 73 degrees between 2
//! and 10 kHz.
//! Formula: `(Z cos - rho c)/(Z cos + rho c)` with the complex Z of branches `R + i omega L + 1/(i omega C)` in
//! parallel.
//! Bias: as there: the surface's error at a real impedance, and the scheme's own error of the group velocity. The
//! step has tangents in place of frequencies (2.3 % at 10 kHz), which detunes resonances.
//! Tolerance: 0.02 at 2 kHz and for a resistance, otherwise [`TOLERANCES`], wherever the wall lies in the cells, up to
//! a Courant number of 0.58; slf up to 4 kHz only. It was 0.02 for all while a fit to each surface changed inertances
//! and stiffnesses.

use super::conditions::Conditions;
use super::impedance::{is_held, recorded, sine};
use super::measurement::{Depth, Measurement, named};
use super::setting::Setting;
use fdtd::Error;
use fdtd::scheme::Scheme;
use fdtd::walls::{Branch, Impedance};
use rayon::prelude::*;

/// Frequency in hertz on the papers' grid, and modes: 0, about 28 to 32 and 45 to 73 degrees.
pub const CASES: [(f64, [usize; 3]); 4] = [
    (2e3, [0, 3, 4]),
    (4e3, [0, 6, 10]),
    (8e3, [0, 11, 21]),
    (10e3, [0, 14, 27]),
];

/// Open parts of the cell before the wall.
pub const PLACES: [f64; 2] = [1.0, 0.6];

/// Names and branches of the walls that are measured; numbers over those of air.
pub fn walls() -> [(&'static str, Impedance); 6] {
    walls_in(&Conditions::PAPERS)
}

/// [`walls`] in other conditions.
pub fn walls_in(conditions: &Conditions) -> [(&'static str, Impedance); 6] {
    let air = conditions.air_pasm();
    let resistance = |ratio: f64| Branch::resistance(ratio * air);
    let resonance = |frequency_hz: f64, ratio: f64, reactance: f64| {
        Branch::resonance(conditions.hz(frequency_hz), ratio * air, reactance * air)
    };
    let five = resonance(5e3, 0.3, 1.0);
    let inertance = Branch {
        stiffness_papm: 0.0,
        ..five
    };
    let compliance = Branch {
        inertance_kgpm2: 0.0,
        ..five
    };
    [
        ("resistance", vec![resistance(0.3)]),
        ("resonance at 4 kHz", vec![resonance(4e3, 0.2, 1.0)]),
        ("sharp one", vec![resonance(4e3, 0.05, 3.0)]),
        (
            "4 and 9 kHz",
            vec![resonance(4e3, 0.2, 1.0), resonance(9e3, 0.3, 1.5)],
        ),
        ("inertance", vec![inertance]),
        (
            "compliance beside resistance",
            vec![compliance, resistance(2.0)],
        ),
    ]
    .map(|(name, branches)| (name, Impedance::Branches(branches)))
}

/// Tolerance of the reflection factor above 3 kHz, by the places of [`walls`].
pub const TOLERANCES: [f64; 6] = [0.02, 0.055, 0.07, 0.09, 0.045, 0.025];

/// Tolerance of the reflection factor of a wall, by its place in [`walls`], at a frequency.
pub fn tolerance(wall: usize, frequency_hz: f64) -> f64 {
    if frequency_hz < 3e3 {
        0.02
    } else {
        TOLERANCES[wall]
    }
}

/// Setting of a case.
pub fn setting(scheme: Scheme, frequency_hz: f64, place: f64) -> Setting {
    let case = format!("{scheme}, {} kHz, {place} of a cell", frequency_hz / 1e3);
    Setting::before_accurate_surfaces("branches", &case)
}

/// Errors of the reflection factor of [`walls`], the largest over angle; `place` is the open part of the cell before
/// the wall.
pub fn largest(
    setting: &Setting,
    scheme: Scheme,
    frequency_hz: f64,
    modes: &[usize],
    place: f64,
) -> [f64; 6] {
    let conditions = &setting.conditions;
    let mut most = [0.0_f64; 6];
    for &mode in modes {
        let rigid = recorded(setting, scheme, frequency_hz, mode, place, None);
        let cos = (1.0 - sine(frequency_hz, mode).powi(2)).sqrt();
        for (most, (_, impedance)) in most.iter_mut().zip(walls_in(conditions)) {
            let end = Some(&impedance);
            let found = recorded(setting, scheme, frequency_hz, mode, place, end) / rigid;
            let ratio = impedance.at(conditions.hz(frequency_hz)) / conditions.air_pasm();
            *most = most.max((found - (ratio * cos - 1.0) / (ratio * cos + 1.0)).norm());
        }
    }
    most
}

/// Measurements of the reflection factor.
///
/// # Errors
/// None.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let (schemes, cases, places) = match depth {
        Depth::Quick => (&[Scheme::O13][..], &CASES[1..2], &PLACES[1..]),
        Depth::Full => (&Scheme::ALL[..], &CASES[..], &PLACES[..]),
    };
    let mut parts = Vec::new();
    for &scheme in schemes {
        for (frequency_hz, modes) in cases {
            let places = places.iter().filter(|_| is_held(scheme, *frequency_hz));
            parts.extend(places.map(|&place| (scheme, *frequency_hz, modes, place)));
        }
    }
    let found = parts
        .into_par_iter()
        .flat_map_iter(|(scheme, frequency_hz, modes, place)| {
            let setting = setting(scheme, frequency_hz, place);
            let errors = largest(&setting, scheme, frequency_hz, modes, place);
            let khz = frequency_hz / 1e3;
            let walls = walls().into_iter().zip(errors).enumerate();
            walls.map(move |(wall, ((name, _), error))| {
                let case =
                    format!("{scheme}, {name}, {khz} kHz, {place} of a cell, worst over angle");
                let case = named(&case, &setting);
                let allowed = tolerance(wall, frequency_hz);
                Measurement::below(case, "reflection factor, error", error, allowed)
            })
        })
        .collect();
    Ok(found)
}
