//! The rig of all laws: a grid with a source and a receiver on any paths, as the simulation runs it.

use crate::Error;
use crate::exact::monopole::Monopole;
use crate::field::{FastField, Field, FieldSetup, FieldState, StepForcing};
use crate::grid::{Grid, Medium};
use crate::scene::Scene;
use crate::scheme::Scheme;
use crate::simulation::{Domain, Drive, Flow, Simulation, SimulationOptions};
use crate::spread::Spread;
use crate::walls::{SolidMask, WallCells};
use crate::waveform::PeriodicWaveform;
use rustfft::num_complex::Complex;
use std::f64::consts::{PI, TAU};

/// The papers' medium.
pub const AIR: Medium = Medium {
    c_mps: 340.0,
    rho_kgpm3: 1.293,
};

/// The papers' grid step.
pub const DX_M: f64 = 0.005;

/// The papers' time step.
pub const DT_S: f64 = 1.0 / 120_000.0;

/// A position in metres at a time in seconds.
pub type Path<'a> = &'a dyn Fn(f64) -> [f64; 2];

/// A grid, its scheme, its layer and its walls.
#[derive(Clone)]
pub struct Rig {
    /// Scheme.
    pub scheme: Scheme,
    /// Spreading of source and receiver.
    pub spread: Spread,
    /// Width of the absorbing layers.
    pub layer_cells: usize,
    /// Rigid walls.
    pub walls: WallCells,
}

impl Rig {
    /// An empty grid of `nx` by `ny` cells with the papers' step and a layer of 20 cells.
    pub fn open(scheme: Scheme, nx: usize, ny: usize) -> Self {
        Self {
            scheme,
            spread: Spread::Kaiser12,
            layer_cells: 20,
            walls: WallCells::open(nx, ny),
        }
    }

    /// The grid with the cells solid whose indices `(ix, iy)` satisfy `solid`.
    pub fn with_walls(mut self, solid: impl Fn(usize, usize) -> bool) -> Self {
        let [nx, ny] = self.walls.size();
        let mut mask = SolidMask::open(nx, ny);
        for (cell, value) in mask.cells.iter_mut().enumerate() {
            *value = solid(cell % nx, cell / nx);
        }
        self.walls = mask.into();
        self
    }

    /// The grid.
    pub fn grid(&self) -> Grid {
        let [nx, ny] = self.walls.size();
        Grid {
            nx,
            ny,
            dx_m: DX_M,
            dt_s: DT_S,
        }
    }

    /// Its Courant number.
    pub fn courant(&self) -> f64 {
        self.grid().courant(&AIR)
    }

    /// All that is simulated.
    pub fn domain(&self) -> Domain {
        Domain {
            grid: self.grid(),
            medium: AIR,
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
            &AIR,
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
    ) -> Drive {
        let table = |path: Path<'_>| -> Vec<[f64; 2]> {
            (0..=steps).map(|n| path(n as f64 * DT_S)).collect()
        };
        let at = move |t_s: f64| ((t_s / DT_S).round() as usize).min(steps);
        let (source, receiver) = (table(source), table(receiver));
        let strength: Vec<f64> = (0..=steps).map(|n| strength(n as f64 * DT_S)).collect();
        let [source, receiver] =
            [source, receiver].map(|table| Box::new(move |t_s: f64| table[at(t_s)]));
        Drive::new(
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
        let [nx, ny] = self.walls.size();
        self.sounding(centre_m(nx / 2, ny / 2), &|_| 0.0, steps)
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
        let duration_s = steps as f64 * DT_S;
        let mut simulation =
            Simulation::from_parts(self.domain(), drive, duration_s, 40e3, 19e3, &options)?;
        simulation.run(&mut |_, _| Flow::Continue)?;
        Ok(simulation.received()[1..=steps]
            .iter()
            .map(|&p| f64::from(p))
            .collect())
    }
}

/// A standing wave after a while.
#[derive(Debug, Clone, PartialEq)]
pub struct Swing {
    /// What the field has of it now, over what it started with.
    pub amplitude: f64,
    /// The phase that it has come to, -pi to pi.
    pub turned_rad: f64,
    /// The field, `[iy, ix]`.
    pub pressure: Vec<f32>,
}

impl Rig {
    /// Lets a field swing that starts as the standing wave `shape`, `[iy, ix]`, at its largest, of `omega_dt` radians a step.
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

/// Time of entry `n` of [`Rig::run`].
pub fn time_s(n: usize) -> f64 {
    (n + 1) as f64 * DT_S
}

/// A source on a path, exactly, at the times of [`Rig::run`].
pub fn exact(source: &Monopole<'_>, receiver: Path<'_>, steps: usize) -> Vec<f64> {
    (0..steps)
        .map(|n| source.pressure(receiver(time_s(n)), time_s(n)))
        .collect()
}

/// Centre of a cell in metres.
pub fn centre_m(ix: usize, iy: usize) -> [f64; 2] {
    [(ix as f64 + 0.5) * DX_M, (iy as f64 + 0.5) * DX_M]
}

/// Fourier coefficient of a signal of [`Rig::run`] at a frequency, not normalised.
pub fn line(signal: &[f64], frequency_hz: f64) -> Complex<f64> {
    signal
        .iter()
        .enumerate()
        .map(|(n, &p)| Complex::from_polar(p, -TAU * frequency_hz * time_s(n)))
        .sum()
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

/// What walls add to a recording on a path of a scene, in Pa: `heard` takes the signal from the finished run, with walls and without.
///
/// # Errors
/// When the scene has no such path, or a field becomes non-finite.
pub fn echoes(
    scene: &Scene,
    path: &str,
    waveform: &PeriodicWaveform,
    heard: impl Fn(&Simulation) -> Vec<f32>,
) -> Result<Vec<f64>, Error> {
    let run = |free_field: bool| -> Result<Vec<f64>, Error> {
        let options = SimulationOptions {
            free_field,
            threads: 1,
            ..SimulationOptions::default()
        };
        let mut simulation = Simulation::new(scene, path, waveform, &options)?;
        simulation.run(&mut |_, _| Flow::Continue)?;
        Ok(heard(&simulation).into_iter().map(f64::from).collect())
    };
    Ok(difference(&run(false)?, &run(true)?))
}
