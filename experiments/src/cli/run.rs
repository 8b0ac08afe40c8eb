//! `echolot run`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use serde_json::Value;

use super::arguments::{ForceArgument, threads};
use super::output::{print, print_json};
use super::study_files::{Loaded, files};
use crate::check::report;
use crate::check::targets::Targets;
use crate::check::verdicts::judge;
use crate::data::place::Place;
use crate::figures;
use crate::papers::{self, PaperSession, Papers};
use crate::recordings::spec::{Engine, IMAGE_ORDER};
use crate::session::Workspace;
use crate::study::{self, Plan, Study, StudySummary};
use crate::summary::{self, Summary};

/// Arguments of `run`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot run my_study.json --dry-run\n  echolot run my_study.json\n  \
    echolot run studies/papers/ensemble.json --only 'scene=random open'\n  \
    echolot run my_study.json --on slurm --array-size 20 --partition short --threads 2\n  \
    echolot run studies/papers/paper.json --only snr\n\n\
    Recordings and trials are cached: what is there is not computed again, and an interrupted run goes on where \
    it stopped. A study file says what is simulated, what varies and what is claimed (docs/how-to/new-study.md); \
    its results lie in a folder of its name. `echolot list` names the project's files and the papers' studies."
)]
pub(crate) struct Arguments {
    /// Study files or folders of them.
    #[arg(required = true, value_name = "STUDY")]
    studies: Vec<PathBuf>,
    /// Cells by their values (NAME=VALUE), or studies of the papers by their names; all unless given.
    #[arg(long, value_name = "CELL")]
    only: Vec<String>,
    /// Print the plan and stop: recordings to simulate, trials, time and memory.
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

/// The place of a study's summary.
fn place(results: &Path, file: &Path, force: bool) -> Place {
    Place {
        inputs: vec![file.to_path_buf()],
        ..Place::of(results.join("summary.json"), force)
    }
}

/// Checks the folder of a study's results: nobody else's summary is in it.
pub(super) fn check_place(results: &Path, file: &Path, force: bool) -> Result<()> {
    place(results, file, force).file(|bytes| serde_json::from_slice::<StudySummary>(bytes).is_ok())
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        if self.threads > 0 {
            rayon::ThreadPoolBuilder::new()
                .num_threads(self.threads)
                .build_global()?;
        }
        let mut studies: Vec<(Loaded, PathBuf)> = Vec::new();
        for file in files(&self.studies)? {
            let study = self.load(&file)?;
            if let Some((_, other)) = studies.iter().find(|(s, _)| s.name() == study.name()) {
                bail!(
                    "{}: name: {} is that of {} too, and so is the folder of results; rename one",
                    file.display(),
                    study.name(),
                    other.display()
                );
            }
            studies.push((study, file));
        }
        let workspace = Workspace::new(self.cache(), self.side_by_side);
        let mut said = Vec::new();
        for (study, file) in &studies {
            said.extend(match study {
                Loaded::Study(study) => self.run_study(study, file, &workspace, json)?,
                Loaded::Papers(papers) => self.run_papers(papers, &workspace, json)?,
            });
        }
        match (&studies[..], &said[..]) {
            _ if !json || self.dry_run => Ok(()),
            ([(Loaded::Papers(_), _)], [summary]) => print_json(summary),
            _ => print_json(&said),
        }
    }

    /// Reads a study file, and checks that it can be run as it is asked for and where its results will lie.
    fn load(&self, file: &Path) -> Result<Loaded> {
        let mut study = Loaded::read(file)?;
        match (self.engine, &mut study) {
            (Some(engine), Loaded::Study(study)) => {
                study.set_engine(engine, self.image_order(engine)?)?;
            }
            (Some(engine), Loaded::Papers(papers)) => {
                papers.set_engine(engine, self.image_order(engine)?)?;
            }
            (None, _) if self.image_order.is_some() => {
                bail!(
                    "--image-order {}: says nothing without --engine image-source; add it",
                    self.image_order.unwrap_or_default()
                )
            }
            (None, _) => {}
        }
        let is_on_cluster = self.cluster.on.is_some();
        if is_on_cluster && (self.engine.is_some() || !self.only.is_empty()) {
            bail!("--engine and --only: cannot be had on a cluster; put them into the study file");
        }
        if let Loaded::Papers(papers) = &study {
            if is_on_cluster {
                bail!(
                    "{}: --on: the papers' studies run in one piece; leave the option out",
                    file.display()
                );
            }
            papers.chosen(&self.only)?;
        }
        if !self.dry_run {
            let results = self.results.join(study.name());
            match study {
                Loaded::Study(_) => check_place(&results, file, self.force.force)?,
                Loaded::Papers(_) => place(&results, file, self.force.force)
                    .file(|bytes| serde_json::from_slice::<Summary>(bytes).is_ok())?,
            }
        }
        Ok(study)
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

    /// Runs a study of cells; gives its summary.
    fn run_study(
        &self,
        study: &Study,
        file: &Path,
        workspace: &Workspace,
        json: bool,
    ) -> Result<Option<Value>> {
        let plan = Plan::new(study, &self.only, workspace)
            .with_context(|| format!("study {}", study.file.name))?;
        let text = plan.text(study, workspace)?;
        if self.dry_run {
            let cells = study
                .cells
                .iter()
                .map(|cell| format!("  {}\n", cell.name()));
            print(&format!("{text}{}", cells.collect::<String>()))?;
            return Ok(None);
        }
        eprint!("{text}");
        let results = self.results.join(&study.file.name);
        let summary = match self.cluster.on {
            None => study::run(study, &plan, workspace, &results)?,
            Some(Manager::Slurm) => {
                study::slurm::run(study, &plan, workspace, &self.request(file, self.cache()))?
            }
        };
        if !self.no_figures && self.cluster.on.is_none() {
            figures::study::draw(study, &results)?;
        }
        if !json {
            print(&study::table(&summary))?;
            eprintln!("results in {}", results.display());
        }
        Ok(Some(serde_json::to_value(&summary)?))
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

    /// Runs the papers' studies of a file; gives their summary.
    fn run_papers(
        &self,
        papers: &Papers,
        workspace: &Workspace,
        json: bool,
    ) -> Result<Option<Value>> {
        let session = PaperSession::open(papers.clone(), &self.results, workspace)?;
        let studies = papers.chosen(&self.only)?;
        let jobs = papers::missing(&session, &studies)?;
        let text = format!(
            "{}: {} studies of the papers, {} recordings to simulate\n{}",
            papers.file.name,
            studies.len(),
            jobs.len(),
            study::time_of(&jobs, workspace)?
        );
        if self.dry_run {
            let names = studies.iter().map(|study| format!("  {}\n", study.name()));
            print(&format!("{text}{}", names.collect::<String>()))?;
            return Ok(None);
        }
        eprint!("{text}");
        let summary = papers::run(&session, &studies, &jobs)?;
        if !self.no_figures {
            figures::draw_all(session.results())?;
        }
        if papers.file.verdicts.is_some() {
            let targets = Targets::load()?;
            let judged = judge(&targets, &summary)?;
            report::write(session.results(), &targets, &judged, &summary)?;
        }
        if !json {
            print(&summary::table(&summary))?;
            eprintln!("results in {}", session.results().display());
        }
        Ok(Some(serde_json::to_value(&summary)?))
    }
}
