//! The rig of all laws: a grid with a source and a receiver on any paths, as the simulation runs it.
//!
//! Walls and paths are given as the law's layout has them; the rig's setting says how the layout lies on the grid
//! ([`super::setting`]).

use super::conditions::Conditions;
use super::setting::Setting;
use crate::exact::monopole::Monopole;
use fdtd::Error;
use fdtd::field::{FastField, Field, FieldSetup, FieldState, StepForcing};
use fdtd::grid::Grid;
use fdtd::scene::Scene;
use fdtd::scheme::{Polynomial, Scheme};
use fdtd::simulation::{Domain, Flow, MovingPair, Simulation, SimulationOptions};
use fdtd::spread::Spread;
use fdtd::walls::{SolidMask, Wall, WallCells, WallModel};
use fdtd::waveform::PeriodicWaveform;
use rustfft::num_complex::Complex;
use std::f64::consts::{PI, TAU};

/// A position in metres at a time in seconds.
pub type Path<'a> = &'a dyn Fn(f64) -> [f64; 2];

/// A grid, its scheme, its layer and its walls.
#[derive(Clone)]
pub struct Rig {
    /// Medium, grid and turn of the layout.
    pub setting: Setting,
    /// Scheme.
    pub scheme: Scheme,
    /// Spreading of source and receiver.
    pub spread: Spread,
    /// Width of the absorbing layers.
    pub layer_cells: usize,
    /// Walls, as they are on the grid.
    pub walls: WallCells,
    /// Cells of the layout along its x and y.
    size: [usize; 2],
}

impl Rig {
    /// An empty grid for a layout of `nx` by `ny` cells, with a layer of 20 cells.
    pub fn open(setting: &Setting, scheme: Scheme, nx: usize, ny: usize) -> Self {
        let [more_x, more_y] = setting.more_cells;
        let size = [nx + more_x, ny + more_y];
        let [columns, rows] = setting.turn.size(size);
        Self {
            setting: *setting,
            scheme,
            spread: Spread::Kaiser12,
            layer_cells: 20,
            walls: WallCells::open(columns, rows),
            size,
        }
    }

    /// Medium and grid.
    pub fn conditions(&self) -> &Conditions {
        &self.setting.conditions
    }

    /// Values of the layout at its cells `(ix, iy)`, in the grid's order.
    pub fn cells<T>(&self, of: impl Fn(usize, usize) -> T) -> Vec<T> {
        let [nx, ny] = self.walls.size();
        (0..nx * ny)
            .map(|cell| {
                let on_grid = [cell % nx, cell / nx];
                let [ix, iy] = self.setting.turn.cell_of(self.size, on_grid);
                of(ix, iy)
            })
            .collect()
    }

    /// The grid with the cells of the layout solid whose indices `(ix, iy)` satisfy `solid`.
    pub fn with_walls(mut self, solid: impl Fn(usize, usize) -> bool) -> Self {
        let [nx, ny] = self.walls.size();
        let mut mask = SolidMask::open(nx, ny);
        mask.cells = self.cells(solid);
        self.walls = mask.into();
        self
    }

    /// The grid with walls of the layout that `model` makes into cells.
    pub fn with_model(mut self, model: WallModel, walls: &[Wall]) -> Self {
        let turned: Vec<Wall> = walls
            .iter()
            .map(|wall| Wall {
                points_m: wall.points_m.iter().map(|&x_m| self.on_grid(x_m)).collect(),
                ..wall.clone()
            })
            .collect();
        self.walls = model.cells(&self.grid(), &turned);
        self
    }

    /// Where a point of the layout lies on the grid, in metres.
    fn on_grid(&self, point_m: [f64; 2]) -> [f64; 2] {
        let size_m = self.size.map(|cells| cells as f64 * self.conditions().dx_m);
        self.setting.turn.point(size_m, point_m)
    }

    /// The grid.
    pub fn grid(&self) -> Grid {
        let [nx, ny] = self.walls.size();
        let Conditions { dx_m, dt_s, .. } = *self.conditions();
        Grid { nx, ny, dx_m, dt_s }
    }

    /// Its Courant number.
    pub fn courant(&self) -> f64 {
        self.conditions().courant()
    }

    /// The scheme as it is computed: with its coefficients rounded ([`Scheme::weights`]), which turns the phase of a
    /// wave by up to 3e-7 a step.
    pub fn polynomial(&self) -> Polynomial {
        let courant = self.courant();
        let weights = self.scheme.weights(courant);
        Polynomial {
            courant,
            linear: f64::from(weights.linear),
            square: f64::from(weights.square),
            mixed: f64::from(weights.mixed),
            cube: f64::from(weights.cube),
            cross: f64::from(weights.cross),
        }
    }

    /// All that is simulated.
    pub fn domain(&self) -> Domain {
        Domain {
            grid: self.grid(),
            medium: self.conditions().medium,
            scheme: self.scheme,
            spread: self.spread,
            layer_cells: self.layer_cells,
            walls: self.walls.clone(),
        }
    }

    /// A silent field on one thread.
    pub fn field(&self) -> FastField {
        let setup = FieldSetup::new(
            &self.grid(),
            &self.conditions().medium,
            self.scheme,
            self.layer_cells,
            &self.walls,
        );
        FastField::new(setup, 1)
    }

    /// A source of a strength in m^2/s and a receiver for `steps` steps.
    pub fn drive(
        &self,
        source: Path<'_>,
        receiver: Path<'_>,
        strength: &dyn Fn(f64) -> f64,
        steps: usize,
    ) -> MovingPair {
        let dt_s = self.conditions().dt_s;
        let table = |path: Path<'_>| -> Vec<[f64; 2]> {
            let times_s = (0..=steps).map(|n| n as f64 * dt_s);
            times_s.map(|t_s| self.on_grid(path(t_s))).collect()
        };
        let at = move |t_s: f64| ((t_s / dt_s).round() as usize).min(steps);
        let (source, receiver) = (table(source), table(receiver));
        let strength: Vec<f64> = (0..=steps).map(|n| strength(n as f64 * dt_s)).collect();
        let [source, receiver] =
            [source, receiver].map(|table| Box::new(move |t_s: f64| table[at(t_s)]));
        MovingPair::new(
            &self.domain(),
            source,
            receiver,
            Box::new(move |t_s| strength[at(t_s)]),
            false,
        )
    }

    /// `steps` steps with a source at rest.
    pub fn sounding(
        &self,
        source_m: [f64; 2],
        strength: &dyn Fn(f64) -> f64,
        steps: usize,
    ) -> Vec<StepForcing> {
        let mut drive = self.drive(&|_| source_m, &|_| source_m, strength, steps);
        (0..steps as u64).map(|step| drive.forcing(step)).collect()
    }

    /// `steps` steps without a source.
    pub fn silence(&self, steps: usize) -> Vec<StepForcing> {
        let [nx, ny] = self.size;
        self.sounding(self.centre_m(nx / 2, ny / 2), &|_| 0.0, steps)
    }

    /// Pressure at the receiver after each of `steps` steps; entry `n` is at time `(n + 1) dt`.
    ///
    /// # Errors
    /// When the field becomes non-finite.
    pub fn run(
        &self,
        source: Path<'_>,
        receiver: Path<'_>,
        strength: &dyn Fn(f64) -> f64,
        steps: usize,
    ) -> Result<Vec<f64>, Error> {
        let drive = self.drive(source, receiver, strength, steps);
        let options = SimulationOptions {
            threads: 1,
            ..SimulationOptions::default()
        };
        let dt_s = self.conditions().dt_s;
        let duration_s = steps as f64 * dt_s;
        // The field is measured, not the signal.
        let (rate_hz, band_hz) = (1.0 / (3.0 * dt_s), 0.15 / dt_s);
        let domain = self.domain();
        let mut simulation =
            Simulation::from_parts(domain, drive, duration_s, rate_hz, band_hz, &options)?;
        simulation.run(&mut |_, _| Flow::Continue)?;
        Ok(simulation.received()[1..=steps]
            .iter()
            .map(|&p| f64::from(p))
            .collect())
    }

    /// Time of entry `n` of [`Rig::run`].
    pub fn time_s(&self, n: usize) -> f64 {
        (n + 1) as f64 * self.conditions().dt_s
    }

    /// A source on a path, exactly, at the times of [`Rig::run`].
    pub fn exact(&self, source: &Monopole<'_>, receiver: Path<'_>, steps: usize) -> Vec<f64> {
        let times_s = (0..steps).map(|n| self.time_s(n));
        times_s
            .map(|t_s| source.pressure(receiver(t_s), t_s))
            .collect()
    }

    /// Centre of a cell of the layout in metres.
    pub fn centre_m(&self, ix: usize, iy: usize) -> [f64; 2] {
        [ix, iy].map(|index| (index as f64 + 0.5) * self.conditions().dx_m)
    }

    /// Fourier coefficient of a signal of [`Rig::run`] at a frequency, not normalised.
    pub fn line(&self, signal: &[f64], frequency_hz: f64) -> Complex<f64> {
        signal
            .iter()
            .enumerate()
            .map(|(n, &p)| Complex::from_polar(p, -TAU * frequency_hz * self.time_s(n)))
            .sum()
    }
}

/// A standing wave after a while.
#[derive(Debug, Clone, PartialEq)]
pub struct Swing {
    /// Its amplitude in the field now, over that at the start.
    pub amplitude: f64,
    /// Its phase now, -pi to pi.
    pub turned_rad: f64,
    /// The field, `[iy, ix]`.
    pub pressure: Vec<f32>,
}

impl Rig {
    /// Runs a field that starts as the standing wave `shape`, in the grid's order ([`Rig::cells`]), at its
    /// largest, of `omega_dt` radians a step.
    pub fn swing(&self, shape: &[f64], omega_dt: f64, steps: usize) -> Swing {
        let mut field = self.field();
        let blank = field.state();
        field.set_state(&FieldState {
            pressure: shape.iter().map(|&p| p as f32).collect(),
            previous: shape.iter().map(|&p| (p * omega_dt.cos()) as f32).collect(),
            ..blank
        });
        field.advance(&self.silence(steps), &mut Vec::new());
        let state = field.state();
        let areas = self.walls.areas();
        let size: f64 = shape.iter().zip(&areas).map(|(p, area)| p * p * area).sum();
        let part = |pressure: &[f32]| -> f64 {
            let cells = pressure.iter().zip(shape).zip(&areas);
            let products = cells.map(|((&p, shape), area)| f64::from(p) * shape * area);
            products.sum::<f64>() / size
        };
        let (amplitude, before) = (part(&state.pressure), part(&state.previous));
        Swing {
            amplitude,
            turned_rad: ((before - amplitude * omega_dt.cos()) / omega_dt.sin()).atan2(amplitude),
            pressure: state.pressure,
        }
    }
}

/// An angle as one of -pi to pi.
pub fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

/// Root of the sum of squares.
pub fn norm(signal: &[f64]) -> f64 {
    signal.iter().map(|p| p * p).sum::<f64>().sqrt()
}

/// Entry by entry.
pub fn difference(one: &[f64], other: &[f64]) -> Vec<f64> {
    one.iter().zip(other).map(|(a, b)| a - b).collect()
}

/// Ratio in decibels.
pub fn decibels(ratio: f64) -> f64 {
    20.0 * ratio.log10()
}

/// Echoes in a recording on a path of a scene, in Pa: `recorded` takes the signal from the finished run, with walls and
/// without.
///
/// # Errors
/// When the scene has no such path, or a field becomes non-finite.
pub fn echoes(
    scene: &Scene,
    path: &str,
    waveform: &PeriodicWaveform,
    recorded: impl Fn(&Simulation) -> Vec<f32>,
) -> Result<Vec<f64>, Error> {
    let run = |free_field: bool| -> Result<Vec<f64>, Error> {
        let options = SimulationOptions {
            free_field,
            threads: 1,
            ..SimulationOptions::default()
        };
        let mut simulation = Simulation::new(scene, path, waveform, &options)?;
        simulation.run(&mut |_, _| Flow::Continue)?;
        Ok(recorded(&simulation).into_iter().map(f64::from).collect())
    };
    Ok(difference(&run(false)?, &run(true)?))
}
