//! `echolot run`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::ValueEnum;

use super::arguments::{ForceArgument, ParameterArguments, threads};
use super::output::{print, print_json};
use crate::check::report;
use crate::check::targets::Targets;
use crate::check::verdicts::judge;
use crate::data::place::Place;
use crate::figures;
use crate::papers::{PaperSession, Request, STUDIES, Study as PaperStudy, run};
use crate::recordings::spec::{Engine, IMAGE_ORDER};
use crate::run::preset::Preset;
use crate::session::Workspace;
use crate::study::{self, Plan, Study, StudySummary};
use crate::summary::table;

/// Arguments of `run`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot run my_study.json --dry-run\n  echolot run my_study.json\n  \
    echolot run studies/papers/ensemble.json --only 'scene=random open'\n  \
    echolot run my_study.json --on slurm --array-size 20 --partition short --threads 2\n  \
    echolot run odometry-drift snr --preset paper\n\n\
    Recordings and trials are cached: what is there is not computed again, and an interrupted run goes on where \
    it stopped. A study file says what is simulated, what varies and what is claimed (docs/how-to/new-study.md); \
    its results lie in a folder of its name. `echolot list` names the papers' studies."
)]
pub(crate) struct Arguments {
    /// Study files or folders of them, or names of the papers' studies; those of the preset unless given.
    #[arg(value_name = "STUDY")]
    studies: Vec<String>,
    /// Size of the papers' studies [default: paper].
    #[arg(long, value_enum)]
    preset: Option<Preset>,
    /// Cells of a study file by their values; all unless given.
    #[arg(long, value_name = "NAME=VALUE")]
    only: Vec<String>,
    /// Print the plan of study files and stop: recordings to simulate, trials, time and memory.
    #[arg(long)]
    dry_run: bool,
    /// Folder of the results.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Folder of the cache; `cache` in the results folder unless given.
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Engine: the field, or image sources (approximate, seconds) [default: that of the study file, else fdtd].
    #[arg(long, value_enum)]
    engine: Option<Engine>,
    /// Most reflections of an echo by image sources [default: 2].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=6))]
    image_order: Option<u8>,
    /// Threads; 0 takes all.
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = threads)]
    threads: usize,
    /// Simulations that run side by side, each on its share of the threads [default: one or two, measured at the
    /// start].
    #[arg(long, value_name = "N", value_parser = threads)]
    side_by_side: Option<usize>,
    /// Leave out the figures.
    #[arg(long)]
    no_figures: bool,
    #[command(flatten)]
    cluster: ClusterArguments,
    #[command(flatten)]
    parameters: ParameterArguments,
    #[command(flatten)]
    force: ForceArgument,
}

/// What runs the tasks of a study file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Manager {
    /// Workers that Slurm starts.
    Slurm,
}

/// Arguments for a cluster.
#[derive(Debug, clap::Args)]
struct ClusterArguments {
    /// Let a cluster do the tasks: an array of workers on the cache, which all nodes must see.
    #[arg(long, value_enum, value_name = "MANAGER")]
    on: Option<Manager>,
    /// Workers.
    #[arg(long, value_name = "N", default_value_t = 8, requires = "on", value_parser = workers)]
    array_size: usize,
    /// Partition of the cluster.
    #[arg(long, value_name = "NAME", requires = "on")]
    partition: Option<String>,
    /// Limit of time of a worker, as `sbatch --time` takes it.
    #[arg(long, value_name = "TIME", requires = "on")]
    time: Option<String>,
    /// One more argument of `sbatch`; may be repeated.
    #[arg(long, value_name = "ARG", requires = "on", allow_hyphen_values = true)]
    sbatch_arg: Vec<String>,
}

/// Reads a number of workers.
fn workers(text: &str) -> Result<usize, String> {
    let count = text
        .parse()
        .ok()
        .filter(|count| (1..=10_000).contains(count));
    count.ok_or_else(|| "give 1 to 10000".to_string())
}

/// The papers' studies with these names, or those of the preset, in their own order.
fn chosen(names: &[String], preset: Preset) -> Result<Vec<&'static PaperStudy>> {
    if let Some(name) = names
        .iter()
        .find(|name| STUDIES.iter().all(|study| study.name != **name))
    {
        let known: Vec<&str> = STUDIES.iter().map(|study| study.name).collect();
        bail!(
            "study: {name}: is not known; give a study file (.json), or choose from {}",
            known.join(", ")
        );
    }
    Ok(STUDIES
        .iter()
        .filter(|study| match names.is_empty() {
            true => study.presets.contains(&preset),
            false => names.iter().any(|name| name == study.name),
        })
        .collect())
}

/// Whether a name is that of a study file or a folder of them.
fn is_file(name: &String) -> bool {
    name.ends_with(".json") || Path::new(name).is_dir()
}

/// The study files that are named, those of folders in the order of their names.
fn files(names: &[String]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for name in names {
        let path = PathBuf::from(name);
        if !path.is_dir() {
            files.push(path);
            continue;
        }
        let mut found = Vec::new();
        for entry in std::fs::read_dir(&path).with_context(|| name.clone())? {
            let file = entry.with_context(|| name.clone())?.path();
            if file.extension().is_some_and(|ending| ending == "json")
                && !file.to_string_lossy().ends_with(".schema.json")
            {
                found.push(file);
            }
        }
        if found.is_empty() {
            bail!("{name}: holds no study file; name a folder with .json files");
        }
        found.sort();
        files.extend(found);
    }
    Ok(files)
}

/// Checks the folder of a study's results: nobody else's summary is in it.
pub(super) fn check_place(results: &Path, file: &Path, force: bool) -> Result<()> {
    Place {
        inputs: vec![file.to_path_buf()],
        ..Place::of(results.join("summary.json"), force)
    }
    .file(|bytes| serde_json::from_slice::<StudySummary>(bytes).is_ok())
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        if self.threads > 0 {
            rayon::ThreadPoolBuilder::new()
                .num_threads(self.threads)
                .build_global()?;
        }
        match self.studies.iter().any(is_file) {
            true => self.run_files(json),
            false => self.run_papers(json),
        }
    }

    /// Most reflections of an image source's echo.
    fn image_order(&self, engine: Engine) -> Result<u8> {
        match self.image_order {
            Some(order) if engine == Engine::Fdtd => bail!(
                "--image-order {order}: is for image sources, the field has all reflections; add --engine \
                image-source or leave it out"
            ),
            order => Ok(order.unwrap_or(IMAGE_ORDER)),
        }
    }

    /// Folder of the cache.
    fn cache(&self) -> PathBuf {
        let own = self.cache.clone();
        own.unwrap_or_else(|| self.results.join("cache"))
    }

    /// Runs study files.
    fn run_files(self, json: bool) -> Result<()> {
        if let Some(name) = self.studies.iter().find(|name| !is_file(name)) {
            bail!(
                "study: {name}: is no file; run study files and the papers' studies one after the other"
            );
        }
        if self.preset.is_some() || self.parameters.parameters.is_some() {
            bail!(
                "--preset and --parameters: are for the papers' studies; put values into the study file's `set` \
                instead"
            );
        }
        let mut studies = Vec::new();
        for file in files(&self.studies)? {
            let mut study = Study::load(&file)?;
            match self.engine {
                Some(engine) => study.set_engine(engine, self.image_order(engine)?)?,
                None if self.image_order.is_some() => {
                    bail!("--image-order: says nothing without --engine image-source; add it")
                }
                None => {}
            }
            if !self.dry_run {
                let results = self.results.join(&study.file.name);
                check_place(&results, &file, self.force.force)?;
            }
            studies.push((file, study));
        }
        if self.cluster.on.is_some() && (self.engine.is_some() || !self.only.is_empty()) {
            bail!("--engine and --only: cannot be had on a cluster; put them into the study file");
        }
        let cache = self.cache();
        let workspace = Workspace::new(&cache, self.side_by_side);
        let mut summaries = Vec::new();
        for (file, study) in &studies {
            let plan = Plan::new(study, &self.only, &workspace)
                .with_context(|| format!("study {}", study.file.name))?;
            let text = plan.text(study, &workspace)?;
            if self.dry_run {
                let cells = study
                    .cells
                    .iter()
                    .map(|cell| format!("  {}\n", cell.name()));
                print(&format!("{text}{}", cells.collect::<String>()))?;
                continue;
            }
            eprint!("{text}");
            let results = self.results.join(&study.file.name);
            let summary = match self.cluster.on {
                None => study::run(study, &plan, &workspace, &results)?,
                Some(Manager::Slurm) => {
                    study::slurm::run(study, &plan, &workspace, &self.request(file, cache.clone()))?
                }
            };
            if !self.no_figures && self.cluster.on.is_none() {
                figures::study::draw(study, &results)?;
            }
            if !json {
                print(&study::table(&summary))?;
                eprintln!("results in {}", results.display());
            }
            summaries.push(summary);
        }
        match json && !self.dry_run {
            true => print_json(&summaries),
            false => Ok(()),
        }
    }

    /// What is asked of Slurm for a study.
    fn request(&self, study: &Path, cache: PathBuf) -> study::slurm::Request {
        study::slurm::Request {
            study: study.to_path_buf(),
            results: self.results.clone(),
            cache,
            array_size: self.cluster.array_size,
            threads: self.threads.max(1),
            partition: self.cluster.partition.clone(),
            time: self.cluster.time.clone(),
            sbatch: self.cluster.sbatch_arg.clone(),
        }
    }

    /// Runs studies of the papers.
    fn run_papers(self, json: bool) -> Result<()> {
        if self.dry_run || !self.only.is_empty() || self.cluster.on.is_some() {
            bail!("--dry-run, --only and --on: are for study files; name one");
        }
        let preset = self.preset.unwrap_or(Preset::Paper);
        let studies = chosen(&self.studies, preset)?;
        let engine = self.engine.unwrap_or(Engine::Fdtd);
        let session = PaperSession::open(&Request {
            preset,
            cache: self.cache(),
            engine,
            image_order: usize::from(self.image_order(engine)?),
            parameters: self.parameters.read()?,
            side_by_side: self.side_by_side,
            results: self.results,
        })?;
        let summary = run(&session, &studies)?;
        if !self.no_figures {
            figures::draw_all(session.results())?;
        }
        if preset == Preset::Paper {
            let targets = Targets::load()?;
            let judged = judge(&targets, &summary)?;
            report::write(session.results(), &targets, &judged, &summary)?;
        }
        if json {
            return print_json(&summary);
        }
        print(&table(&summary))?;
        eprintln!("results in {}", session.results().display());
        Ok(())
    }
}
