//! Values of a study put into scene, robot and parameters.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use anyhow::{Context, Result, anyhow, bail};
use fdtd::scene::{LayoutKind, Scene, random};
use localizer::{Parameters, landmarks};
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::{Value, json};

use super::file::{MethodName, RandomKind, Settings};
use crate::data::cache::{Cache, Key};
use crate::recordings::robot::Robot;
use crate::recordings::spec::{Engine, IMAGE_ORDER, ODOMETRY_BIAS_RADPS};
use crate::recordings::waveform::parameters_of;
use crate::session::Setup;

/// Most reflections that image sources are asked for.
const MOST_ORDER: u64 = 6;
/// Largest signal-to-noise ratio in decibels, on both sides of 0.
const MOST_DB: f64 = 300.0;
/// Largest steady error of a turn rate, rad/s.
const MOST_BIAS_RADPS: f64 = 10.0;
/// The name of the ideal robot's steady error of the turn rate.
const BIAS: &str = "odometry_bias_radps";

/// What a study does with drives, and the names of their paths unless `drive.*` names others.
const DRIVES: [&str; 2] = ["mapping", "localization"];

/// Where a scene's text comes from.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Source {
    /// A file.
    File(PathBuf),
    /// A layout drawn at random.
    Random(&'static str, u64),
}

/// What a trial is run on.
#[derive(Clone)]
pub(crate) struct Resolved {
    /// Scene, robot, engine and parameters.
    pub(crate) setup: Setup,
    /// Signal-to-noise ratio in decibels; no noise when `None`.
    pub(super) snr_db: Option<f64>,
    /// Whether the mapping drive has that noise too.
    pub(super) noisy_mapping: bool,
    /// Setups with the same text share recordings.
    pub(super) identity: String,
}

/// Puts values into scenes, which are parsed once. Layouts drawn at random are kept in the cache.
pub(crate) struct Resolver {
    cache: Cache,
    texts: Mutex<HashMap<Source, Value>>,
    scenes: Mutex<HashMap<String, Arc<Scene>>>,
}

/// The values of a part, `scene` of `scene.medium.c_mps`, by the rest of their names.
fn part<'a>(settings: &'a Settings, part: &str) -> impl Iterator<Item = (&'a str, &'a Value)> {
    settings.iter().filter_map(move |(name, value)| {
        let rest = name.strip_prefix(part)?.strip_prefix('.')?;
        Some((rest, value))
    })
}

/// Refuses a name that no part has.
pub(crate) fn check_name(name: &str, has_robot: bool) -> Result<()> {
    let Some((part, rest)) = name.split_once('.').filter(|(_, rest)| !rest.is_empty()) else {
        bail!(
            "is not known; names begin with scene., drive., robot., localizer., field. or noise."
        );
    };
    let known = match (part, rest) {
        ("scene" | "localizer", _) => true,
        ("drive", rest) => DRIVES.contains(&rest),
        ("robot", BIAS) if has_robot => {
            bail!("is for the ideal robot; leave out the robot file, or set its own fields")
        }
        ("robot", BIAS) => true,
        ("robot", _) if !has_robot => {
            bail!("there is no robot file; give one in `robot`, or set robot.{BIAS}")
        }
        ("robot", _) => true,
        ("field", rest) => ["engine", "image_order"].contains(&rest),
        ("noise", rest) => ["snr_db", "mapping"].contains(&rest),
        _ => false,
    };
    match known {
        true => Ok(()),
        false => bail!(
            "is not known; there are scene.*, drive.mapping, drive.localization, robot.*, localizer.*, field.engine, \
            field.image_order, noise.snr_db and noise.mapping"
        ),
    }
}

/// Puts a value at a dotted place into an object; numbers are places in arrays.
fn put(object: &mut Value, place: &str, value: &Value) -> Result<()> {
    let mut at = object;
    for key in place.split('.') {
        at = match at {
            Value::Array(list) => {
                let length = list.len();
                key.parse::<usize>()
                    .ok()
                    .and_then(|index| list.get_mut(index))
                    .ok_or_else(|| {
                        anyhow!("has {length} entries; give 0 to {}", length.max(1) - 1)
                    })?
            }
            Value::Object(map) => map.entry(key).or_insert_with(|| json!({})),
            _ => bail!("has no parts; leave out what follows"),
        };
    }
    *at = value.clone();
    Ok(())
}

/// Puts the paths that `drive.*` names in the places of a scene's own drives.
fn drives(scene: &mut Value, settings: &Settings) -> Result<()> {
    let chosen: Vec<(&str, &Value)> = part(settings, "drive").collect();
    let Some(paths) = scene.get_mut("paths").filter(|_| !chosen.is_empty()) else {
        return Ok(());
    };
    let own = paths.clone();
    for (drive, value) in chosen {
        let name: String = typed(&format!("drive.{drive}"), value)?;
        let path = own.get(&name).with_context(|| {
            let names = own
                .as_object()
                .map_or(Vec::new(), |all| all.keys().cloned().collect());
            format!(
                "drive.{drive}: the scene has no path {value}; it has {}",
                names.join(", ")
            )
        })?;
        put(paths, drive, path).with_context(|| format!("drive.{drive}"))?;
    }
    Ok(())
}

/// A value of a type, or one line that names it.
fn typed<'de, T: Deserialize<'de>>(name: &str, value: &'de Value) -> Result<T> {
    T::deserialize(value).map_err(|error| anyhow!("{name}: {value}: {error}"))
}

/// A layout drawn at random, from the cache where it has it: a mapping drive that explores takes a while to draw.
fn layout(kind: &str, seed: u64, cache: &Cache) -> Result<Value> {
    let mut key = Key::new("layout");
    key.text("field", env!("FIELD_FINGERPRINT"));
    key.text("layout", kind);
    key.value("seed", &seed)?;
    let key = key.finish();
    if cache.has("layouts", &key)
        && let Some(known) = cache.get("layouts", &key)
    {
        return Ok(known);
    }
    let layout = random::layout(
        match kind {
            "open" => LayoutKind::Open,
            _ => LayoutKind::Room,
        },
        seed,
    );
    cache.put("layouts", &key, &layout)?;
    Ok(layout)
}

impl Resolver {
    /// A resolver whose layouts are kept in a cache.
    pub(crate) fn new(cache: &Cache) -> Self {
        Self {
            cache: cache.clone(),
            texts: Mutex::default(),
            scenes: Mutex::default(),
        }
    }

    /// Reads or draws scenes, several at a time.
    ///
    /// # Errors
    /// When a file cannot be read, or the cache cannot be written.
    pub(super) fn prepare(&self, sources: &[&Source]) -> Result<()> {
        sources
            .par_iter()
            .with_max_len(1)
            .try_for_each(|source| self.text(source).map(drop))
    }

    /// The JSON of a scene before values are put into it.
    fn text(&self, source: &Source) -> Result<Value> {
        if let Some(known) = self
            .texts
            .lock()
            .ok()
            .and_then(|texts| texts.get(source).cloned())
        {
            return Ok(known);
        }
        let text: Value = match source {
            Source::File(file) => crate::data::json::read(file)?,
            Source::Random(kind, seed) => layout(kind, *seed, &self.cache)?,
        };
        if let Ok(mut texts) = self.texts.lock() {
            texts.insert(source.clone(), text.clone());
        }
        Ok(text)
    }

    /// The scene of a source with values put into it, and its text.
    fn scene(&self, source: &Source, settings: &Settings) -> Result<(Arc<Scene>, String)> {
        let mut text = self.text(source)?;
        for (place, value) in part(settings, "scene") {
            put(&mut text, place, value).with_context(|| format!("scene.{place}"))?;
        }
        drives(&mut text, settings)?;
        let text = text.to_string();
        if let Some(known) = self
            .scenes
            .lock()
            .ok()
            .and_then(|all| all.get(&text).cloned())
        {
            return Ok((known, text));
        }
        let origin = match source {
            Source::File(file) => file.clone(),
            Source::Random(kind, seed) => PathBuf::from(format!("random {kind} {seed}")),
        };
        let scene = Arc::new(Scene::from_json(&text, &origin)?);
        for drive in DRIVES {
            scene.path(drive)?;
        }
        if let Ok(mut scenes) = self.scenes.lock() {
            scenes.insert(text.clone(), Arc::clone(&scene));
        }
        Ok((scene, text))
    }

    /// Scene, robot and parameters with all values of a cell and a method, and the seed `slip` places after the
    /// robot's.
    ///
    /// # Errors
    /// One line that names the value that cannot be used.
    pub(crate) fn resolve(
        &self,
        source: &Source,
        robot: Option<&Path>,
        settings: &Settings,
        method: MethodName,
        slip: u64,
    ) -> Result<Resolved> {
        let (scene, scene_text) = self.scene(source, settings)?;
        let robot = robot
            .map(|file| robot_of(file, settings, slip))
            .transpose()?;
        let parameters = parameters(&scene, settings, method)?;
        let mut engine = Engine::Fdtd;
        let mut image_order = None;
        for (place, value) in part(settings, "field") {
            match place {
                "engine" => engine = typed("field.engine", value)?,
                _ => image_order = Some(typed::<u64>("field.image_order", value)?),
            }
        }
        if let Some(order) = image_order {
            if engine == Engine::Fdtd {
                bail!(
                    "field.image_order: {order} is for image sources; set field.engine to image-source or leave it out"
                );
            }
            if !(1..=MOST_ORDER).contains(&order) {
                bail!("field.image_order: {order} is out of range; give 1 to {MOST_ORDER}");
            }
        }
        let (mut snr_db, mut noisy_mapping) = (None, false);
        for (place, value) in part(settings, "noise") {
            match place {
                "snr_db" => snr_db = typed::<Option<f64>>("noise.snr_db", value)?,
                _ => noisy_mapping = typed("noise.mapping", value)?,
            }
        }
        if let Some(value) = snr_db.filter(|value| !(-MOST_DB..=MOST_DB).contains(value)) {
            bail!(
                "noise.snr_db: {value} is out of range; give {} to {MOST_DB}",
                -MOST_DB
            );
        }
        let bias = settings.get(&format!("robot.{BIAS}"));
        let odometry_bias_radps = match bias.filter(|_| robot.is_none()) {
            Some(value) => typed::<f64>("robot.odometry_bias_radps", value)?,
            None => ODOMETRY_BIAS_RADPS,
        };
        if odometry_bias_radps.abs() > MOST_BIAS_RADPS {
            bail!(
                "robot.{BIAS}: {odometry_bias_radps} is out of range; give up to {MOST_BIAS_RADPS} rad/s"
            );
        }
        let image_order = image_order.unwrap_or(u64::from(IMAGE_ORDER)) as usize;
        let identity = format!(
            "{scene_text} {} {engine:?} {image_order} {odometry_bias_radps} {:?} {}",
            serde_json::to_string(&robot)?,
            parameters.measurement.direct_wave,
            parameters.samples_per_period(),
        );
        let prefix = match source {
            Source::File(_) => format!("{} ", scene.name),
            Source::Random(kind, seed) => format!("{kind} {seed} "),
        };
        Ok(Resolved {
            setup: Setup {
                scene,
                robot,
                parameters,
                engine,
                image_order,
                odometry_bias_radps,
                prefix,
            },
            snr_db,
            noisy_mapping,
            identity,
        })
    }
}

/// The robot of a file with values put into it.
fn robot_of(file: &Path, settings: &Settings, slip: u64) -> Result<Robot> {
    let mut text: Value = crate::data::json::read(file)?;
    for (place, value) in part(settings, "robot") {
        put(&mut text, place, value).with_context(|| format!("robot.{place}"))?;
    }
    let mut robot = Robot::parse(&text.to_string(), file)?;
    robot.seed = robot.seed.wrapping_add(slip);
    Ok(robot)
}

/// Parameters of the localizer on a scene with values put into them.
fn parameters(scene: &Scene, settings: &Settings, method: MethodName) -> Result<Parameters> {
    let mut base = parameters_of(scene, &Parameters::default());
    if matches!(method, MethodName::Landmarks | MethodName::Slam) {
        base.measurement.periods = landmarks::PERIODS;
    }
    base.filter.method = match method {
        MethodName::ToaOnly => localizer::Method::ToaOnly,
        MethodName::Odometry => localizer::Method::Odometry,
        _ => localizer::Method::Doppler,
    };
    let mut text = serde_json::to_value(&base)?;
    // Zero is not written, but can be set.
    text["sensor_baseline_m"] = json!(base.signal.sensor_baseline_m);
    for (place, value) in part(settings, "localizer") {
        if place == "method" {
            bail!("localizer.method: belongs into `methods`; leave it out here");
        }
        let known = text.get(place.split('.').next().unwrap_or_default());
        if known.is_none() {
            bail!(
                "localizer.{place}: is no parameter of the localizer; docs/reference/parameters.md lists them"
            );
        }
        put(&mut text, place, value).with_context(|| format!("localizer.{place}"))?;
    }
    let parameters: Parameters = localizer::io::json::parse(&text.to_string())
        .map_err(|(field, problem)| anyhow!("localizer.{field}: {problem}; correct it"))?;
    parameters.check()?;
    Ok(parameters)
}

/// The source of a layout drawn at random.
pub(super) fn random_source(kind: RandomKind, seed: u64) -> Source {
    Source::Random(LayoutKind::from(kind).name(), seed)
}
