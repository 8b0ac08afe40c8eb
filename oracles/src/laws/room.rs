//! Between rigid walls: standing waves, energy, order of convergence.
//!
//! Layout, modes: a box of 96 x 64 cells inside solid walls; the field starts as one mode and runs freely for 3000
//! steps (25 ms).
//! Formula: `cos(pi m (x - x0)/Lx) cos(pi n (y - y0)/Ly) cos(omega t)`; on the grid with `4 sin^2(omega dt/2)` the
//! scheme's symbol of `4 sin^2(pi m / 2 Nx)` and `4 sin^2(pi n / 2 Ny)`, with the coefficients as they are rounded,
//! plus the restoring quantum; in the continuum `omega = c pi hypot(m/Lx, n/Ly)`.
//! Bias: dispersion against the continuum, where the restoring quantum's share is taken off (1.7e-4 of the lowest
//! mode's frequency on the papers' grid, by the Courant number squared more or less elsewhere); against the grid's
//! formula the constant mode, which is a double sum of rounding errors in `f32`. Where a mode is the same all along one
//! side, a whole row rounds alike, and the sum grows faster.
//! Tolerance: 1e-4 of the amplitude against the grid's formula over up to 170 periods (a phase of 1e-7 of them), 2e-5
//! for all other modes together, 1e-3 for the mean; the frequency within 0.02 % (m13), 0.06 % (d25) and 0.6 % (slf) of
//! the continuum's below 5 kHz, or as much more as dispersion is larger than on the papers' grid.
//!
//! Layout, energy: a closed polygon of whole cells with slanted sides and a screen in it, and a box turned by 12
//! degrees in cut cells with a slanted screen, 160 x 160 cells; a broad burst, then 20 000 steps without a source.
//! Formula: the leapfrog's invariant `|p' - p|^2 / 2 - <p', L p> / 2` in the inner product of the open areas, with
//! `L p = p' - 2 p + p''` from three successive fields.
//! Bias: none; the operator is symmetric.
//! Tolerance: 1e-4 of the energy over the run. A wall that is not symmetric would blow up or decay within some hundred
//! steps.
//!
//! Layout, order: one mode in a box of 24 x 16 and of 48 x 32 cells at the same Courant number, as long in periods.
//! Formula: the error of its frequency falls by 2^order. d25 has no order in its band: its error is spread over it,
//! below 0.1 %.
//! Bias: the restoring quantum's share is taken off.
//! Tolerance: 0.2 of the order.

use super::conditions::Conditions;
use super::measurement::{Depth, Measurement, larger, named, schemes};
use super::rig::{Rig, wrapped};
use super::setting::Setting;
use fdtd::Error;
use fdtd::field::{FastField, Field};
use fdtd::scheme::{RESTORING_QUANTUM, Scheme};
use fdtd::walls::{Impedance, Wall, WallModel};
use std::f64::consts::{PI, TAU};

const WALL: usize = 4;

/// Modes that are tried.
pub const MODES: [[f64; 2]; 6] = [
    [1.0, 0.0],
    [0.0, 1.0],
    [3.0, 2.0],
    [7.0, 0.0],
    [10.0, 5.0],
    [18.0, 13.0],
];

/// A mode after a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ringing {
    /// Amplitude minus that of the grid's formula.
    pub amplitude_error: f64,
    /// Root mean square of the other modes but the constant one.
    pub spill: f64,
    /// Mean pressure over the mode's root mean square.
    pub mean: f64,
    /// Frequency by the grid's formula over the continuum's, minus 1, without the restoring quantum's share.
    pub detuned: f64,
    /// Frequency by measurement over the continuum's, minus 1, without the restoring quantum's share.
    pub measured_detuned: f64,
    /// Frequency of the continuum in hertz on the papers' grid.
    pub continuum_hz: f64,
}

/// Lets the mode `[m, n]` ring in a box of `cells` for as many periods as in `steps` steps on the papers' grid.
pub fn ring(
    setting: &Setting,
    scheme: Scheme,
    cells: [usize; 2],
    [m, n]: [f64; 2],
    steps: usize,
) -> Ringing {
    let conditions = &setting.conditions;
    let steps = conditions.steps(steps);
    let (nx, ny) = (cells[0] + 2 * WALL, cells[1] + 2 * WALL);
    let inside = |i: usize, size: usize| (WALL..WALL + size).contains(&i);
    let mut rig = Rig::open(setting, scheme, nx, ny)
        .with_walls(|ix, iy| !(inside(ix, cells[0]) && inside(iy, cells[1])));
    rig.layer_cells = 0;
    let stiffness =
        |mode: f64, cells: usize| 4.0 * (PI * mode / (2.0 * cells as f64)).sin().powi(2);
    let symbol = rig
        .polynomial()
        .symbol(stiffness(m, cells[0]), stiffness(n, cells[1]))
        + f64::from(RESTORING_QUANTUM);
    let omega_dt = 2.0 * (0.5 * symbol.sqrt()).asin();
    let shape = rig.cells(|ix, iy| {
        if !(inside(ix, cells[0]) && inside(iy, cells[1])) {
            return 0.0;
        }
        let along = |i: usize, mode: f64, cells: usize| {
            (PI * mode * ((i - WALL) as f64 + 0.5) / cells as f64).cos()
        };
        along(ix, m, cells[0]) * along(iy, n, cells[1])
    });
    let swing = rig.swing(&shape, omega_dt, steps);
    let amplitude = swing.amplitude;
    let size: f64 = shape.iter().map(|p| p * p).sum();
    let inside_cells = (cells[0] * cells[1]) as f64;
    let sum: f64 = swing.pressure.iter().map(|&p| f64::from(p)).sum();
    let mean = sum / inside_cells / (size / inside_cells).sqrt();
    let across: f64 = swing
        .pressure
        .iter()
        .zip(&shape)
        .map(|(&p, shape)| (f64::from(p) - amplitude * shape).powi(2))
        .sum::<f64>()
        - sum * sum / inside_cells;
    let phase = omega_dt * steps as f64;
    // In radians per step; the quantum adds to the square of the frequency.
    let continuum = rig.courant() * PI * (m / cells[0] as f64).hypot(n / cells[1] as f64);
    let stiffened = continuum.hypot(f64::from(RESTORING_QUANTUM).sqrt());
    let late = wrapped(swing.turned_rad - stiffened * steps as f64);
    Ringing {
        amplitude_error: amplitude - phase.cos(),
        spill: (across.max(0.0) / size).sqrt(),
        mean,
        detuned: omega_dt / stiffened - 1.0,
        measured_detuned: late / (stiffened * steps as f64),
        continuum_hz: continuum / (TAU * conditions.dt_s) * conditions.s(1.0),
    }
}

/// The ringing of a mode in the box of 96 x 64 cells.
pub fn mode(setting: &Setting, scheme: Scheme, mode: [f64; 2]) -> Ringing {
    ring(setting, scheme, [96, 64], mode, 3000)
}

/// Tolerance of the frequency of a mode below 5 kHz against the continuum's, in proportion to the dispersion on the
/// papers' grid.
pub fn detuning_allowed(conditions: &Conditions, scheme: Scheme) -> f64 {
    let on_papers_grid = match scheme {
        Scheme::Slf => 6e-3,
        Scheme::M13 => 2e-4,
        Scheme::O13 => 1.5e-3,
        Scheme::D25 => 6e-4,
        Scheme::Iwb => 8e-3,
    };
    on_papers_grid * conditions.dispersion(scheme, 5e3)
}

/// Measurements of the modes.
///
/// # Errors
/// None.
pub fn measure_modes(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let modes = match depth {
        Depth::Quick => &MODES[2..5],
        Depth::Full => &MODES[..],
    };
    let mut found = Vec::new();
    for scheme in schemes() {
        for &numbers in modes {
            let case = format!("{scheme}, mode {} {}", numbers[0], numbers[1]);
            let setting = Setting::drawn("modes", &case);
            let ringing = mode(&setting, scheme, numbers);
            let case = named(&case, &setting);
            let amplitude = ringing.amplitude_error;
            found.push(Measurement::within(
                case.clone(),
                "amplitude",
                amplitude,
                1e-4,
            ));
            for (quantity, measured, most) in [
                ("other modes", ringing.spill, 2e-5),
                ("mean pressure", ringing.mean.abs(), 1e-3),
            ] {
                found.push(Measurement::below(case.clone(), quantity, measured, most));
            }
            let quantity = "frequency over the continuum's - 1";
            found.push(if ringing.continuum_hz < 5e3 {
                let allowed = detuning_allowed(&setting.conditions, scheme);
                Measurement::within(case, quantity, ringing.detuned, allowed)
            } else {
                Measurement::shown(case, quantity, ringing.detuned)
            });
        }
    }
    Ok(found)
}

/// The invariant at the half step to come. Takes one step.
pub fn energy(field: &mut FastField, rig: &Rig) -> f64 {
    let before = field.state();
    field.advance(&rig.silence(1), &mut Vec::new());
    let after = field.state();
    let cells = after
        .pressure
        .iter()
        .zip(&before.pressure)
        .zip(&before.previous)
        .zip(rig.walls.areas());
    cells
        .map(|(((&next, &now), &past), area)| {
            let (next, now, past) = (f64::from(next), f64::from(now), f64::from(past));
            area * (0.5 * (next - now).powi(2) - 0.5 * next * (next - 2.0 * now + past))
        })
        .sum()
}

/// A closed polygon with slanted sides and a screen in it, `size` x `size` cells.
pub fn closed_rig(setting: &Setting, scheme: Scheme, size: usize) -> Rig {
    let last = size as f64;
    let mut rig = Rig::open(setting, scheme, size, size).with_walls(|ix, iy| {
        let (x, y) = (ix as f64, iy as f64);
        let outside = x < 5.0 + 0.1 * y
            || x > last - 6.0 - 0.05 * y
            || y < 5.0 + 0.15 * x
            || y > last - 7.0 - 0.2 * (x - 0.5 * last).abs();
        let screen = (x - 0.6 * last - 0.4 * (y - 0.5 * last)).abs() < 2.0
            && (y - 0.5 * last).abs() < 0.15 * last;
        outside || screen
    });
    rig.layer_cells = 0;
    rig
}

/// A box turned by 12 degrees in cut cells, with a slanted screen in it, `size` x `size` cells.
pub fn slanted_rig(setting: &Setting, scheme: Scheme, size: usize) -> Rig {
    slanted_room(setting, scheme, size, WallModel::CutCells, None)
}

/// The same with walls of an impedance (rigid when `None`) made into cells by `model`.
pub fn slanted_room(
    setting: &Setting,
    scheme: Scheme,
    size: usize,
    model: WallModel,
    impedance: Option<Impedance>,
) -> Rig {
    let dx_m = setting.conditions.dx_m;
    let mut rig = Rig::open(setting, scheme, size, size);
    rig.layer_cells = 0;
    let wall = |points: &[[f64; 2]]| Wall {
        points_m: points
            .iter()
            .map(|point| point.map(|x| x * size as f64 * dx_m))
            .collect(),
        thickness_m: 4.0 * dx_m,
        impedance: impedance.clone(),
    };
    let (sin, cos) = 12_f64.to_radians().sin_cos();
    let corner = |[x, y]: [f64; 2]| [0.5 + x * cos - y * sin, 0.5 + x * sin + y * cos];
    let corners = [
        [-0.35, -0.3],
        [0.35, -0.3],
        [0.35, 0.3],
        [-0.35, 0.3],
        [-0.35, -0.3],
    ];
    let walls = [
        wall(&corners.map(corner)),
        wall(&[[0.6, 0.35], [0.67, 0.52], [0.55, 0.6]]),
    ];
    rig.with_model(model, &walls)
}

/// Relative changes of the energy in a closed room of 160 x 160 cells every 2000 steps, `turns` times.
pub fn energy_changes(rig: &Rig, turns: usize) -> Vec<f64> {
    let conditions = rig.conditions();
    let burst = conditions.burst(6e3, 2000.0);
    let mut field = rig.field();
    let place_m = rig.setting.between([[0.26, 0.34], [0.26, 0.34]]);
    let steps = conditions.steps(400);
    field.advance(
        &rig.sounding(place_m, &|t_s| burst.value(t_s), steps),
        &mut Vec::new(),
    );
    let start = energy(&mut field, rig);
    let silence = rig.silence(2000);
    (0..turns)
        .map(|_| {
            field.advance(&silence, &mut Vec::new());
            energy(&mut field, rig) / start - 1.0
        })
        .collect()
}

/// Measurements of the energy.
///
/// # Errors
/// None.
pub fn measure_energy(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let turns = match depth {
        Depth::Quick => 3,
        Depth::Full => 10,
    };
    let mut found = Vec::new();
    for scheme in schemes() {
        for (walls, room) in [
            ("cells", closed_rig as fn(&Setting, Scheme, usize) -> Rig),
            ("cut cells", slanted_rig),
        ] {
            let case = format!("{scheme}, {walls}");
            let setting = Setting::drawn("energy", &case);
            let changes = energy_changes(&room(&setting, scheme, 160), turns);
            let largest = changes.into_iter().fold(0.0, larger);
            let case = named(&format!("{case}, {} steps", 2000 * turns), &setting);
            let quantity = "energy, relative change";
            found.push(Measurement::within(case, quantity, largest, 1e-4));
        }
    }
    Ok(found)
}

/// Errors of the frequency of mode 3 2 in 24 x 16 and 48 x 32 cells.
pub fn refinement(setting: &Setting, scheme: Scheme) -> [f64; 2] {
    [1, 2].map(|fine| {
        let cells = [24 * fine, 16 * fine];
        ring(setting, scheme, cells, [3.0, 2.0], 200 * fine).measured_detuned
    })
}

/// Measurements of the order.
///
/// # Errors
/// None.
pub fn measure_order(_: Depth) -> Result<Vec<Measurement>, Error> {
    Ok(schemes()
        .map(|scheme| {
            let case = format!("{scheme}, mode 3 2");
            let setting = Setting::drawn("order", &case);
            let [coarse, fine] = refinement(&setting, scheme);
            let case = named(&case, &setting);
            let order = (coarse / fine).abs().log2();
            match scheme {
                Scheme::Slf | Scheme::M13 | Scheme::Iwb => {
                    let nominal = if scheme == Scheme::M13 { 4.0 } else { 2.0 };
                    let least = Some(nominal - 0.2);
                    Measurement {
                        least,
                        ..Measurement::below(case, "order", order, nominal + 0.2)
                    }
                }
                Scheme::O13 | Scheme::D25 => {
                    let largest = coarse.abs().max(fine.abs());
                    let most = if scheme == Scheme::O13 { 3e-3 } else { 1e-3 };
                    Measurement::below(case, "error of both grids", largest, most)
                }
            }
        })
        .collect())
}
