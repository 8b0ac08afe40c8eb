//! The plan of a study: its trials, the sessions that they share, and the recordings that are missing.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::Write;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use super::Study;
use super::cells::{Cell, Draw, MOST_TRIALS, draws, find};
use super::file::{MethodName, Settings};
use super::settings::{Resolved, Resolver, Source};
use crate::data::cache::Key;
use crate::recordings::noise::Noise;
use crate::recordings::spec::{Engine, RecordingSpec};
use crate::run::progress::duration;
use crate::schedule::{self, Job};
use crate::session::{Session, Setup, Workspace, measurement_of};
use crate::trials::{self, Approach, Trial};

/// A trial of a study.
pub(super) struct PlannedTrial {
    pub(super) cell: usize,
    pub(super) method: usize,
    pub(super) draw: Draw,
    /// Number of its session.
    pub(super) session: usize,
    pub(super) trial: Trial,
    /// Key of its result in the cache.
    pub(super) key: String,
}

/// Trials of a session that share measured echoes: a task for one worker.
pub(super) struct Batch {
    /// Key of the task.
    pub(super) key: String,
    pub(super) session: usize,
    /// Numbers of the trials.
    pub(super) members: Vec<usize>,
    /// Keys of the recordings that it needs.
    pub(super) needs: Vec<String>,
}

/// The trials of a study and what they need.
pub struct Plan {
    pub(super) trials: Vec<PlannedTrial>,
    pub(super) setups: Vec<Setup>,
    /// Whether trials of a session have noise, also in the mapping drive.
    noisy: Vec<[bool; 2]>,
    /// Simulations of all recordings, and whether each was in the cache when the plan was made, or nothing that is left
    /// to do needs it.
    pub(super) jobs: Vec<(Job, bool)>,
    pub(super) batches: Vec<Batch>,
}

impl Plan {
    /// The plan of a study in a workspace; `only` names cells by parts of their names, all when empty.
    ///
    /// # Errors
    /// One line that names cell and value: scenes, robots or parameters that cannot be used, more trials than anyone
    /// can wait for, a cell that does not exist.
    pub fn new(study: &Study, only: &[String], workspace: &Workspace) -> Result<Self> {
        let chosen = chosen(&study.cells, only)?;
        let resolver = Resolver::new(&workspace.cache);
        let sources = chosen
            .iter()
            .flat_map(|&cell| study.cells[cell].sources.iter());
        let mut sources: Vec<&Source> = sources.collect();
        sources.sort();
        sources.dedup();
        resolver.prepare(&sources)?;
        let mut plan = Self {
            trials: Vec::new(),
            setups: Vec::new(),
            noisy: Vec::new(),
            jobs: Vec::new(),
            batches: Vec::new(),
        };
        let mut sessions: HashMap<String, usize> = HashMap::new();
        for &cell in &chosen {
            for method in 0..study.file.methods.len() {
                plan.add(study, cell, method, &resolver, &mut sessions)
                    .with_context(|| format!("cell {}", study.cells[cell].name()))?;
            }
        }
        plan.look_up(study, workspace)?;
        Ok(plan)
    }

    /// Adds the trials of a method in a cell.
    fn add(
        &mut self,
        study: &Study,
        number: usize,
        method: usize,
        resolver: &Resolver,
        sessions: &mut HashMap<String, usize>,
    ) -> Result<()> {
        let cell = &study.cells[number];
        let choice = &study.file.methods[method];
        let name = choice.method();
        let mut settings: Settings = cell.settings.clone();
        settings.extend(choice.settings().cloned().unwrap_or_default());
        let robot = study
            .file
            .robot
            .as_deref()
            .map(|file| find(file, &study.folder));
        let resolve = |source: &Source, slip: u64| {
            resolver.resolve(source, robot.as_deref(), &settings, name, slip)
        };
        let first = cell.sources.first().context("scenes: there are none")?;
        let has_noise = resolve(first, 0)?.snr_db.is_some();
        let [layouts, slips, noises, filters] = draws(&study.file, cell, name, has_noise);
        if self
            .trials
            .len()
            .saturating_add(layouts * slips * noises * filters)
            > MOST_TRIALS
        {
            bail!("seeds: make more than {MOST_TRIALS} trials; draw less often");
        }
        for (layout, source) in cell.sources.iter().enumerate() {
            let layout = match source {
                Source::Random(_, seed) => *seed,
                Source::File(_) => layout as u64,
            };
            for slip in 0..slips as u64 {
                let resolved = resolve(source, slip)?;
                let session = self.session(&resolved, sessions);
                for noise in 0..noises as u64 {
                    for filter in 0..filters as u64 {
                        self.trials.push(PlannedTrial {
                            cell: number,
                            method,
                            draw: [layout, slip, noise, filter],
                            session,
                            trial: trial_of(name, &resolved, noise, filter),
                            key: String::new(),
                        });
                    }
                }
            }
        }
        Ok(())
    }

    /// The number of the session of a trial.
    fn session(&mut self, resolved: &Resolved, sessions: &mut HashMap<String, usize>) -> usize {
        let next = self.setups.len();
        let number = *sessions.entry(resolved.identity.clone()).or_insert(next);
        if number == next {
            self.setups.push(resolved.setup.clone());
            self.noisy.push([false; 2]);
        }
        let has_noise = resolved.snr_db.is_some();
        self.noisy[number][0] |= has_noise;
        self.noisy[number][1] |= has_noise && resolved.noisy_mapping;
        number
    }

    /// Finds the keys of all recordings and trials, and gathers the trials in batches.
    fn look_up(&mut self, study: &Study, workspace: &Workspace) -> Result<()> {
        let shown = self.shown(study);
        let mut needed = HashSet::new();
        let mut jobs: BTreeMap<String, Job> = BTreeMap::new();
        for (number, members) in self.by_session() {
            let session = Session::new(self.setups[number].clone(), workspace)?;
            let specs = specs(&session, self.noisy[number]);
            let own = session.recordings.jobs(&specs)?;
            let needs: Vec<String> = own.iter().map(|job| job.key.clone()).collect();
            jobs.extend(own.into_iter().map(|job| (job.key.clone(), job)));
            let mut batches: BTreeMap<String, Vec<usize>> = BTreeMap::new();
            for index in members {
                let planned = &mut self.trials[index];
                planned.key = trials::key_of(&session, &planned.trial)?;
                let trial = &planned.trial;
                let measured = measurement_of(&trial.parameters, &session.parameters);
                let name = serde_json::to_string(&(trial.approach, measured, trial.noisy_mapping))?;
                batches.entry(name).or_default().push(index);
            }
            let is_shown = |index: &usize| shown.contains(index);
            let is_done = |&index: &usize| workspace.cache.has("trials", &self.trials[index].key);
            if batches
                .values()
                .flatten()
                .any(|index| is_shown(index) || !is_done(index))
            {
                needed.extend(needs.iter().cloned());
            }
            for members in batches.into_values() {
                let mut key = Key::new("batch");
                members
                    .iter()
                    .for_each(|&index| key.text("trial", &self.trials[index].key));
                self.batches.push(Batch {
                    key: key.finish(),
                    session: number,
                    members,
                    needs: needs.clone(),
                });
            }
        }
        self.jobs = jobs
            .into_values()
            .map(|job| {
                let is_done = !needed.contains(&job.key) || workspace.cache.has_recording(&job.key);
                (job, is_done)
            })
            .collect();
        Ok(())
    }

    /// Numbers of the trials of which a figure or a report shows what was heard: the first ones of their methods.
    fn shown(&self, study: &Study) -> HashSet<usize> {
        let cells = study.shown_cell().into_iter().chain(study.mapped_cells());
        let methods = study.methods().len();
        let first = |cell: usize, method: usize| {
            let mut trials = self.trials.iter();
            trials.position(|planned| (planned.cell, planned.method) == (cell, method))
        };
        cells
            .flat_map(|cell| (0..methods).filter_map(move |method| first(cell, method)))
            .collect()
    }

    /// Number of trials.
    pub fn trials(&self) -> usize {
        self.trials.len()
    }

    /// Number of trials whose results are not in the cache.
    pub fn missing_trials(&self, workspace: &Workspace) -> usize {
        let is_missing = |planned: &&PlannedTrial| !workspace.cache.has("trials", &planned.key);
        self.trials.iter().filter(is_missing).count()
    }

    /// The simulations whose recordings were not in the cache and are needed.
    pub(super) fn missing(&self) -> Vec<Job> {
        let missing = self.jobs.iter().filter(|(_, is_done)| !is_done);
        missing.map(|(job, _)| job.clone()).collect()
    }

    /// The numbers of the trials of each session.
    fn by_session(&self) -> BTreeMap<usize, Vec<usize>> {
        let mut sessions: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (index, planned) in self.trials.iter().enumerate() {
            sessions.entry(planned.session).or_default().push(index);
        }
        sessions
    }

    /// The plan for people: recordings and trials, those that are missing, time and memory: of the simulations by a
    /// short run of the longest, of the trials by those before.
    ///
    /// # Errors
    /// When a scene does not run.
    pub fn text(&self, study: &Study, workspace: &Workspace) -> Result<String> {
        let cells: std::collections::BTreeSet<usize> =
            self.trials.iter().map(|planned| planned.cell).collect();
        let missing = self.missing();
        let mut text = format!(
            "study {}: {} cell(s), {} method(s), {} trials ({} to run) on {} recordings ({} to simulate)\n",
            study.file.name,
            cells.len(),
            study.file.methods.len(),
            self.trials.len(),
            self.missing_trials(workspace),
            self.jobs.len(),
            missing.len(),
        );
        text.push_str(&time_of(&missing, workspace)?);
        text.push_str(&self.trials_text(study, workspace)?);
        Ok(text)
    }
}

/// Time and memory of simulations for people, by a short run of the longest.
///
/// # Errors
/// When a scene does not run.
pub fn time_of(jobs: &[Job], workspace: &Workspace) -> Result<String> {
    let mut text = String::new();
    let (field, images): (Vec<&Job>, Vec<&Job>) =
        jobs.iter().partition(|job| job.spec.engine == Engine::Fdtd);
    if let Some(longest) = field.iter().max_by_key(|job| work(job)) {
        let estimate = schedule::estimate(&longest.scene, &longest.spec, workspace.threads)?;
        let all: u128 = field.iter().map(|job| work(job)).sum();
        let seconds = estimate.seconds * all as f64 / work(longest).max(1) as f64;
        writeln!(
            text,
            "{} simulation(s) of the field: about {} in all, at most {:.0} MiB each; the longest ({}): {estimate}",
            field.len(),
            duration(seconds),
            estimate.memory_bytes as f64 / (1024.0 * 1024.0),
            longest.label,
        )?;
    }
    if let Some(first) = images.first() {
        let started = Instant::now();
        schedule::sound(first)?;
        let share = images.len().div_ceil(workspace.threads.clamp(1, 2)) as f64;
        writeln!(
            text,
            "{} simulation(s) by image sources: about {} in all, measured on {}",
            images.len(),
            duration(started.elapsed().as_secs_f64() * share),
            first.label,
        )?;
    }
    Ok(text)
}

/// Size of a simulation, in cells times steps.
fn work(job: &Job) -> u128 {
    let grid = &job.scene.grid;
    let seconds = job
        .scene
        .path(&job.spec.path)
        .map_or(0.0, |path| path.duration_s());
    (grid.nx * grid.ny) as u128 * (seconds / grid.dt_s) as u128
}

/// The cells whose names have all of these parts, as `name=value`.
fn chosen(cells: &[Cell], only: &[String]) -> Result<Vec<usize>> {
    for part in only {
        if !part.contains('=') {
            bail!("--only {part}: is no NAME=VALUE; `--dry-run` lists the cells");
        }
    }
    let has = |cell: &Cell, part: &String| {
        let (wanted, value) = part.split_once('=').unwrap_or((part, ""));
        cell.labels.iter().any(|(name, text)| {
            (name == wanted.trim() || super::cells::short(name) == wanted.trim())
                && text == value.trim()
        })
    };
    let chosen: Vec<usize> = (0..cells.len())
        .filter(|&index| only.iter().all(|part| has(&cells[index], part)))
        .collect();
    if chosen.is_empty() {
        let names: Vec<String> = cells.iter().take(8).map(Cell::name).collect();
        let more = if cells.len() > 8 { "; ..." } else { "" };
        bail!(
            "--only {}: no cell has these values; there are: {}{more}",
            only.join(" "),
            names.join("; ")
        );
    }
    Ok(chosen)
}

/// The recordings of a session.
fn specs(session: &Session, [noisy, noisy_mapping]: [bool; 2]) -> Vec<RecordingSpec> {
    let recordings = &session.recordings;
    let mut specs = recordings.localization_specs(None);
    let direct = |path: &str| recordings.direct_spec(&recordings.spec(path, None));
    if noisy {
        specs.push(direct("localization"));
    }
    if noisy_mapping {
        specs.push(direct("mapping"));
    }
    specs
}

/// A trial of a method.
fn trial_of(method: MethodName, resolved: &Resolved, noise: u64, filter: u64) -> Trial {
    let by_sound = method != MethodName::Odometry;
    Trial {
        approach: match method {
            MethodName::Doppler | MethodName::ToaOnly | MethodName::Odometry => Approach::Images,
            MethodName::Multipath => Approach::Arrivals,
            MethodName::Landmarks => Approach::Landmarks,
            MethodName::Slam => Approach::Slam,
        },
        noise: resolved.snr_db.filter(|_| by_sound).map(|snr_db| Noise {
            snr_db,
            trial: noise,
        }),
        noisy_mapping: resolved.noisy_mapping && by_sound && resolved.snr_db.is_some(),
        ..Trial::new(resolved.setup.parameters.clone(), filter)
    }
}
