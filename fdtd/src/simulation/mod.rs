//! A drive through a scene: the moving pair on the field, step after step, to a microphone signal.

mod checkpoint;
mod domain;
mod flow;
mod moving_pair;
mod options;
mod segment_planner;
mod segments;
mod stepped_field;
mod watch;

pub use domain::Domain;
pub use flow::{Flow, Outcome, Progress};
pub use moving_pair::{MovingPair, SOURCE_STRENGTH_M2PS};
pub use options::SimulationOptions;
pub use stepped_field::{Places, SteppedField};

use crate::decimate::Decimator;
use crate::error::Error;
use crate::field::{FastField, Field, FieldState, ReferenceField, StepForcing};
use crate::scene::Scene;
use crate::waveform::PeriodicWaveform;

use flow::Rhythm;
use segment_planner::cheapest_plan;
use segments::SegmentPlan;
use watch::{FieldView, Watch};

/// Steps of a drive up to which its small numbers are set to zero ([`crate::field::flushes_subnormals`]): 0.8 s on the
/// papers' grid. In a longer one the start, the only time at which there are subnormal numbers, is less than a
/// thousandth, and flushing steps would cost more than they save.
const MOST_FLUSHED_STEPS: u64 = 100_000;

/// Most steps between two calls of the observer.
const CHUNK: u64 = 256;

/// A field with its moving source and receiver.
pub struct Simulation {
    domain: Domain,
    plan: SegmentPlan,
    /// Index of the segment that `field` belongs to.
    segment: usize,
    field: Box<dyn Field>,
    pair: MovingPair,
    /// Silence at time 0, then microphone pressure after each step of each segment, warm-ups included.
    received: Vec<f32>,
    /// Number of samples of the signal, at `decimator`'s rate.
    samples: usize,
    decimator: Decimator,
    threads: usize,
    reference_engine: bool,
    /// Lower left corner of the domain in the scene, metres.
    origin_m: [f64; 2],
    /// Times at which the observer is called in addition.
    looks: Option<Rhythm>,
    watch: Watch,
}

/// Duration and sampling of the signal of a run.
struct SignalSpec {
    duration_s: f64,
    sample_rate_hz: f64,
    band_hz: f64,
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
        let mut domain = Domain::of(scene, options)?;
        let duration_s = path.duration_s();
        let points = |t| {
            [
                path.point_at(t, robot.loudspeaker_offset_m),
                path.point_at(t, robot.microphone_offset_m),
            ]
        };
        let mut origin_m = [0.0; 2];
        if options.free_field {
            origin_m = domain.crop(duration_s, &points);
        }
        let shift = move |p: [f64; 2]| [p[0] - origin_m[0], p[1] - origin_m[1]];
        let (path_a, path_b, waveform) = (path.clone(), path.clone(), waveform.clone());
        let (stamped, middle_s) = (options.stamped, 0.5 * duration_s);
        let pair = MovingPair::new(
            &domain,
            Box::new(move |t| shift(path_a.point_at(t, robot.loudspeaker_offset_m))),
            Box::new(move |t| shift(path_b.point_at(t, robot.microphone_offset_m))),
            Box::new(move |t| {
                let stamp = if stamped { t - middle_s } else { 1.0 };
                stamp * SOURCE_STRENGTH_M2PS * waveform.value(t)
            }),
            robot.loudspeaker_offset_m == robot.microphone_offset_m,
        );
        let signal = SignalSpec {
            duration_s,
            sample_rate_hz: scene.sample_rate_hz,
            band_hz: scene.waveform.band_hz[1],
        };
        let simulation = Self::build(domain, pair, &signal, options, |domain, steps| {
            match (options.whole_domain, options.free_field) {
                (true, _) => SegmentPlan::whole(domain, steps),
                (false, true) => cheapest_plan(domain, steps, &|t| points(t).map(shift)),
                (false, false) => SegmentPlan::cropped(domain, steps, duration_s, &points),
            }
        })?;
        Ok(Self {
            origin_m,
            ..simulation
        })
    }

    /// A run from its parts: `duration_s` seconds of `pair` in `domain`, sampled at `sample_rate_hz` up to `band_hz`.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the rates do not fit (see [`Decimator::new`]).
    ///
    /// # Panics
    /// When the domain's step is unstable or its layers meet; see [`crate::field::FieldSetup::new`].
    pub fn from_parts(
        domain: Domain,
        pair: MovingPair,
        duration_s: f64,
        sample_rate_hz: f64,
        band_hz: f64,
        options: &SimulationOptions,
    ) -> Result<Self, Error> {
        let signal = SignalSpec {
            duration_s,
            sample_rate_hz,
            band_hz,
        };
        Self::build(domain, pair, &signal, options, SegmentPlan::whole)
    }

    /// Takes flushing steps ([`crate::field::flushes_subnormals`]) from now on, however long the drive is: for
    /// measurements of speed, to which the start of a drive is all that there is. The signal changes by roundings.
    pub fn flush_subnormals(&mut self) {
        self.pair.set_flushing(true);
    }

    /// Calls the observer of [`Simulation::run`] at every multiple of `period_s` seconds of the drive too, to the
    /// nearest step; there [`Simulation::is_look`] says so.
    pub fn look_every(&mut self, period_s: f64) {
        self.looks = Some(Rhythm::new(period_s, self.domain.grid.dt_s));
    }

    /// Whether the drive has come to a time of [`Simulation::look_every`], past the warm-up of a free field's segment.
    pub fn is_look(&self) -> bool {
        self.is_listening()
            && self
                .looks
                .is_some_and(|looks| looks.is_on(self.drive_step()))
    }

    /// A run whose segments `plan` makes of the domain and the number of steps.
    fn build(
        domain: Domain,
        mut pair: MovingPair,
        signal: &SignalSpec,
        options: &SimulationOptions,
        plan: impl FnOnce(&Domain, u64) -> SegmentPlan,
    ) -> Result<Self, Error> {
        let SignalSpec {
            duration_s,
            sample_rate_hz,
            band_hz,
        } = *signal;
        let dt_s = domain.grid.dt_s;
        let decimator = Decimator::new(1.0 / dt_s, sample_rate_hz, band_hz)?;
        // The decimation filter looks a little beyond the last sample.
        let steps = (duration_s / dt_s).round() as u64 + decimator.reach() as u64;
        let plan = plan(&domain, steps);
        let threads = match options.threads {
            0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            threads => threads,
        };
        let field = field(&domain, &plan, 0, threads, options.reference_engine);
        pair.enter(&plan.segments[0]);
        pair.set_flushing(steps <= MOST_FLUSHED_STEPS);
        Ok(Self {
            domain,
            plan,
            segment: 0,
            field,
            pair,
            received: vec![0.0],
            samples: (duration_s * sample_rate_hz + 1e-6).floor() as usize,
            decimator,
            threads,
            reference_engine: options.reference_engine,
            origin_m: [0.0; 2],
            looks: None,
            watch: Watch::default(),
        })
    }

    /// Goes on with the silent field of a segment.
    fn enter(&mut self, segment: usize) {
        self.segment = segment;
        self.field = field(
            &self.domain,
            &self.plan,
            segment,
            self.threads,
            self.reference_engine,
        );
        self.pair.enter(&self.plan.segments[segment]);
    }

    /// Runs to the end, or until the observer says stop; `observer` is called every 256 steps or sooner.
    ///
    /// # Errors
    /// [`Error::Unstable`] when the field has values that no source can have made.
    pub fn run(
        &mut self,
        observer: &mut dyn FnMut(Progress, &Self) -> Flow,
    ) -> Result<Outcome, Error> {
        let steps_total = self.steps_total();
        while self.step() < steps_total {
            let segment = self.plan.index_at(self.step());
            if segment != self.segment {
                self.enter(segment);
            }
            let first = self.drive_step();
            let look = self.looks.map_or(u64::MAX, |looks| looks.next_after(first));
            let [due, of_energy] = self.watch.is_due(self.step());
            let before = of_energy.then(|| self.field.state());
            let chunk = if of_energy { 1 } else { CHUNK };
            let end = self.plan.segments[segment].to.min(first + chunk).min(look);
            let steps: Vec<StepForcing> =
                (first..end).map(|step| self.pair.forcing(step)).collect();
            self.field.advance(&steps, &mut self.received);
            self.watch.follow(&steps);
            self.check_samples(first)?;
            if due || self.step() == steps_total {
                self.look_at_field(before.as_ref())?;
            }
            let progress = Progress {
                step: self.step(),
                steps_total,
            };
            match observer(progress, self) {
                Flow::Continue => {}
                Flow::OnThreads(threads) => {
                    self.threads = threads.max(1);
                    self.field.set_threads(self.threads);
                }
                Flow::Stop if self.step() < steps_total => return Ok(Outcome::Stopped),
                Flow::Stop => {}
            }
        }
        Ok(Outcome::Finished)
    }

    /// Checks the field at once where samples of it, or the microphone, exceed the source's bounds.
    fn check_samples(&mut self, first: u64) -> Result<(), Error> {
        let last = self.drive_step();
        let received = &self.received[self.received.len() - (last - first) as usize..];
        let sampled = (0..4).all(|k| {
            self.field
                .row_is_finite((last / CHUNK) as usize * 4 + k * 251)
        });
        let window = self.plan.segments[self.segment].window;
        let most = self.watch.most(last, window.nx * window.ny);
        if sampled
            && received
                .iter()
                .all(|p| p.is_finite() && f64::from(p.abs()) <= most)
        {
            return Ok(());
        }
        self.look_at_field(None)
    }

    /// Checks the field against the source's bounds; `before` is the field a step ago.
    fn look_at_field(&mut self, before: Option<&FieldState>) -> Result<(), Error> {
        let view = FieldView {
            domain: &self.domain,
            window: self.plan.segments[self.segment].window,
            origin_m: self.origin_m,
            steps: self.drive_step(),
        };
        let step = self.step();
        self.watch.look(step, before, &self.field.state(), &view)
    }

    /// Steps done, warm-ups included.
    pub fn step(&self) -> u64 {
        self.received.len() as u64 - 1
    }

    /// Steps of the whole run, warm-ups included.
    pub fn steps_total(&self) -> u64 {
        self.plan.steps()
    }

    /// Steps of the drive that the field has come to.
    fn drive_step(&self) -> u64 {
        let segment = &self.plan.segments[self.segment];
        segment.start + (self.step() - segment.before)
    }

    /// Time of the drive that the field has come to, seconds. Goes back when a segment of a free field warms up.
    pub fn time_s(&self) -> f64 {
        self.drive_step() as f64 * self.domain.grid.dt_s
    }

    /// Whether the present sample belongs to the signal, not to the warm-up of a segment of a free field.
    pub fn is_listening(&self) -> bool {
        self.drive_step() > self.plan.segments[self.segment].from
    }

    /// Cells of the domain; of the largest segment's for a free-field run.
    pub fn cells(&self) -> usize {
        let window = self.plan.largest();
        window.nx * window.ny
    }

    /// The domain that is simulated; of a free-field run that around the whole drive.
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Where in the scene the domain begins, `[x, y]` in metres: the origin, but for a free-field run, whose domain is
    /// cropped to the drive.
    pub fn origin_m(&self) -> [f64; 2] {
        self.origin_m
    }

    /// Threads in use.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Memory that the run holds, in bytes: two levels, the layers, the mask and the received signal.
    pub fn memory_bytes(&self) -> u64 {
        let window = self.plan.largest();
        let layers = 6 * self.domain.layer_cells * (window.nx + window.ny);
        let cells = window.nx * window.ny;
        (4 * (2 * cells + layers) + 2 * cells) as u64 + 4 * (self.steps_total() + 1)
    }

    /// Pressure in Pa now, in the whole domain: columns, rows, and `[iy, ix]` values; zero outside of a segment's
    /// window.
    pub fn pressure_frame(&self) -> (usize, usize, Vec<f32>) {
        let window = self.plan.segments[self.segment].window;
        let (nx, ny) = (self.domain.grid.nx, self.domain.grid.ny);
        (nx, ny, window.place(&self.field.state().pressure, nx, ny))
    }

    /// Microphone pressure in Pa at the field's rate so far; entry `n` is at time `n dt`.
    pub fn received(&self) -> Vec<f32> {
        self.plan.join(&self.received)
    }

    /// Microphone signal in Pa, anti-aliased and at the sampling rate; sample `k` is at time `k / f_s`. Complete once
    /// the run has finished.
    pub fn signal(&self) -> Vec<f32> {
        let mut signal = self.decimator.apply(&self.received());
        signal.truncate(self.samples);
        signal
    }
}

/// The silent field of a segment.
fn field(
    domain: &Domain,
    plan: &SegmentPlan,
    segment: usize,
    threads: usize,
    reference_engine: bool,
) -> Box<dyn Field> {
    let setup = plan.setup(domain, segment);
    if reference_engine {
        Box::new(ReferenceField::new(setup))
    } else {
        Box::new(FastField::new(setup, threads))
    }
}
