//! Echoes of walls of an impedance that lie across the grid.
//!
//! Layout: as the echo of [`super::tilted`]: a wall of 1.6 m, tilted by 3 to 45 degrees and moved through the cells in
//! six steps of a sixth of a cell along the grid's axis; source and microphone 0.4 m in front of it, on one line across
//! it or 0.8 m apart along it, so that the wave comes in at 45 degrees. A run without the wall is subtracted, and the
//! spectral line at 10 kHz divided by that of the same wall when it is rigid.
//! Formula: `R = (Z cos - rho c)/(Z cos + rho c)` and, for a line source at a distance r behind the image,
//! `R + i R''/(2 k r)` (the next term of the stationary phase; the second derivative is that by the angle).
//!
//! The place of the wall in the cells changes along a slanted wall, which acts as a grating: it sends a part of the
//! wave into diffraction orders, of which some return to the microphone from another part of the wall (at 10 degrees
//! from where it is met at 36). That is not the reflection factor, which is the order zero. Only this order
//! keeps its phase when the wall moves: by a part of a cell, the order n turns by n times that part of a circle, and
//! the mean over six places cancels the orders up to the fifth. The tolerance of walls whose cells repeat after many
//! cells only ([`SLANTS`]) is therefore one of the mean, with wider limits in each single place, which contains the
//! orders. Along walls of a simple slope ([`SLOPES`]) all surface elements lie in one of few places, and the tolerance
//! is that of the largest error of all places.
//! Bias: the diffraction at the ends comes 2 ms later, when the burst is over. The rigid wall's own error is in both
//! and not counted. Its echo should be the same in all places, which is tested along walls of a simple slope (see
//! `walls/slant.rs`).
//! Tolerance: 0.02 for the mean (m13, o13, d25), 0.03 at tilts of 18.1 to 20 degrees, for single places up to a third
//! above the measured error; Z/(rho c) from 0.05 to 20. It was 0.02 at all tilts while all were measured at 340 m/s and
//! lay one way, and for single places of [`SLOPES`] while each of these slopes had weights of its own.

use super::conditions::Conditions;
use super::measurement::{Depth, Measurement, named};
use super::rig::{Rig, difference};
use super::setting::Setting;
use super::tilted::Tilted;
use fdtd::Error;
use fdtd::scheme::Scheme;
use fdtd::walls::{Impedance, WallModel};
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Frequency of the burst in hertz, on the papers' grid.
const FREQUENCY_HZ: f64 = 10e3;

/// Distance in metres of source and microphone from the wall, on the papers' grid.
const DISTANCE_M: f64 = 0.4;

/// Impedances over that of the air.
pub const RATIOS: [f64; 5] = [0.05, 0.2, 1.0, 5.0, 20.0];

/// Tilts in degrees of walls whose echo has a tolerance in the mean over places ([`mean_tolerance`]), and the tolerance
/// in a single place at normal incidence and at 45 degrees.
pub const SLANTS: [(f64, [f64; 2]); 8] = [
    (3.0, [0.02, 0.02]),
    (10.0, [0.05, 0.05]),
    (15.0, [0.03, 0.03]),
    (18.1, [0.03, 0.03]),
    (19.0, [0.03, 0.04]),
    (20.0, [0.03, 0.03]),
    (30.0, [0.05, 0.03]),
    (40.0, [0.065, 0.045]),
];

/// Tolerance of the reflection factor in the mean over places, by the tilt in degrees.
pub fn mean_tolerance(tilt_deg: f64) -> f64 {
    match (18.0..=20.0).contains(&tilt_deg) {
        true => 0.03,
        false => 0.02,
    }
}

/// Tilts in degrees of slopes of 1 to 3, 1 to 2 and 1 to 1, and the tolerance in any place at normal incidence and at
/// 45 degrees.
pub const SLOPES: [(f64, [f64; 2]); 3] = [
    (18.434_948_822_922, [0.04, 0.04]),
    (26.565_051_177_078, [0.06, 0.06]),
    (45.0, [0.055, 0.095]),
];

/// Largest deviation of the echo of a rigid wall of one of [`SLOPES`] from its mean over places.
pub const STRAY: f64 = 0.03;

/// Places of a wall in the cells: parts of a cell by which it is moved along the grid's axis nearest to its normal.
pub const PLACES: [f64; 6] = [0.0, 1.0 / 6.0, 1.0 / 3.0, 0.5, 2.0 / 3.0, 5.0 / 6.0];

/// Tangents of the angles of incidence, and these in degrees.
const INCIDENCES: [(f64, usize); 2] = [(0.0, 0), (1.0, 45)];

/// Schemes that the tolerances apply to.
pub const SCHEMES: [Scheme; 3] = [Scheme::M13, Scheme::O13, Scheme::D25];

/// Echoes of a wall in one place: rigid, and with the impedances of [`RATIOS`].
type Echoes = [Complex<f64>; 1 + RATIOS.len()];

/// Errors of the reflection factor for the impedances of [`RATIOS`].
#[derive(Debug, Clone, Copy)]
pub struct Errors {
    /// Of the mean over places of the wall in the cells.
    pub mean: [f64; RATIOS.len()],
    /// The largest of all places.
    pub largest: [f64; RATIOS.len()],
    /// Largest deviation of the rigid wall's echo from its mean over places, relative.
    pub stray: f64,
}

/// Setting of a case; the tangent is that of the angle of incidence.
pub fn setting(scheme: Scheme, tilt_deg: f64, tangent: f64) -> Setting {
    let case = format!("{scheme}, {tilt_deg} degrees, {tangent}");
    Setting::before_accurate_surfaces("tilted impedance", &case)
}

/// Errors of the reflection factor of a wall that is tilted by `tilt_deg`, at an angle of incidence whose tangent is
/// given, over some of [`PLACES`].
///
/// # Errors
/// When the field becomes non-finite.
pub fn errors(
    setting: &Setting,
    scheme: Scheme,
    model: WallModel,
    tilt_deg: f64,
    tangent: f64,
    places: &[f64],
) -> Result<Errors, Error> {
    let places = places.par_iter().map(|place| {
        let shift = place * tilt_deg.to_radians().cos();
        let echoes = echoes(setting, scheme, model, tilt_deg, tangent, shift, &RATIOS)?;
        Ok(std::array::from_fn(|i| echoes[i]))
    });
    let places: Vec<Echoes> = places.collect::<Result<_, Error>>()?;
    // As good as the mean: the factor is a ratio.
    let sum: Echoes = std::array::from_fn(|i| places.iter().map(|echoes| echoes[i]).sum());
    let mut largest = [0.0_f64; RATIOS.len()];
    for echoes in &places {
        for (largest, error) in largest.iter_mut().zip(off(echoes, tangent)) {
            *largest = largest.max(error);
        }
    }
    let rigid: Vec<Complex<f64>> = places.iter().map(|echoes| echoes[0]).collect();
    Ok(Errors {
        mean: off(&sum, tangent),
        largest,
        stray: off_mean(&rigid),
    })
}

/// Largest deviation of the echo of a rigid wall that is tilted by `tilt_deg` from its mean over some of [`PLACES`],
/// relative; the tangent is that of the angle of incidence.
///
/// # Errors
/// When the field becomes non-finite.
pub fn stray(
    setting: &Setting,
    scheme: Scheme,
    tilt_deg: f64,
    tangent: f64,
    places: &[f64],
) -> Result<f64, Error> {
    let places = places.par_iter().map(|place| {
        let shift = place * tilt_deg.to_radians().cos();
        let model = WallModel::CutCells;
        let echoes = echoes(setting, scheme, model, tilt_deg, tangent, shift, &[])?;
        Ok(echoes[0])
    });
    Ok(off_mean(&places.collect::<Result<Vec<_>, Error>>()?))
}

/// Largest deviation of numbers from their mean, relative.
fn off_mean(numbers: &[Complex<f64>]) -> f64 {
    let mean = numbers.iter().sum::<Complex<f64>>() / numbers.len() as f64;
    let off = numbers
        .iter()
        .map(|number| (number - mean).norm() / mean.norm());
    off.fold(0.0, f64::max)
}

/// Differences between echoes over the rigid wall's and the formula.
fn off(echoes: &Echoes, tangent: f64) -> [f64; RATIOS.len()] {
    let cos = 1.0 / tangent.hypot(1.0);
    std::array::from_fn(|i| {
        let z = RATIOS[i];
        let sum = z * cos + 1.0;
        let slope = 2.0 * z / sum.powi(2);
        let bend = -4.0 * z * z / sum.powi(3) * (1.0 - cos * cos) - slope * cos;
        let c_mps = Conditions::PAPERS.medium.c_mps;
        let next = bend * c_mps / (2.0 * TAU * FREQUENCY_HZ * way_m(tangent));
        (echoes[1 + i] / echoes[0] - Complex::new((z * cos - 1.0) / sum, next)).norm()
    })
}

/// Way of the echo in metres, on the papers' grid.
fn way_m(tangent: f64) -> f64 {
    2.0 * DISTANCE_M * tangent.hypot(1.0)
}

/// Spectral lines of the echoes of a wall that is moved into its normal by `shift` cells: rigid, and with the
/// impedances of `ratios`.
fn echoes(
    setting: &Setting,
    scheme: Scheme,
    model: WallModel,
    tilt_deg: f64,
    tangent: f64,
    shift: f64,
    ratios: &[f64],
) -> Result<Vec<Complex<f64>>, Error> {
    let conditions = &setting.conditions;
    let open = Rig::open(setting, scheme, 400, 360);
    let wall = |foot_m| Tilted::new(conditions, tilt_deg, foot_m, conditions.m(1.6));
    let tilted = wall(wall(conditions.point([1.0, 1.1])).behind(shift * conditions.dx_m));
    let [along_x, along_y] = [tilted.normal[1], -tilted.normal[0]];
    let distance_m = conditions.m(DISTANCE_M);
    let aside_m = tangent * distance_m;
    let front = |side: f64| {
        let [x, y] = tilted.behind(-distance_m);
        [x + side * aside_m * along_x, y + side * aside_m * along_y]
    };
    let burst = conditions.burst(FREQUENCY_HZ, 1000.0);
    let way_s = conditions.m(way_m(tangent)) / conditions.medium.c_mps;
    let steps = ((way_s + 2.0 * burst.centre_s) / conditions.dt_s) as usize;
    let hear = |rig: &Rig| {
        let strength = |t_s: f64| burst.value(t_s);
        rig.run(&|_| front(-1.0), &|_| front(1.0), &strength, steps)
    };
    let direct = hear(&open)?;
    let echo = |impedance: Option<Impedance>| -> Result<Complex<f64>, Error> {
        let mut wall = tilted.wall.clone();
        wall.impedance = impedance;
        let walled = open.clone().with_model(model, &[wall]);
        let echo = difference(&hear(&walled)?, &direct);
        Ok(open.line(&echo, burst.frequency_hz))
    };
    let of = |z: f64| Some(Impedance::Real(z * conditions.air_pasm()));
    let ratios = ratios.iter().map(|&z| of(z));
    std::iter::once(None).chain(ratios).map(echo).collect()
}

/// Measurements of the echo.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let (schemes, slants, slopes) = match depth {
        Depth::Quick => (&SCHEMES[1..2], &SLANTS[1..2], &SLOPES[2..]),
        Depth::Full => (&SCHEMES[..], &SLANTS[..], &SLOPES[..]),
    };
    let quantity = "reflection factor, error";
    let mut found = Vec::new();
    for &scheme in schemes {
        let case = |tilt_deg: f64, incidence: usize, what: &str| {
            let tilt_deg = (1e3 * tilt_deg).round() / 1e3;
            format!("{scheme}, {tilt_deg} degrees, met at {incidence}, {what}")
        };
        for &(tilt_deg, allowed) in slants.iter().chain(slopes) {
            let is_slant = slants.iter().any(|slant| slant.0 == tilt_deg);
            for ((tangent, incidence), allowed) in INCIDENCES.into_iter().zip(allowed) {
                let setting = setting(scheme, tilt_deg, tangent);
                let model = WallModel::CutCells;
                let errors = errors(&setting, scheme, model, tilt_deg, tangent, &PLACES)?;
                let case = |tilt_deg, incidence, what: &str| {
                    named(&case(tilt_deg, incidence, what), &setting)
                };
                for (ratio, error) in RATIOS.into_iter().zip(errors.mean).filter(|_| is_slant) {
                    let case = case(tilt_deg, incidence, &format!("Z = {ratio} rho c"));
                    found.push(Measurement::below(
                        case,
                        quantity,
                        error,
                        mean_tolerance(tilt_deg),
                    ));
                }
                let largest = errors.largest.into_iter().fold(0.0, f64::max);
                let place = case(tilt_deg, incidence, "worst single place");
                found.push(Measurement::below(place, quantity, largest, allowed));
                if !is_slant {
                    let rigid = case(tilt_deg, incidence, "rigid, worst single place");
                    let quantity = "echo over its mean, error";
                    found.push(Measurement::below(rigid, quantity, errors.stray, STRAY));
                }
            }
        }
    }
    Ok(found)
}
