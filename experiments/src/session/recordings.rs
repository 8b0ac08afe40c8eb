//! The recordings of a session: specified by path and scheme, found in the cache by their key, read with the robot's
//! instruments applied.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex};

use anyhow::{Context, Result};
use fdtd::scene::Scene;
use fdtd::scheme::Scheme;
use localizer::{DirectWave, Recording};
use rayon::prelude::*;

use super::{Setup, Workspace};
use crate::data::cache::Cache;
use crate::recordings::fingerprint::engine_fingerprint;
use crate::recordings::key::recording_key;
use crate::recordings::noise::Noise;
use crate::recordings::robot::Robot;
use crate::recordings::spec::{Engine, RecordingSpec};
use crate::schedule::Job;

/// Path of a scene on which the direct wave is recorded as in an anechoic chamber: a short drive without walls.
/// Loudspeaker and microphone ride on one robot, so that one period of it stands for all.
pub const ANECHOIC: &str = "anechoic";

/// Recordings of one scene with one engine.
pub struct Recordings {
    scene: Arc<Scene>,
    robot: Option<Robot>,
    cache: Cache,
    engine: Engine,
    image_order: usize,
    odometry_bias_radps: f64,
    /// Prefix of their names.
    prefix: String,
    direct_wave: DirectWave,
    samples_per_period: usize,
    /// Fingerprints of the engines by [`Recordings::engine_of`].
    fingerprints: Arc<Mutex<HashMap<String, String>>>,
    /// Keys by specification.
    keys: Mutex<HashMap<String, String>>,
}

impl Recordings {
    /// Recordings of a session.
    pub(super) fn new(setup: Setup, workspace: &Workspace) -> Self {
        Self {
            direct_wave: setup.parameters.measurement.direct_wave,
            samples_per_period: setup.parameters.samples_per_period(),
            scene: setup.scene,
            robot: setup.robot,
            cache: workspace.cache.clone(),
            engine: setup.engine,
            image_order: setup.image_order,
            odometry_bias_radps: setup.odometry_bias_radps,
            prefix: setup.prefix,
            fingerprints: Arc::clone(&workspace.fingerprints),
            keys: Mutex::default(),
        }
    }

    /// The robot whose instruments the recordings get.
    pub fn robot(&self) -> Option<&Robot> {
        self.robot.as_ref()
    }

    /// Name of the scheme of the scene's field, or of the engine that takes its place.
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

    /// The recording of a drive path with a scheme (the scene's when `None`).
    pub fn spec(&self, path: &str, scheme: Option<Scheme>) -> RecordingSpec {
        RecordingSpec {
            scheme: scheme.filter(|_| self.has_field()),
            image_order: self.image_order,
            odometry_bias_radps: self.odometry_bias_radps,
            ..RecordingSpec::of(path, self.engine)
        }
    }

    /// The recordings that localization with a scheme needs.
    pub fn localization_specs(&self, scheme: Option<Scheme>) -> Vec<RecordingSpec> {
        let walls = ["mapping", "localization"].map(|path| self.spec(path, scheme));
        let mut specs = walls.to_vec();
        if self.direct_wave == DirectWave::FreeField {
            specs.extend(walls.iter().map(|spec| self.direct_spec(spec)));
        }
        specs
    }

    /// The recording with the direct wave of another: the scene's anechoic one, else the same drive without walls.
    pub fn direct_spec(&self, spec: &RecordingSpec) -> RecordingSpec {
        let mut direct = spec.in_free_field();
        if self.scene.paths.contains_key(ANECHOIC) {
            direct.path = ANECHOIC.to_string();
        }
        direct
    }

    /// What selects the engine and its options: recordings with the same have the same fingerprint.
    fn engine_of(&self, spec: &RecordingSpec) -> String {
        let scene = &self.scene;
        if spec.engine == Engine::ImageSource {
            return format!("{:?} {} {}", spec.engine, spec.image_order, spec.free_field);
        }
        let is_soft = scene.walls.iter().any(|wall| wall.impedance.is_some());
        format!(
            "{:?} {:?} {:?} {:?} {} {}",
            spec.engine,
            spec.scheme.unwrap_or(scene.scheme),
            spec.spread.unwrap_or(scene.spread),
            spec.wall_model.unwrap_or(scene.wall_model),
            spec.free_field,
            is_soft,
        )
    }

    /// Key of a recording in the cache.
    ///
    /// # Errors
    /// When the scene has no such path or the engine does not run.
    pub fn key(&self, spec: &RecordingSpec) -> Result<String> {
        let name = format!("{spec:?}");
        if let Some(known) = self
            .keys
            .lock()
            .ok()
            .and_then(|keys| keys.get(&name).cloned())
        {
            return Ok(known);
        }
        let engine = self.engine_of(spec);
        let known = self
            .fingerprints
            .lock()
            .ok()
            .and_then(|fingerprints| fingerprints.get(&engine).cloned());
        let fingerprint = match known {
            Some(fingerprint) => fingerprint,
            None => engine_fingerprint(spec, &self.scene)?,
        };
        if let Ok(mut fingerprints) = self.fingerprints.lock() {
            fingerprints.insert(engine, fingerprint.clone());
        }
        let key = recording_key(&self.scene, spec, &fingerprint)?;
        if let Ok(mut keys) = self.keys.lock() {
            keys.insert(name, key.clone());
        }
        Ok(key)
    }

    /// The simulations of those of the recordings that are not in the cache, each once.
    ///
    /// # Errors
    /// When the scene has no such path or the engine does not run.
    pub fn missing(&self, specs: &[RecordingSpec]) -> Result<Vec<Job>> {
        let mut jobs = self.jobs(specs)?;
        jobs.retain(|job| !self.cache.has_recording(&job.key));
        Ok(jobs)
    }

    /// The simulations of the recordings, each once.
    ///
    /// # Errors
    /// When the scene has no such path or the engine does not run.
    pub fn jobs(&self, specs: &[RecordingSpec]) -> Result<Vec<Job>> {
        // Fingerprints take their time; keys of recordings that share one are quick after the first.
        let engines: BTreeMap<String, &RecordingSpec> = specs
            .iter()
            .map(|spec| (self.engine_of(spec), spec))
            .collect();
        engines
            .into_par_iter()
            .try_for_each(|(_, spec)| self.key(spec).map(drop))?;
        let mut jobs: BTreeMap<String, Job> = BTreeMap::new();
        for spec in specs {
            let key = self.key(spec)?;
            let job = Job {
                label: self.label(spec),
                key: key.clone(),
                scene: Arc::clone(&self.scene),
                spec: spec.clone(),
            };
            jobs.insert(key, job);
        }
        Ok(jobs.into_values().collect())
    }

    /// Name of a recording for people.
    pub fn label(&self, spec: &RecordingSpec) -> String {
        let field = if spec.free_field { ", free field" } else { "" };
        let scheme = match spec.scheme {
            Some(scheme) if self.has_field() => scheme.name().to_string(),
            _ => self.scheme_name(),
        };
        format!("{}{} {scheme}{field}", self.prefix, spec.path)
    }

    /// Reads a recording, with its direct wave when the parameters or the caller want it.
    ///
    /// # Errors
    /// When it is not in the cache (see [`Session::simulate`](super::Session::simulate)) or damaged.
    pub fn read(&self, spec: &RecordingSpec, with_direct: bool) -> Result<Recording> {
        let read = |spec: &RecordingSpec| -> Result<Recording> {
            let folder = self.cache.recording(&self.key(spec)?);
            Recording::read_aligned(&folder)
                .with_context(|| format!("recording of {}", self.label(spec)))
        };
        let mut recording = read(spec)?;
        if with_direct || self.direct_wave == DirectWave::FreeField {
            let direct = read(&self.direct_spec(spec))?.signal;
            recording.direct = Some(match self.scene.paths.contains_key(ANECHOIC) {
                true => repeated(&direct, self.samples_per_period, recording.signal.len())?,
                false => direct,
            });
        }
        if let Some(robot) = self.robot.as_ref().filter(|_| !spec.free_field) {
            robot.apply(&mut recording, self.scene.path(&spec.path)?, &spec.path);
        }
        Ok(recording)
    }

    /// Reads a recording and adds noise, whose level is that of eqs. (19)-(21), if there is any.
    ///
    /// # Errors
    /// As [`Recordings::read`].
    pub fn noisy(&self, spec: &RecordingSpec, noise: Option<Noise>) -> Result<Recording> {
        let mut recording = self.read(spec, noise.is_some())?;
        if let Some(noise) = noise {
            let direct = recording.direct.take().unwrap_or_default();
            noise.add_to(&mut recording.signal, &direct);
            recording.direct = Some(direct).filter(|_| self.direct_wave == DirectWave::FreeField);
        }
        Ok(recording)
    }
}

/// The last whole period of an anechoic recording, repeated to `length` samples.
fn repeated(anechoic: &[f32], samples_per_period: usize, length: usize) -> Result<Vec<f32>> {
    let period = anechoic
        .chunks_exact(samples_per_period)
        .next_back()
        .context("the anechoic drive is shorter than one period of the code; make it longer")?;
    Ok(period.iter().copied().cycle().take(length).collect())
}
