//! `echolot plan`, `echolot task` and `echolot gather`: a study by several workers.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, Result};

use super::arguments::{ForceArgument, threads};
use super::output::{print, print_json};
use crate::data::table::aligned;
use crate::figures;
use crate::session::Workspace;
use crate::study::{self, Plan, Study, tasks};

/// A study, and where its cache lies.
#[derive(Debug, clap::Args)]
pub(super) struct StudyArguments {
    /// The study file.
    study: PathBuf,
    /// Folder of the results; the study's folder is below it.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Folder of the cache, which all workers share; `cache` in the results folder unless given.
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Threads; 0 takes all.
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = threads)]
    threads: usize,
}

impl StudyArguments {
    /// Study, plan and workspace.
    fn open(&self) -> Result<(Study, Plan, Workspace)> {
        if self.threads > 0 {
            rayon::ThreadPoolBuilder::new()
                .num_threads(self.threads)
                .build_global()?;
        }
        let study = Study::load(&self.study)?;
        let cache = self.cache.clone();
        let workspace = Workspace::new(cache.unwrap_or_else(|| self.results.join("cache")), None);
        let plan =
            Plan::new(&study, &[], &workspace).with_context(|| self.study.display().to_string())?;
        Ok((study, plan, workspace))
    }
}

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  echolot plan my_study.json --json\n\n\
    A task is a simulation, or the trials that share measured echoes. Its key is the hash of all that determines what \
    it makes; trials need the recordings of their simulations.")]
pub(crate) struct PlanArguments {
    #[command(flatten)]
    study: StudyArguments,
}

impl PlanArguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let (study, plan, workspace) = self.study.open()?;
        let tasks = plan.tasks(&study, &workspace);
        if json {
            return print_json(&tasks);
        }
        let mut rows = vec![
            ["key", "kind", "trials", "done", "task"]
                .map(String::from)
                .to_vec(),
        ];
        rows.extend(tasks.iter().map(|task| {
            let done = if task.done { "yes" } else { "" };
            let trials = if task.trials > 0 {
                task.trials.to_string()
            } else {
                String::new()
            };
            vec![
                task.key.clone(),
                task.kind.to_string(),
                trials,
                done.to_string(),
                task.label.clone(),
            ]
        }));
        print(&aligned(&rows))
    }
}

/// Arguments of `task`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot task my_study.json --cache /shared/cache --threads 1\n  \
    echolot task my_study.json 1f00c2a9e1b2c3d4e5f6\n\n\
    Any number of workers may share the cache: each takes the lease of a task before it begins, and a dead one's lease \
    runs out. An interrupted simulation leaves its checkpoint, from which the next worker goes on."
)]
pub(crate) struct TaskArguments {
    #[command(flatten)]
    study: StudyArguments,
    /// Keys of tasks; all that are left unless given.
    #[arg(value_name = "KEY")]
    keys: Vec<String>,
}

impl TaskArguments {
    /// Runs the command.
    pub(crate) fn run(self) -> Result<()> {
        let (study, plan, workspace) = self.study.open()?;
        tasks::work(&study, &plan, &self.keys, &workspace)
    }
}

/// Arguments of `gather`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot gather my_study.json --cache /shared/cache\n\n\
    Writes results, figures and claims of a study whose tasks are all done; nothing is computed."
)]
pub(crate) struct GatherArguments {
    #[command(flatten)]
    study: StudyArguments,
    /// Leave out the figures.
    #[arg(long)]
    no_figures: bool,
    #[command(flatten)]
    force: ForceArgument,
}

impl GatherArguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let (study, plan, workspace) = self.study.open()?;
        let results = self.study.results.join(&study.file.name);
        super::run::check_place(&results, &self.study.study, self.force.force)?;
        let summary = study::gather(&study, &plan, &workspace, &results, BTreeMap::new())?;
        if !self.no_figures {
            figures::study::draw(&study, &results)?;
        }
        match json {
            true => print_json(&summary),
            false => print(&study::table(&summary)),
        }
    }
}
