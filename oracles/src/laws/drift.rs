//! A million steps in f32 between rigid walls.
//!
//! Layout: the closed room of the energy law, 64 x 64 cells; 120 periods of a tone in a whole number of steps (2000 on
//! the papers' grid), then silence up to a million (8.3 s).
//! Formula: energy stays; the mean pressure is `rho c^2 / area` times the integral of q, which is zero after whole
//! periods.
//! Bias: rounding is a random walk. Without the restoring quantum its double sum would move the mean by more than the
//! sound.
//! Tolerance: 1e-3 of the energy; the mean below 1 % of the root mean square.

use super::measurement::{Depth, Measurement, named};
use super::room::{closed_rig, energy};
use super::setting::Setting;
use fdtd::Error;
use fdtd::field::Field;
use fdtd::scheme::Scheme;
use std::f64::consts::TAU;

/// Steps between two looks at the mean.
const STRIDE: usize = 4000;
const STEPS: usize = 1_000_000;

/// Schemes that are measured; m13 is o13 with other weights.
pub const SCHEMES: [Scheme; 3] = [Scheme::Slf, Scheme::O13, Scheme::D25];

/// Largest relative change of the energy, and largest mean over the root mean square.
pub const TOLERANCES: [f64; 2] = [1e-3, 0.01];

/// Relative change of the energy over `steps` steps of silence, and the largest mean pressure over the root mean square
/// of all pressures.
pub fn drift(setting: &Setting, scheme: Scheme, steps: usize) -> [f64; 2] {
    let conditions = &setting.conditions;
    let rig = closed_rig(setting, scheme, 64);
    let loud = conditions.steps(2000);
    let loud_s = loud as f64 * conditions.dt_s;
    let tone = |t_s: f64| {
        if t_s < loud_s {
            (TAU * 120.0 * t_s / loud_s).sin()
        } else {
            0.0
        }
    };
    let mut field = rig.field();
    let place_m = conditions.point([0.13, 0.15]);
    field.advance(&rig.sounding(place_m, &tone, loud + 100), &mut Vec::new());
    let silence = rig.silence(STRIDE);
    let air = rig.walls.areas().iter().sum::<f64>();
    let early = energy(&mut field, &rig);
    let looks = steps / STRIDE;
    let (mut mean, mut squares) = (0.0_f64, 0.0);
    for _ in 0..looks {
        field.advance(&silence, &mut Vec::new());
        let pressure = field.state().pressure;
        mean = mean.max((pressure.iter().map(|&p| f64::from(p)).sum::<f64>() / air).abs());
        squares += pressure.iter().map(|&p| f64::from(p).powi(2)).sum::<f64>() / air;
    }
    let rms = (squares / looks as f64).sqrt();
    [energy(&mut field, &rig) / early - 1.0, mean / rms]
}

/// The law's measurements.
///
/// # Errors
/// None.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let (schemes, steps) = match depth {
        Depth::Quick => (&SCHEMES[1..2], STEPS / 5),
        Depth::Full => (&SCHEMES[..], STEPS),
    };
    let mut found = Vec::new();
    for &scheme in schemes {
        let setting = Setting::drawn("drift", scheme.name());
        let [change, mean] = drift(&setting, scheme, steps);
        let case = named(&format!("{scheme}, {steps} steps"), &setting);
        let [of_energy, of_mean] = TOLERANCES;
        let quantity = "energy, relative change";
        found.push(Measurement::within(
            case.clone(),
            quantity,
            change,
            of_energy,
        ));
        let quantity = "mean pressure over root mean square";
        found.push(Measurement::below(case, quantity, mean, of_mean));
    }
    Ok(found)
}
