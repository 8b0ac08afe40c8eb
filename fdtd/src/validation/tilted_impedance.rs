//! Echoes of walls of an impedance that lie across the grid.
//!
//! Layout: as the echo of [`super::tilted`]: a wall of 1.6 m, tilted by 3, 10, 20, 30, 40 and 45 degrees and moved through the cells in three steps; source and microphone
//! 0.4 m in front of it, on one line across it or 0.8 m apart along it, so that the wave comes in at 45 degrees. A run without the wall is
//! subtracted, and the spectral line at 10 kHz divided by that of the same wall, rigid.
//! Formula: `R = (Z cos - rho c)/(Z cos + rho c)` and, for a line source at a distance r behind the image, `R + i R''/(2 k r)` (the next term
//! of the stationary phase; the second derivative is that by the angle).
//! Bias: what the ends diffract comes 2 ms later, when the burst is over.
//! The rigid wall's own error is in both and not counted.
//! Tolerance: 0.02 at 3 degrees, 0.03 at 20 and 30, elsewhere what was measured and a third more, see [`TILTS`] (m13, o13, d25); Z/(rho c) from 0.05 to 20. Walls of
//! 45 degrees that are met at 45 degrees are shown: the rigid wall itself gives waves along such a wall another phase, as its place in the cells
//! will have it, by up to 0.17 at this angle.

use super::rig::{AIR, DT_S, DX_M, Rig, difference, line};
use super::tilted::Tilted;
use super::{Depth, Measurement};
use crate::Error;
use crate::exact::burst::Burst;
use crate::scheme::Scheme;
use crate::walls::{Impedance, WallModel};
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Frequency of the burst in hertz.
const FREQUENCY_HZ: f64 = 10e3;

/// Distance in metres of source and microphone from the wall.
const DISTANCE_M: f64 = 0.4;

/// Impedances over that of the air.
pub const RATIOS: [f64; 5] = [0.05, 0.2, 1.0, 5.0, 20.0];

/// Tilts in degrees, and what the factor may be off at normal incidence and at 45 degrees.
pub const TILTS: [(f64, [f64; 2]); 6] = [
    (3.0, [0.02, 0.02]),
    (10.0, [0.05, 0.05]),
    (20.0, [0.03, 0.03]),
    (30.0, [0.03, 0.03]),
    (40.0, [0.065, 0.045]),
    (45.0, [0.05, f64::INFINITY]),
];

/// Schemes that are held to it.
pub const SCHEMES: [Scheme; 3] = [Scheme::M13, Scheme::O13, Scheme::D25];

/// Errors of the reflection factor for the impedances of [`RATIOS`], at an angle of incidence whose tangent is given, with the
/// wall moved into its normal by `shift` cells.
///
/// # Errors
/// When the field becomes non-finite.
pub fn errors(
    scheme: Scheme,
    model: WallModel,
    tilt_deg: f64,
    tangent: f64,
    shift: f64,
) -> Result<[f64; RATIOS.len()], Error> {
    let open = Rig::open(scheme, 400, 360);
    let at = Tilted::new(tilt_deg, [1.0, 1.1], 1.6).behind(shift * DX_M);
    let tilted = Tilted::new(tilt_deg, at, 1.6);
    let [along_x, along_y] = [tilted.normal[1], -tilted.normal[0]];
    let aside_m = tangent * DISTANCE_M;
    let front = |side: f64| {
        let [x, y] = tilted.behind(-DISTANCE_M);
        [x + side * aside_m * along_x, y + side * aside_m * along_y]
    };
    let burst = Burst::from_zero(FREQUENCY_HZ, 1000.0);
    let way_m = 2.0 * DISTANCE_M.hypot(aside_m);
    let steps = ((way_m / AIR.c_mps + 2.0 * burst.centre_s) / DT_S) as usize;
    let hear = |rig: &Rig| {
        let strength = |t_s: f64| burst.value(t_s);
        rig.run(&|_| front(-1.0), &|_| front(1.0), &strength, steps)
    };
    let direct = hear(&open)?;
    let echo = |impedance: Option<Impedance>| -> Result<Complex<f64>, Error> {
        let mut walled = open.clone();
        let mut wall = tilted.wall.clone();
        wall.impedance = impedance;
        walled.walls = model.cells(&open.grid(), &[wall]);
        Ok(line(&difference(&hear(&walled)?, &direct), FREQUENCY_HZ))
    };
    let rigid = echo(None)?;
    let cos = 1.0 / tangent.hypot(1.0);
    let mut errors = [0.0; RATIOS.len()];
    for (error, z) in errors.iter_mut().zip(RATIOS) {
        let found = echo(Some(Impedance::Real(z * AIR.rho_kgpm3 * AIR.c_mps)))? / rigid;
        let sum = z * cos + 1.0;
        let slope = 2.0 * z / sum.powi(2);
        let bend = -4.0 * z * z / sum.powi(3) * (1.0 - cos * cos) - slope * cos;
        let next = bend * AIR.c_mps / (2.0 * TAU * FREQUENCY_HZ * way_m);
        *error = (found - Complex::new((z * cos - 1.0) / sum, next)).norm();
    }
    Ok(errors)
}

/// Measurements of the echo.
///
/// # Errors
/// When the field becomes non-finite.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let (schemes, shifts) = match depth {
        Depth::Quick => (&SCHEMES[1..2], &[0.37][..]),
        Depth::Full => (&SCHEMES[..], &[0.0, 0.37, 0.71][..]),
    };
    let mut found = Vec::new();
    for &scheme in schemes {
        for (tilt_deg, allowed) in TILTS {
            for ((tangent, incidence), allowed) in [(0.0, 0), (1.0, 45)].into_iter().zip(allowed) {
                let off = shifts
                    .par_iter()
                    .map(|&shift| errors(scheme, WallModel::CutCells, tilt_deg, tangent, shift))
                    .collect::<Result<Vec<_>, Error>>()?;
                for (i, ratio) in RATIOS.into_iter().enumerate() {
                    let error = off.iter().fold(0.0_f64, |most, off| most.max(off[i]));
                    let case = format!(
                        "{scheme}, {tilt_deg} degrees, met at {incidence}, Z = {ratio} rho c"
                    );
                    let quantity = "reflection factor, error";
                    found.push(if allowed.is_finite() {
                        Measurement::below(case, quantity, error, allowed)
                    } else {
                        Measurement::shown(case, quantity, error)
                    });
                }
            }
        }
    }
    Ok(found)
}
