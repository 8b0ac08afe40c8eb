//! A source drives past a receiver in open air: the frequency that arrives, beside the exact one.
//!
//! `cargo run --release -p fdtd --example moving_source`

use std::f64::consts::TAU;

use fdtd::grid::{Grid, Medium};
use fdtd::scheme::Scheme;
use fdtd::simulation::{Domain, Flow, MovingPair, Simulation, SimulationOptions};
use fdtd::spread::Spread;
use fdtd::walls::WallCells;

const MEDIUM: Medium = Medium {
    c_mps: 340.0,
    rho_kgpm3: 1.293,
};
const FIELD_RATE_HZ: f64 = 30e3;
const TONE_HZ: f64 = 1500.0;
const SPEED_MPS: f64 = 30.0;
/// The source drives along x from here; the receiver stands 2 m beside its way.
const START_M: [f64; 2] = [1.0, 1.0];
const RECEIVER_M: [f64; 2] = [4.0, 3.0];
/// Periods of the tone that one measurement of the phase takes.
const WINDOW: f64 = 9.0;

/// Phase of the signal against the tone around time `t_s`, in cycles.
fn phase_cycles(signal: &[f32], t_s: f64) -> f64 {
    let half = (0.5 * WINDOW / TONE_HZ * FIELD_RATE_HZ) as usize;
    let middle = (t_s * FIELD_RATE_HZ).round() as usize;
    let (mut re, mut im) = (0.0, 0.0);
    for (n, &pressure) in signal
        .iter()
        .enumerate()
        .take(middle + half)
        .skip(middle - half)
    {
        let weight = 1.0 + (TAU * (n as f64 - middle as f64) / (2 * half) as f64).cos();
        let (sin, cos) = (TAU * TONE_HZ * n as f64 / FIELD_RATE_HZ).sin_cos();
        re += weight * f64::from(pressure) * cos;
        im -= weight * f64::from(pressure) * sin;
    }
    im.atan2(re) / TAU
}

/// Frequency at the receiver at time `t_s`: `f c / (c - v cos(angle))` with the angle at the time of emission.
fn exact_hz(t_s: f64) -> f64 {
    let c_mps = MEDIUM.c_mps;
    // The sound has taken `t - e` from where the source was at time e; the mapping contracts by v / c each time.
    let to_receiver = |e_s: f64| {
        [
            RECEIVER_M[0] - START_M[0] - SPEED_MPS * e_s,
            RECEIVER_M[1] - START_M[1],
        ]
    };
    let mut emitted_s = t_s;
    for _ in 0..50 {
        let [x, y] = to_receiver(emitted_s);
        emitted_s = t_s - x.hypot(y) / c_mps;
    }
    let [x, y] = to_receiver(emitted_s);
    TONE_HZ * c_mps / (c_mps - SPEED_MPS * x / x.hypot(y))
}

fn main() -> Result<(), fdtd::Error> {
    let grid = Grid {
        nx: 400,
        ny: 200,
        dx_m: 0.02,
        dt_s: 1.0 / FIELD_RATE_HZ,
    };
    let domain = Domain {
        grid,
        medium: MEDIUM,
        scheme: Scheme::M13,
        spread: Spread::Kaiser12,
        layer_cells: 20,
        walls: WallCells::open(grid.nx, grid.ny),
    };
    let drive = MovingPair::new(
        &domain,
        Box::new(|t| [START_M[0] + SPEED_MPS * t, START_M[1]]),
        Box::new(|_| RECEIVER_M),
        // Faded in, in m^2/s.
        Box::new(|t| 1e-3 * (t / 0.005).min(1.0) * (TAU * TONE_HZ * t).sin()),
        false,
    );
    let options = SimulationOptions::default();
    let mut run = Simulation::from_parts(domain, drive, 0.2, FIELD_RATE_HZ, TONE_HZ, &options)?;
    run.run(&mut |_, _| Flow::Continue)?;

    let signal = run.received();
    println!("time s      field Hz   exact Hz");
    for k in 2..10 {
        let (t_s, lag_s) = (0.02 * f64::from(k), 0.002);
        let cycles =
            phase_cycles(&signal, t_s + 0.5 * lag_s) - phase_cycles(&signal, t_s - 0.5 * lag_s);
        let field_hz = TONE_HZ + (cycles - cycles.round()) / lag_s;
        println!("{t_s:6.2} {field_hz:10.1} {:10.1}", exact_hz(t_s));
    }
    Ok(())
}
