//! Reflection of the absorbing layer.
//!
//! Layout: source and microphone 0.3 m in front of the layer of 20 cells and as far apart as the angle requires; a
//! broad burst (3 to 13 kHz at -20 dB). The same in a grid whose every border is 1 m further away is subtracted.
//! Formula: reflection = peak of the difference over peak of the echo that a rigid wall in the layer's place would send
//! (image source).
//! Bias: the difference holds the echoes of all four borders, so it is an upper bound.
//! Tolerance: -60 dB at 0, 30, 45 and 60 degrees, -40 dB at 80, all schemes.

use super::measurement::{Depth, Measurement, named, schemes};
use super::rig::{Rig, decibels, difference};
use super::setting::Setting;
use crate::exact::monopole::burst_on_path;
use fdtd::Error;
use fdtd::scheme::Scheme;

/// Distance from the layer on the papers' grid.
const AWAY_M: f64 = 0.3;
const MORE_CELLS: usize = 200;

/// Reflection in dB at an angle of incidence.
///
/// # Errors
/// When the field becomes non-finite.
pub fn reflection_db(setting: &Setting, scheme: Scheme, degrees: f64) -> Result<f64, Error> {
    let conditions = &setting.conditions;
    let dx_m = conditions.dx_m;
    let peak = |signal: &[f64]| signal.iter().fold(0.0_f64, |most, p| p.abs().max(most));
    let burst = conditions.burst(8e3, 2500.0);
    let strength = |t_s: f64| burst.value(t_s);
    let away_m = conditions.m(AWAY_M);
    let apart_m = 2.0 * away_m * degrees.to_radians().tan();
    let way_s = 2.0 * away_m / degrees.to_radians().cos() / conditions.medium.c_mps;
    let steps = ((way_s + burst.support_s()[1]) * 1.15 / conditions.dt_s) as usize;
    let (nx, ny) = (400.max((apart_m / dx_m) as usize + 200), 180);
    let left_m = 0.5 * (nx as f64 * dx_m - apart_m);
    let hear = |more: usize| {
        let shift_m = more as f64 * dx_m;
        let low_m = 20.0 * dx_m + away_m + shift_m;
        let rig = Rig::open(setting, scheme, nx + 2 * more, ny + 2 * more);
        rig.run(
            &|_| [left_m + shift_m, low_m],
            &|_| [left_m + apart_m + shift_m, low_m],
            &strength,
            steps,
        )
    };
    let sent_back = peak(&difference(&hear(0)?, &hear(MORE_CELLS)?));
    let image = |_: f64| [0.0, -away_m];
    let monopole = burst_on_path(conditions.medium, burst, &strength, &image);
    let rig = Rig::open(setting, scheme, nx, ny);
    let echo = peak(&rig.exact(&monopole, &|_| [apart_m, away_m], steps));
    Ok(decibels(sent_back / echo))
}

/// The law's measurements.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let angles: &[f64] = match depth {
        Depth::Quick => &[0.0, 60.0, 80.0],
        Depth::Full => &[0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 80.0],
    };
    let mut found = Vec::new();
    for scheme in schemes() {
        for &degrees in angles {
            let most_db = if degrees <= 60.0 { -60.0 } else { -40.0 };
            let case = format!("{scheme}, {degrees} degrees");
            let setting = Setting::drawn("absorbing layer", &case);
            let reflection_db = reflection_db(&setting, scheme, degrees)?;
            let (case, quantity) = (named(&case, &setting), "reflection, dB");
            found.push(Measurement::below(case, quantity, reflection_db, most_db));
        }
    }
    Ok(found)
}
