//! The laboratory: the scene, the parameters and the cache that all studies of a run share.

mod measured;

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use anyhow::{Context, Result};
use fdtd::scene::Scene;
use fdtd::scheme::Scheme;
use localizer::{DirectWave, EchoSequence, MapImage, Parameters, Recording};
use rayon::prelude::*;

use crate::cache::{Cache, recording_key};
use crate::preset::{Plan, Preset};
use crate::progress::Board;
use crate::robot::Robot;
use crate::schedule::{self, Job};
use crate::simulate::{self, Engine, Take};

pub use self::measured::{map_of, measurement_of};

/// Path of a scene on which the direct wave is recorded as in an anechoic chamber: a short drive without walls. Loudspeaker
/// and microphone ride on one robot, so that one period of it stands for all.
pub const ANECHOIC: &str = "anechoic";

/// What a run is asked for.
#[derive(Debug, Clone)]
pub struct Request {
    /// The preset.
    pub preset: Preset,
    /// Folder of the results; the preset's folder is below it.
    pub results: PathBuf,
    /// Folder of the cache.
    pub cache: PathBuf,
    /// What computes the sound.
    pub engine: Engine,
    /// Most reflections of an image source's echo.
    pub image_order: usize,
    /// Parameters of the localizer where the preset does not set them.
    pub parameters: Parameters,
    /// Simulations side by side; none to measure what is faster.
    pub side_by_side: Option<usize>,
}

/// Everything that the studies of one run share.
pub struct Laboratory {
    /// The preset.
    pub preset: Preset,
    /// Its cells.
    pub plan: Plan,
    /// The scene.
    pub scene: Arc<Scene>,
    /// The robot whose instruments the recordings get.
    pub robot: Option<Robot>,
    /// Parameters of the localizer at the preset's default window and periods.
    pub parameters: Parameters,
    /// Progress.
    pub board: Board,
    /// The cache.
    pub cache: Cache,
    /// Threads to use.
    pub threads: usize,
    request: Request,
    results: PathBuf,
    engine: Engine,
    prints: Mutex<HashMap<String, String>>,
    maps: Mutex<HashMap<String, Arc<MapImage>>>,
    /// The echoes that were measured last: studies that follow each other share them.
    recent: Mutex<Option<(String, Arc<EchoSequence>)>>,
}

impl Laboratory {
    /// Loads the scene of the preset.
    ///
    /// # Errors
    /// When the scene file cannot be used or the parameters are refused.
    pub fn open(request: &Request) -> Result<Self> {
        let results = request.results.join(request.preset.name());
        Self::with(request, request.preset.plan(), results)
    }

    /// The laboratory of the experimental site: another scene and robot, results in the folder `site` of the preset's.
    ///
    /// # Errors
    /// When the scene file or the robot file cannot be used.
    pub fn site(&self) -> Result<Self> {
        Self::with(
            &self.request,
            self.preset.site_plan(),
            self.results.join("site"),
        )
    }

    /// Loads the scene of a plan.
    fn with(request: &Request, plan: Plan, results: PathBuf) -> Result<Self> {
        let scene = Arc::new(Scene::load(&plan.scene)?);
        let robot = plan.robot.as_deref().map(Robot::read).transpose()?;
        let mut parameters = simulate::parameters_of(&scene, &request.parameters);
        parameters.measurement.periods = plan.periods;
        parameters.filter.window_half_width_m = plan.half_width_m;
        parameters.check()?;
        Ok(Self {
            preset: request.preset,
            plan,
            scene,
            robot,
            parameters,
            board: Board::new(),
            cache: Cache::new(&request.cache),
            threads: rayon::current_num_threads(),
            results,
            engine: request.engine,
            request: request.clone(),
            prints: Mutex::default(),
            maps: Mutex::default(),
            recent: Mutex::default(),
        })
    }

    /// Folder of the results of this preset.
    pub fn results(&self) -> &Path {
        &self.results
    }

    /// A data file of this preset.
    pub fn data(&self, name: &str) -> PathBuf {
        self.results.join("data").join(name)
    }

    /// Name of the scheme that the scene's field uses, or of the engine that takes its place.
    pub fn scheme_name(&self) -> String {
        match self.engine {
            Engine::Fdtd => self.scene.scheme.name().to_string(),
            Engine::ImageSource => Engine::ImageSource.name().to_string(),
        }
    }

    /// Whether the sound comes from the field.
    pub fn has_field(&self) -> bool {
        self.engine == Engine::Fdtd
    }

    /// The take of a drive path with a scheme (the scene's when `None`).
    pub fn take(&self, path: &str, scheme: Option<Scheme>) -> Take {
        Take {
            scheme: scheme.filter(|_| self.has_field()),
            image_order: self.request.image_order,
            ..Take::of(path, self.engine)
        }
    }

    /// Takes that localization with a scheme needs.
    pub fn takes(&self, scheme: Option<Scheme>) -> Vec<Take> {
        let walls = ["mapping", "localization"].map(|path| self.take(path, scheme));
        let mut takes = walls.to_vec();
        if self.parameters.measurement.direct_wave == DirectWave::FreeField {
            takes.extend(walls.iter().map(|take| self.direct_take(take)));
        }
        takes
    }

    /// The take that tells the direct wave of another: the scene's anechoic one, else the same drive without walls.
    pub fn direct_take(&self, take: &Take) -> Take {
        let mut direct = take.in_free_field();
        if self.scene.paths.contains_key(ANECHOIC) {
            direct.path = ANECHOIC.to_string();
        }
        direct
    }

    /// Key of a take in the cache.
    ///
    /// # Errors
    /// When the scene has no such path or the engine does not run.
    pub fn key(&self, take: &Take) -> Result<String> {
        let engine = engine_of(take);
        let known = self
            .prints
            .lock()
            .ok()
            .and_then(|prints| prints.get(&engine).cloned());
        let print = match known {
            Some(print) => print,
            None => simulate::engine_print(take, &self.scene)?,
        };
        if let Ok(mut prints) = self.prints.lock() {
            prints.insert(engine, print.clone());
        }
        recording_key(&self.scene, take, &print)
    }

    /// The simulations of those of the takes that are not in the cache, each once.
    ///
    /// # Errors
    /// When the scene has no such path or the engine does not run.
    pub fn missing(&self, takes: &[Take]) -> Result<Vec<Job>> {
        // Prints of engines take their time; keys of takes that share one are quick after the first.
        let engines: BTreeMap<String, &Take> =
            takes.iter().map(|take| (engine_of(take), take)).collect();
        engines
            .into_par_iter()
            .try_for_each(|(_, take)| self.key(take).map(drop))?;
        let mut jobs: BTreeMap<String, Job> = BTreeMap::new();
        for take in takes {
            let key = self.key(take)?;
            if !self.cache.recording(&key).is_dir() {
                let label = self.label(take);
                let (scene, take) = (Arc::clone(&self.scene), take.clone());
                let job = Job {
                    label,
                    key: key.clone(),
                    scene,
                    take,
                };
                jobs.insert(key, job);
            }
        }
        Ok(jobs.into_values().collect())
    }

    /// Simulates into the cache, also what other laboratories with the same cache miss.
    ///
    /// # Errors
    /// When a simulation fails or is interrupted.
    pub fn simulate(&self, jobs: &[Job]) -> Result<()> {
        schedule::run(
            jobs,
            &self.cache,
            self.threads,
            self.request.side_by_side,
            &self.board,
        )
    }

    /// Name of a take for people.
    pub fn label(&self, take: &Take) -> String {
        let field = if take.free_field { ", free field" } else { "" };
        let scheme = match take.scheme {
            Some(scheme) if self.has_field() => scheme.name().to_string(),
            _ => self.scheme_name(),
        };
        format!("{}{} {scheme}{field}", self.plan.prefix, take.path)
    }

    /// The recording of a take, with its direct wave when the parameters or the caller want it.
    ///
    /// # Errors
    /// When it is not in the cache (see [`Self::simulate`]) or damaged.
    pub fn recording(&self, take: &Take, with_direct: bool) -> Result<Recording> {
        let read = |take: &Take| -> Result<Recording> {
            let folder = self.cache.recording(&self.key(take)?);
            Recording::read(&folder).with_context(|| format!("recording of {}", self.label(take)))
        };
        let mut recording = read(take)?;
        if with_direct || self.parameters.measurement.direct_wave == DirectWave::FreeField {
            let direct = read(&self.direct_take(take))?.signal;
            recording.direct = Some(match self.scene.paths.contains_key(ANECHOIC) {
                true => repeated(&direct, &self.parameters, recording.signal.len())?,
                false => direct,
            });
        }
        if let Some(robot) = self.robot.as_ref().filter(|_| !take.free_field) {
            robot.apply(&mut recording, self.scene.path(&take.path)?, &take.path);
        }
        Ok(recording)
    }
}

/// All of a take that says what engine runs it, and how.
fn engine_of(take: &Take) -> String {
    format!(
        "{:?} {:?} {:?} {}",
        take.engine, take.scheme, take.spread, take.free_field
    )
}

/// The last whole period of an anechoic recording, over and over.
fn repeated(anechoic: &[f32], parameters: &Parameters, length: usize) -> Result<Vec<f32>> {
    let period = anechoic
        .chunks_exact(parameters.samples_per_period())
        .next_back()
        .context("the anechoic drive is shorter than one period of the code; make it longer")?;
    Ok(period.iter().copied().cycle().take(length).collect())
}
