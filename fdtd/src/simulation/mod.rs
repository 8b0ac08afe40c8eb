//! A drive through a scene: moving source and receiver on the field, step after step, to a microphone signal.

mod checkpoint;
mod drive;

use std::path::Path;

pub use drive::{Drive, SOURCE_STRENGTH_M2PS};

use crate::Error;
use crate::decimate::Decimator;
use crate::field::{FastField, Field, FieldSetup, ReferenceField, StepForcing};
use crate::grid::{Grid, Medium};
use crate::scene::Scene;
use crate::scheme::Scheme;
use crate::spread::Spread;
use crate::walls::{Opening, WallCells, WallModel};
use crate::waveform::PeriodicWaveform;

/// Steps between two calls of the observer.
const CHUNK: u64 = 256;

/// Cells kept between a free-field drive and the absorbing layer.
const CLEARANCE_CELLS: usize = 12;

/// Choices of a run that are not the scene's.
#[derive(Debug, Clone, Default)]
pub struct SimulationOptions {
    /// Scheme instead of the scene's.
    pub scheme: Option<Scheme>,
    /// Spreading kernel instead of the scene's.
    pub spread: Option<Spread>,
    /// How walls become cells, instead of the scene's way.
    pub wall_model: Option<WallModel>,
    /// Threads; 0 for all cores.
    pub threads: usize,
    /// Without walls, in a domain cropped to the drive and its absorbing layer.
    pub free_field: bool,
    /// Source strength times the time since the middle of the drive, which tells travel times ([`crate::medium::absorbed`]).
    pub stamped: bool,
    /// Use the plain engine, the oracle of the fast one.
    pub reference_engine: bool,
}

/// A domain to simulate, in its parts: what [`Simulation::new`] makes of a scene.
#[derive(Debug, Clone)]
pub struct Domain {
    /// Grid and step.
    pub grid: Grid,
    /// The air.
    pub medium: Medium,
    /// Scheme.
    pub scheme: Scheme,
    /// Spreading kernel.
    pub spread: Spread,
    /// Width of the absorbing layers in cells.
    pub layer_cells: usize,
    /// Rigid walls.
    pub walls: WallCells,
}

/// How far a run is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Steps done.
    pub step: u64,
    /// Steps in all.
    pub steps_total: u64,
}

/// What an observer wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// Go on.
    Continue,
    /// Stop after this step; the run can be continued.
    Stop,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// All steps are done.
    Finished,
    /// The observer stopped it.
    Stopped,
}

/// A field with its moving source and receiver.
pub struct Simulation {
    domain: Domain,
    field: Box<dyn Field>,
    drive: Drive,
    /// Microphone pressure at the field's rate; entry `n` is at time `n dt`.
    received: Vec<f32>,
    steps_total: u64,
    /// Samples asked for, at `decimator`'s rate.
    samples: usize,
    decimator: Decimator,
    threads: usize,
}

impl Simulation {
    /// The drive `path_name` of a scene with `waveform` from its loudspeaker.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the scene has no such path or its rates do not fit.
    pub fn new(
        scene: &Scene,
        path_name: &str,
        waveform: &PeriodicWaveform,
        options: &SimulationOptions,
    ) -> Result<Self, Error> {
        let path = scene.path(path_name)?.clone();
        let robot = scene.robot;
        let mut domain = Domain {
            grid: scene.grid,
            medium: scene.medium,
            scheme: options.scheme.unwrap_or(scene.scheme),
            spread: options.spread.unwrap_or(scene.spread),
            layer_cells: scene.layer_cells,
            walls: options
                .wall_model
                .unwrap_or(scene.wall_model)
                .cells(&scene.grid, &scene.walls),
        };
        let courant = domain.grid.courant(&domain.medium);
        if courant > domain.scheme.max_courant() {
            let largest = domain.scheme.max_courant() * domain.grid.dx_m / domain.medium.c_mps;
            return Err(Error::invalid(
                &scene.name,
                "grid.dt_s",
                format!(
                    "{:e} s is over the stability limit of {}",
                    domain.grid.dt_s, domain.scheme
                ),
                format!("the largest stable step is {largest:e} s"),
            ));
        }
        let duration_s = path.duration_s();
        let mut origin_m = [0.0; 2];
        if options.free_field {
            origin_m = crop(&mut domain, duration_s, &|t| {
                [
                    path.point_at(t, robot.loudspeaker_offset_m),
                    path.point_at(t, robot.microphone_offset_m),
                ]
            });
        }
        let shift = move |p: [f64; 2]| [p[0] - origin_m[0], p[1] - origin_m[1]];
        let (path_a, path_b, waveform) = (path.clone(), path, waveform.clone());
        let (stamped, middle_s) = (options.stamped, 0.5 * duration_s);
        let drive = Drive::new(
            &domain,
            Box::new(move |t| shift(path_a.point_at(t, robot.loudspeaker_offset_m))),
            Box::new(move |t| shift(path_b.point_at(t, robot.microphone_offset_m))),
            Box::new(move |t| {
                let stamp = if stamped { t - middle_s } else { 1.0 };
                stamp * SOURCE_STRENGTH_M2PS * waveform.value(t)
            }),
            robot.loudspeaker_offset_m == robot.microphone_offset_m,
        );
        Self::from_parts(
            domain,
            drive,
            duration_s,
            scene.sample_rate_hz,
            scene.waveform.band_hz[1],
            options,
        )
    }

    /// A run from its parts: `duration_s` seconds of `drive` in `domain`, heard at `sample_rate_hz` up to `band_hz`.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the rates do not fit (see [`Decimator::new`]).
    ///
    /// # Panics
    /// When the domain's step is unstable or its layers meet; see [`FieldSetup::new`].
    pub fn from_parts(
        domain: Domain,
        drive: Drive,
        duration_s: f64,
        sample_rate_hz: f64,
        band_hz: f64,
        options: &SimulationOptions,
    ) -> Result<Self, Error> {
        let decimator = Decimator::new(1.0 / domain.grid.dt_s, sample_rate_hz, band_hz)?;
        let setup = FieldSetup::new(
            &domain.grid,
            &domain.medium,
            domain.scheme,
            domain.layer_cells,
            &domain.walls,
        );
        let threads = match options.threads {
            0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            threads => threads,
        };
        let field: Box<dyn Field> = if options.reference_engine {
            Box::new(ReferenceField::new(setup))
        } else {
            Box::new(FastField::new(setup, threads))
        };
        // The decimation filter looks a little beyond the last sample.
        let steps_total = (duration_s / domain.grid.dt_s).round() as u64 + decimator.reach() as u64;
        Ok(Self {
            domain,
            field,
            drive,
            received: vec![0.0],
            steps_total,
            samples: (duration_s * sample_rate_hz + 1e-6).floor() as usize,
            decimator,
            threads,
        })
    }

    /// Runs to the end, or until the observer says stop; `observer` is called about every 256 steps.
    ///
    /// # Errors
    /// [`Error::NonFinite`] as soon as the field is not finite any more.
    pub fn run(
        &mut self,
        observer: &mut dyn FnMut(Progress, &Self) -> Flow,
    ) -> Result<Outcome, Error> {
        while self.step() < self.steps_total {
            let first = self.step();
            let steps = self.forcing((self.steps_total - first).min(CHUNK));
            self.field.advance(&steps, &mut self.received);
            self.check_finite(first)?;
            let progress = Progress {
                step: self.step(),
                steps_total: self.steps_total,
            };
            if observer(progress, self) == Flow::Stop && self.step() < self.steps_total {
                return Ok(Outcome::Stopped);
            }
        }
        Ok(Outcome::Finished)
    }

    /// The next `count` steps of the drive.
    fn forcing(&mut self, count: u64) -> Vec<StepForcing> {
        let first = self.step();
        (first..first + count)
            .map(|step| self.drive.forcing(step))
            .collect()
    }

    fn check_finite(&self, first: u64) -> Result<(), Error> {
        let last = self.step();
        let heard = &self.received[first as usize + 1..];
        let sampled = (0..4).all(|k| {
            self.field
                .row_is_finite((last / CHUNK) as usize * 4 + k * 251)
        });
        if sampled && heard.iter().all(|p| p.is_finite()) {
            return Ok(());
        }
        Err(Error::NonFinite {
            first_step: first,
            last_step: last,
            time_s: last as f64 * self.domain.grid.dt_s,
        })
    }

    /// Steps done.
    pub fn step(&self) -> u64 {
        self.received.len() as u64 - 1
    }

    /// Steps of the whole run.
    pub fn steps_total(&self) -> u64 {
        self.steps_total
    }

    /// Cells of the domain (of the cropped one for a free-field run).
    pub fn cells(&self) -> usize {
        self.domain.grid.cells()
    }

    /// The domain that is simulated.
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Threads in use.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Memory that the run holds, in bytes: two levels, the layers, the mask and the received signal.
    pub fn memory_bytes(&self) -> u64 {
        let grid = &self.domain.grid;
        let layers = 6 * self.domain.layer_cells * (grid.nx + grid.ny);
        (4 * (2 * grid.cells() + layers) + 2 * grid.cells()) as u64 + 4 * (self.steps_total + 1)
    }

    /// Pressure in Pa now: columns, rows, and `[iy, ix]` values.
    pub fn pressure_frame(&self) -> (usize, usize, Vec<f32>) {
        (
            self.domain.grid.nx,
            self.domain.grid.ny,
            self.field.state().pressure,
        )
    }

    /// Microphone pressure in Pa at the field's rate so far; entry `n` is at time `n dt`.
    pub fn received(&self) -> &[f32] {
        &self.received
    }

    /// Microphone signal in Pa, anti-aliased and at the sampling rate; sample `k` is at time `k / f_s`. Complete once the
    /// run has finished.
    pub fn signal(&self) -> Vec<f32> {
        let mut signal = self.decimator.apply(&self.received);
        signal.truncate(self.samples);
        signal
    }

    /// Writes a checkpoint (to a temporary name, then renamed).
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be written.
    pub fn save_checkpoint(&self, file: &Path) -> Result<(), Error> {
        checkpoint::save(
            file,
            &self.fingerprint(),
            &self.received,
            &self.field.state(),
        )
    }

    /// Continues from a checkpoint: the run then gives the same bytes as one without an interruption.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be read, [`Error::Checkpoint`] when it is damaged or belongs to other inputs.
    pub fn load_checkpoint(&mut self, file: &Path) -> Result<(), Error> {
        let (received, state) = checkpoint::load(file, &self.fingerprint())?;
        self.received = received;
        self.field.set_state(&state);
        Ok(())
    }

    /// Everything that determines the run, in one line.
    fn fingerprint(&self) -> String {
        let Domain {
            grid,
            medium,
            scheme,
            spread,
            layer_cells,
            walls,
        } = &self.domain;
        let solid = walls
            .solid()
            .cells
            .iter()
            .enumerate()
            .filter(|(_, solid)| **solid)
            .map(|(cell, _)| cell as u64);
        let parts = walls.partial().flat_map(|(cell, opening)| {
            let Opening { area, west, south } = *opening;
            [cell as u64]
                .into_iter()
                .chain([area, west, south].map(f64::to_bits))
        });
        let surfaces = walls.loads().iter().flat_map(|load| {
            let [ix, iy] = load.cell.map(|at| at as u64);
            let numbers = [load.impedance_pasm, load.length, load.slope, load.open];
            [ix, iy, load.axis as u64, load.inward.cast_unsigned() as u64]
                .into_iter()
                .chain(numbers.map(f64::to_bits))
        });
        let walls = checkpoint::digest(solid.chain(parts).chain(surfaces));
        let drive = checkpoint::digest((0..=64).flat_map(|k| {
            self.drive
                .sample(k as f64 / 64.0 * self.steps_total as f64 * grid.dt_s)
                .map(f64::to_bits)
        }));
        format!(
            "{grid:?} {medium:?} {scheme} {spread} layer {layer_cells} walls {walls:016x} drive {drive:016x} steps {}",
            self.steps_total
        )
    }
}

/// Crops an open domain to the drive, its clearance and the layer, and clears the walls; returns the new origin in
/// metres, a whole number of cells, so that points keep their place within a cell.
fn crop(domain: &mut Domain, duration_s: f64, points: &dyn Fn(f64) -> [[f64; 2]; 2]) -> [f64; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let instants = (duration_s / 0.005).ceil().max(1.0);
    for k in 0..=instants as usize {
        for point in points(duration_s * k as f64 / instants) {
            for (axis, x) in domain.grid.to_cells(point).into_iter().enumerate() {
                low[axis] = low[axis].min(x);
                high[axis] = high[axis].max(x);
            }
        }
    }
    let margin =
        domain.layer_cells.next_multiple_of(8) + CLEARANCE_CELLS + domain.spread.reach_cells();
    let first = low.map(|x| (x.floor() as usize).saturating_sub(margin));
    let grid = domain.grid;
    let end = [
        (high[0].ceil() as usize + margin).min(grid.nx),
        (high[1].ceil() as usize + margin).min(grid.ny),
    ];
    // Whole vectors make full use of the engine.
    domain.grid.nx = (end[0] - first[0]).next_multiple_of(8);
    domain.grid.ny = end[1] - first[1];
    domain.walls = WallCells::open(domain.grid.nx, domain.grid.ny);
    first.map(|cells| cells as f64 * grid.dx_m)
}
