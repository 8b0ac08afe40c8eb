//! A field that is stepped by hand, with any number of moving sources and receivers: the direct method of
//! [`MovingPair`](super::MovingPair) with places and strengths as arrays.

use super::domain::Domain;
use super::options::SimulationOptions;
use crate::error::Error;
use crate::field::{FastField, Field, Injection, ReferenceField, StepForcing, flushes_subnormals};
use crate::scene::Scene;
use crate::spread::{Stencil, TAPS};

/// Cells from a point to the grid's edge that its stencil needs.
const MARGIN_CELLS: f64 = (TAPS / 2) as f64;

/// Steps of which one call of the engine takes care.
const CHUNK: usize = 256;

/// Places of some points at every step: `[x, y]` in metres, in the scene.
#[derive(Debug, Clone, Copy)]
pub enum Places<'a> {
    /// The same at all steps, one for each point.
    Fixed(&'a [[f64; 2]]),
    /// Step after step, for each step one for each point: so many points.
    Moving(&'a [[f64; 2]], usize),
}

impl Places<'_> {
    fn count(self) -> usize {
        match self {
            Self::Fixed(places) => places.len(),
            Self::Moving(_, count) => count,
        }
    }

    fn at(self, step: usize, point: usize) -> [f64; 2] {
        match self {
            Self::Fixed(places) => places[point],
            Self::Moving(places, count) => places[step * count + point],
        }
    }

    fn check(self, what: &str, steps: usize, domain: &Domain) -> Result<(), Error> {
        let refuse = |place: usize, problem: String, remedy: String| {
            Err(Error::invalid(
                what,
                format!("place {place}"),
                problem,
                remedy,
            ))
        };
        let places = match self {
            Self::Fixed(places) => places,
            Self::Moving(places, count) => {
                if count.checked_mul(steps) != Some(places.len()) {
                    let problem = format!("{} places for {steps} steps of {count}", places.len());
                    return refuse(0, problem, "give one for each step and point".into());
                }
                places
            }
        };
        let grid = &domain.grid;
        let size = [grid.nx as f64, grid.ny as f64];
        for (number, place) in places.iter().enumerate() {
            let cells = grid.to_cells(*place);
            // Written so that NaN is refused.
            let inside = |axis: usize| {
                (MARGIN_CELLS..=size[axis] - 1.0 - MARGIN_CELLS).contains(&cells[axis])
            };
            if !(inside(0) && inside(1)) {
                let [x, y] = *place;
                let away = (MARGIN_CELLS + 0.5) * grid.dx_m;
                let [width, height] = grid.size_m();
                return refuse(
                    number,
                    format!("[{x}, {y}] m is not in the field"),
                    format!(
                        "give x from {away} to {} m and y from {away} to {} m",
                        width - away,
                        height - away
                    ),
                );
            }
        }
        Ok(())
    }
}

/// A field of a scene without its drives, from silence on.
///
/// ```
/// use fdtd::scene::Scene;
/// use fdtd::simulation::{Places, SimulationOptions, SteppedField};
///
/// let text = r#"{ "name": "open air", "grid": { "nx": 120, "ny": 100, "dx_m": 0.005, "dt_s": 8e-6 } }"#;
/// let scene = Scene::from_json(text, "open.json".as_ref())?;
/// let mut field = SteppedField::new(&scene, &SimulationOptions::default())?;
/// // A short pulse in the middle, heard 0.1 m to the right: 0.29 ms, 37 steps later.
/// let pulse: Vec<f64> = (0..80).map(|k| 1e-3 * (-((k as f64 - 12.0) / 4.0).powi(2)).exp()).collect();
/// let (source, receiver) = ([[0.3, 0.25]], [[0.4, 0.25]]);
/// let heard = field.run(&pulse, Places::Fixed(&source), Places::Fixed(&receiver))?;
/// let loudest = (0..80).max_by(|&a, &b| heard[a].total_cmp(&heard[b])).unwrap();
/// assert!((46..52).contains(&loudest), "{loudest}");
/// # Ok::<(), fdtd::Error>(())
/// ```
pub struct SteppedField {
    domain: Domain,
    field: Box<dyn Field>,
    /// `rho c^2 dt / (2 dx^2)`.
    gain: f64,
    step: u64,
    /// Contributions of each source at the level before the newest, and at the newest.
    recent: Vec<[Injection; 2]>,
}

impl SteppedField {
    /// The silent field of a scene's whole domain. Of the options scheme, spreading, wall model, threads, engine and
    /// `free_field` (no walls) count.
    ///
    /// # Errors
    /// As [`Scene::check`].
    pub fn new(scene: &Scene, options: &SimulationOptions) -> Result<Self, Error> {
        let mut scene = scene.clone();
        scene.scheme = options.scheme.unwrap_or(scene.scheme);
        scene.spread = options.spread.unwrap_or(scene.spread);
        scene.check(&format!("scene '{}'", scene.name))?;
        let domain = Domain::of(&scene, options)?;
        let setup = domain.setup();
        let threads = match options.threads {
            0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            threads => threads,
        };
        let (grid, medium) = (&domain.grid, &domain.medium);
        let stiffness = medium.rho_kgpm3 * medium.c_mps * medium.c_mps;
        Ok(Self {
            gain: stiffness * grid.dt_s / (2.0 * grid.dx_m * grid.dx_m),
            field: match options.reference_engine {
                true => Box::new(ReferenceField::new(setup)),
                false => Box::new(FastField::new(setup, threads)),
            },
            domain,
            step: 0,
            recent: Vec::new(),
        })
    }

    /// The domain.
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Steps taken so far.
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// Time of the newest pressure in seconds.
    pub fn time_s(&self) -> f64 {
        self.step as f64 * self.domain.grid.dt_s
    }

    /// The newest pressure in Pa, `[iy, ix]`.
    pub fn pressure(&self) -> Vec<f32> {
        self.field.state().pressure
    }

    /// Takes as many steps as there are strengths for each source, and returns what the receivers read after each
    /// step, in Pa, `[step, receiver]`.
    ///
    /// `strengths_m2ps` are source strengths in m^2/s, `[step, source]`: those at the instants that the steps lead to,
    /// the first one `dt` after the newest pressure. Sources are the same ones, in the same order, from call to call;
    /// further ones may be added at the end. A step with one source and at most one receiver gives the bytes of
    /// [`Simulation`](super::Simulation), many at a time; others are slower, each step by itself.
    ///
    /// # Errors
    /// [`Error::Invalid`] for places outside of the field or numbers that are not finite, before any step;
    /// [`Error::Unstable`] when the field turns not finite.
    pub fn run(
        &mut self,
        strengths_m2ps: &[f64],
        sources: Places<'_>,
        receivers: Places<'_>,
    ) -> Result<Vec<f32>, Error> {
        let count = sources.count();
        if count == 0 || !strengths_m2ps.len().is_multiple_of(count) {
            return Err(Error::invalid(
                "strengths",
                "length",
                format!("{} strengths for {count} sources", strengths_m2ps.len()),
                "give one for each step and source, and at least one source",
            ));
        }
        let most = f64::from(f32::MAX) / self.gain;
        let unusable = |q: &f64| !q.is_finite() || q.abs() >= most;
        if let Some(at) = strengths_m2ps.iter().position(unusable) {
            return Err(Error::invalid(
                "strengths",
                format!("number {at}"),
                format!("{} cannot be used", strengths_m2ps[at]),
                "give finite source strengths in m^2/s",
            ));
        }
        if count < self.recent.len() {
            return Err(Error::invalid(
                "sources",
                "count",
                format!("{count}, and there were {} before", self.recent.len()),
                "keep the sources from call to call; silence those that end",
            ));
        }
        let steps = strengths_m2ps.len() / count;
        sources.check("sources", steps, &self.domain)?;
        receivers.check("receivers", steps, &self.domain)?;
        self.meet(sources, steps);
        let mut received = Vec::with_capacity(steps * receivers.count());
        if count == 1 && receivers.count() <= 1 {
            self.run_pair(strengths_m2ps, sources, receivers, &mut received);
        } else {
            self.run_many(strengths_m2ps, sources, receivers, &mut received);
        }
        self.check_finite()?;
        Ok(received)
    }

    /// Sources that are heard of for the first time were silent until now.
    fn meet(&mut self, sources: Places<'_>, steps: usize) {
        if steps == 0 {
            return;
        }
        for point in self.recent.len()..sources.count() {
            let silent = Injection {
                stencil: self.stencil(sources.at(0, point)),
                amplitude: 0.0,
            };
            self.recent.push([silent; 2]);
        }
    }

    fn stencil(&self, place_m: [f64; 2]) -> Stencil {
        self.domain
            .spread
            .stencil(self.domain.grid.to_cells(place_m))
    }

    /// The contribution of a source to the step to the next level, and its counterpart two levels ago.
    fn injections(&mut self, source: usize, place_m: [f64; 2], strength: f64) -> [Injection; 2] {
        let after = Injection {
            stencil: self.stencil(place_m),
            amplitude: (self.gain * strength) as f32,
        };
        let [before, now] = self.recent[source];
        self.recent[source] = [now, after];
        [
            after,
            Injection {
                amplitude: -before.amplitude,
                ..before
            },
        ]
    }

    fn run_pair(
        &mut self,
        strengths: &[f64],
        sources: Places<'_>,
        receivers: Places<'_>,
        received: &mut Vec<f32>,
    ) {
        let (mut forcings, mut heard) = (Vec::with_capacity(CHUNK), Vec::with_capacity(CHUNK));
        for first in (0..strengths.len()).step_by(CHUNK) {
            let steps = first..strengths.len().min(first + CHUNK);
            forcings.clear();
            for step in steps {
                let injections = self.injections(0, sources.at(step, 0), strengths[step]);
                let receiver = match receivers.count() {
                    0 => injections[0].stencil,
                    _ => self.stencil(receivers.at(step, 0)),
                };
                forcings.push(StepForcing {
                    flush: flushes_subnormals(self.domain.scheme, self.step),
                    injections,
                    receiver,
                });
                self.step += 1;
            }
            heard.clear();
            self.field.advance(&forcings, &mut heard);
            if receivers.count() == 1 {
                received.extend_from_slice(&heard);
            }
        }
    }

    fn run_many(
        &mut self,
        strengths: &[f64],
        sources: Places<'_>,
        receivers: Places<'_>,
        received: &mut Vec<f32>,
    ) {
        let count = sources.count();
        let mut unused = Vec::with_capacity(1);
        for (step, strengths) in strengths.chunks_exact(count).enumerate() {
            let injections = self.injections(0, sources.at(step, 0), strengths[0]);
            let forcing = StepForcing {
                flush: flushes_subnormals(self.domain.scheme, self.step),
                injections,
                receiver: injections[0].stencil,
            };
            unused.clear();
            self.field.advance(&[forcing], &mut unused);
            for (source, &strength) in strengths.iter().enumerate().skip(1) {
                let pair = self.injections(source, sources.at(step, source), strength);
                for injection in pair.iter().filter(|injection| injection.amplitude != 0.0) {
                    self.field.add(injection);
                }
            }
            for receiver in 0..receivers.count() {
                let stencil = self.stencil(receivers.at(step, receiver));
                received.push(self.field.read(&stencil));
            }
            self.step += 1;
        }
    }

    /// Refuses to hand out a field that is not finite.
    fn check_finite(&self) -> Result<(), Error> {
        let ny = self.domain.grid.ny;
        let Some(row) = (0..ny).find(|&iy| !self.field.row_is_finite(iy)) else {
            return Ok(());
        };
        let grid = &self.domain.grid;
        let layer = self.domain.layer_cells;
        Err(Error::Unstable {
            time_s: self.time_s(),
            place_m: [0.5 * grid.size_m()[0], (row as f64 + 0.5) * grid.dx_m],
            in_layer: row < layer || row + layer >= ny,
            cause: "the pressure is not finite; the sources are too strong for it".to_string(),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::Simulation;
    use super::*;
    use crate::scheme::Scheme;
    use crate::simulation::SOURCE_STRENGTH_M2PS;

    /// A small scene with a slanted wall, in any air, and a drive along a curve.
    fn scene(temperature_degc: f64, scheme: Scheme) -> Scene {
        let text = format!(
            r#"{{ "name": "by hand",
            "medium": {{ "temperature_degc": {temperature_degc}, "relative_humidity_percent": 40 }},
            "grid": {{ "nx": 230, "ny": 190, "dx_m": 0.005, "dt_s": 6.6e-6 }}, "scheme": "{}",
            "walls": [{{ "points_m": [[0.2, 0.65], [0.8, 0.8]], "thickness_m": 0.02 }}],
            "robot": {{ "loudspeaker_offset_m": [0.02, 0.0], "microphone_offset_m": [-0.03, 0.01] }},
            "paths": {{ "drive": {{ "start": {{ "x_m": 0.5, "y_m": 0.4, "heading_rad": 0.3 }},
            "legs": [{{ "duration_s": 0.06, "v_mps": 0.3, "omega_radps": 1.0 }}] }} }} }}"#,
            scheme.name()
        );
        Scene::from_json(&text, Path::new("by_hand.json")).unwrap()
    }

    /// Places of loudspeaker and microphone and the strength at each of `steps` steps.
    fn drive(scene: &Scene, steps: usize) -> (Vec<[f64; 2]>, Vec<[f64; 2]>, Vec<f64>) {
        let (path, waveform) = (&scene.paths["drive"], scene.source_waveform().unwrap());
        let times = (1..=steps).map(|step| step as f64 * scene.grid.dt_s);
        let robot = scene.robot;
        (
            times
                .clone()
                .map(|t| path.point_at(t, robot.loudspeaker_offset_m))
                .collect(),
            times
                .clone()
                .map(|t| path.point_at(t, robot.microphone_offset_m))
                .collect(),
            times
                .map(|t| SOURCE_STRENGTH_M2PS * waveform.value(t))
                .collect(),
        )
    }

    #[test]
    fn one_pair_gives_the_bytes_of_a_simulation() {
        for (scheme, temperature_degc) in Scheme::ALL.into_iter().zip([3.0, 17.5, 20.0, 29.0, 11.0])
        {
            let scene = scene(temperature_degc, scheme);
            let options = SimulationOptions {
                threads: 2,
                whole_domain: true,
                ..SimulationOptions::default()
            };
            let waveform = scene.source_waveform().unwrap();
            let mut simulation = Simulation::new(&scene, "drive", &waveform, &options).unwrap();
            let steps = 1500;
            simulation
                .run(&mut |progress, _| match progress.step < steps {
                    true => super::super::Flow::Continue,
                    false => super::super::Flow::Stop,
                })
                .unwrap();
            let (sources, receivers, strengths) = drive(&scene, steps as usize);
            let mut field = SteppedField::new(&scene, &options).unwrap();
            let mut heard = Vec::new();
            // In pieces, as a caller that looks in between.
            for piece in [0..1, 1..700, 700..steps as usize] {
                heard.extend(
                    field
                        .run(
                            &strengths[piece.clone()],
                            Places::Moving(&sources[piece.clone()], 1),
                            Places::Moving(&receivers[piece], 1),
                        )
                        .unwrap(),
                );
            }
            let expected = simulation.received();
            assert_eq!(heard[..], expected[1..=steps as usize], "{scheme}");
            assert_eq!(field.steps(), steps);
        }
    }

    #[test]
    fn sources_add_up_and_receivers_do_not_disturb() {
        for reference_engine in [false, true] {
            let scene = scene(20.0, Scheme::M13);
            let options = SimulationOptions {
                threads: 2,
                reference_engine,
                ..SimulationOptions::default()
            };
            let (sources, _, strengths) = drive(&scene, 900);
            let ears = [[0.3, 0.5], [0.9, 0.3], [0.51, 0.42]];
            let other = [0.7, 0.5];
            let run = |sources: &[(&[[f64; 2]], f64)]| {
                let places: Vec<[f64; 2]> = (0..900)
                    .flat_map(|step| {
                        sources
                            .iter()
                            .map(move |(places, _)| places[step % places.len()])
                    })
                    .collect();
                let weighted: Vec<f64> = strengths
                    .iter()
                    .flat_map(|q| sources.iter().map(move |(_, gain)| gain * q))
                    .collect();
                let mut field = SteppedField::new(&scene, &options).unwrap();
                field
                    .run(
                        &weighted,
                        Places::Moving(&places, sources.len()),
                        Places::Fixed(&ears),
                    )
                    .unwrap()
            };
            let (one, two) = (run(&[(&sources, 1.0)]), run(&[(&[other], -0.5)]));
            let both = run(&[(&sources, 1.0), (&[other], -0.5)]);
            let loudest = both.iter().fold(0.0_f32, |most, p| most.max(p.abs()));
            assert!(loudest > 1e-3, "{loudest}");
            for ((a, b), sum) in one.iter().zip(&two).zip(&both) {
                assert!((a + b - sum).abs() < 1e-4 * loudest, "{a} + {b}, {sum}");
            }
            // One ear alone hears what it hears beside others.
            let mut alone = SteppedField::new(&scene, &options).unwrap();
            let heard = alone
                .run(
                    &strengths,
                    Places::Moving(&sources, 1),
                    Places::Fixed(&ears[..1]),
                )
                .unwrap();
            let first: Vec<f32> = one.iter().step_by(3).copied().collect();
            assert_eq!(heard, first, "reference engine: {reference_engine}");
        }
    }

    #[test]
    fn places_and_strengths_that_cannot_be_are_refused_before_any_step() {
        let scene = scene(20.0, Scheme::Slf);
        let mut field = SteppedField::new(&scene, &SimulationOptions::default()).unwrap();
        let here = [[0.5, 0.4]];
        for (strengths, sources, receivers) in [
            (vec![1.0], vec![[0.01, 0.4]], here.to_vec()),
            (vec![1.0], vec![[0.5, f64::NAN]], here.to_vec()),
            (vec![1.0], here.to_vec(), vec![[2.0, 0.4]]),
            (vec![f64::NAN], here.to_vec(), here.to_vec()),
            (vec![1e300], here.to_vec(), here.to_vec()),
            (vec![1.0, 2.0, 3.0], vec![[0.5, 0.4]; 2], here.to_vec()),
            (vec![1.0], Vec::new(), here.to_vec()),
        ] {
            let run = field.run(
                &strengths,
                Places::Fixed(&sources),
                Places::Fixed(&receivers),
            );
            assert!(run.is_err(), "{strengths:?} {sources:?} {receivers:?}");
            assert_eq!(field.steps(), 0);
        }
        let short = field.run(&[1.0, 1.0], Places::Moving(&here, 1), Places::Fixed(&here));
        assert!(
            short
                .unwrap_err()
                .to_string()
                .contains("1 places for 2 steps")
        );
    }
}
