//! Standing waves between four rigid walls.
//!
//! Layout: a box of 96 x 64 cells inside solid walls; the field starts as one mode and is left alone for 3000 steps (25 ms).
//! Formula: `cos(pi m (x - x0)/Lx) cos(pi n (y - y0)/Ly) cos(omega t)`; on the grid with `4 sin^2(omega dt/2)` the scheme's symbol of
//! `4 sin^2(pi m / 2 Nx)` and `4 sin^2(pi n / 2 Ny)` plus the restoring quantum; in the continuum `omega = c pi hypot(m/Lx, n/Ly)`.
//! Bias: none against the grid's formula; dispersion against the continuum.
//! Tolerance: 2e-4 of the amplitude against the grid's formula over up to 170 periods (a phase of 2e-7 of them); the frequency within 0.02 % (m13)
//! and 0.6 % (slf) of the continuum's below 5 kHz.

use crate::rig::{AIR, DT_S, DX_M, Rig};
use fdtd::field::{Field, FieldState};
use fdtd::scheme::{RESTORING_QUANTUM, Scheme};
use std::f64::consts::PI;

const BOX: [usize; 2] = [96, 64];
const WALL: usize = 4;
const STEPS: usize = 3000;

fn check(scheme: Scheme, [m, n]: [f64; 2]) {
    let (nx, ny) = (BOX[0] + 2 * WALL, BOX[1] + 2 * WALL);
    let inside = |i: usize, size: usize| (WALL..WALL + size).contains(&i);
    let mut rig =
        Rig::open(scheme, nx, ny).with_walls(|ix, iy| !(inside(ix, BOX[0]) && inside(iy, BOX[1])));
    rig.layer_cells = 0;
    let stiffness =
        |mode: f64, cells: usize| 4.0 * (PI * mode / (2.0 * cells as f64)).sin().powi(2);
    let symbol = scheme.symbol(rig.courant(), stiffness(m, BOX[0]), stiffness(n, BOX[1]))
        + f64::from(RESTORING_QUANTUM);
    let omega_dt = 2.0 * (0.5 * symbol.sqrt()).asin();
    let shape = |cell: usize| {
        let (ix, iy) = (cell % nx, cell / nx);
        if !(inside(ix, BOX[0]) && inside(iy, BOX[1])) {
            return 0.0;
        }
        let along = |i: usize, mode: f64, cells: usize| {
            (PI * mode * ((i - WALL) as f64 + 0.5) / cells as f64).cos()
        };
        along(ix, m, BOX[0]) * along(iy, n, BOX[1])
    };
    let mut field = rig.field();
    let blank = field.state();
    field.set_state(&FieldState {
        pressure: (0..nx * ny).map(|cell| shape(cell) as f32).collect(),
        previous: (0..nx * ny)
            .map(|cell| (shape(cell) * omega_dt.cos()) as f32)
            .collect(),
        ..blank
    });
    field.advance(&rig.silence(STEPS), &mut Vec::new());
    let pressure = field.state().pressure;
    let (mut along, mut across, mut size) = (0.0, 0.0, 0.0);
    for (cell, &p) in pressure.iter().enumerate() {
        along += f64::from(p) * shape(cell);
        size += shape(cell).powi(2);
    }
    let amplitude = along / size;
    for (cell, &p) in pressure.iter().enumerate() {
        across += (f64::from(p) - amplitude * shape(cell)).powi(2);
    }
    let expected = (omega_dt * STEPS as f64).cos();
    let continuum = AIR.c_mps * PI * (m / BOX[0] as f64).hypot(n / BOX[1] as f64) / DX_M;
    let detuned = omega_dt / DT_S / continuum - 1.0;
    let spill = (across / size).sqrt();
    println!(
        "mode {m} {n}, {scheme}: amplitude off {:+.1e}, other modes {spill:.1e}, detuned {detuned:+.1e}",
        amplitude - expected
    );
    assert!(
        (amplitude - expected).abs() < 2e-4,
        "{scheme} {m} {n}: {amplitude} instead of {expected}"
    );
    assert!(
        spill < 2e-4,
        "{scheme} {m} {n}: {spill} leaks into other modes"
    );
    let allowed = if scheme == Scheme::M13 { 2e-4 } else { 6e-3 };
    assert!(
        continuum > 2.0 * PI * 5e3 || detuned.abs() < allowed,
        "{scheme} {m} {n}: {detuned}"
    );
}

#[test]
fn modes_of_a_rigid_box_ring_at_the_grids_frequencies() {
    for scheme in Scheme::ALL {
        for mode in [
            [1.0, 0.0],
            [0.0, 1.0],
            [3.0, 2.0],
            [7.0, 0.0],
            [10.0, 5.0],
            [18.0, 13.0],
        ] {
            check(scheme, mode);
        }
    }
}
