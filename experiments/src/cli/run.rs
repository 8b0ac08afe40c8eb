//! `echolot run`.

use std::path::PathBuf;

use anyhow::{Result, bail};

use super::arguments::{EngineArguments, ParameterArguments, threads};
use super::output::{print, print_json};

use crate::check::report;
use crate::check::targets::Targets;
use crate::check::verdicts::judge;
use crate::figures;
use crate::run::preset::Preset;
use crate::session::{Request, Session};
use crate::study::{STUDIES, Study, run};
use crate::summary::table;

/// Arguments of `run`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot run --preset paper\n  echolot run odometry-drift snr --preset paper\n\n\
    Recordings and trials are cached: what is there is not computed again, and an interrupted run goes on where \
    it stopped. \
    `echolot list` names the studies."
)]
pub(crate) struct Arguments {
    /// Studies; those of the preset unless given.
    #[arg(value_name = "STUDY")]
    studies: Vec<String>,
    /// Size of the run.
    #[arg(long, value_enum, default_value_t = Preset::Paper)]
    preset: Preset,
    /// Folder of the results.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Folder of the cache; `cache` in the results folder unless given.
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    #[command(flatten)]
    engine: EngineArguments,
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
    parameters: ParameterArguments,
}

/// The studies with these names, or those of the preset, in their own order.
fn chosen(names: &[String], preset: Preset) -> Result<Vec<&'static Study>> {
    if let Some(name) = names
        .iter()
        .find(|name| STUDIES.iter().all(|study| study.name != **name))
    {
        let known: Vec<&str> = STUDIES.iter().map(|study| study.name).collect();
        bail!(
            "study: {name}: is not known; choose from {}",
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

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let studies = chosen(&self.studies, self.preset)?;
        if self.threads > 0 {
            rayon::ThreadPoolBuilder::new()
                .num_threads(self.threads)
                .build_global()?;
        }
        let session = Session::open(&Request {
            preset: self.preset,
            cache: self.cache.unwrap_or_else(|| self.results.join("cache")),
            results: self.results,
            engine: self.engine.engine,
            image_order: self.engine.image_order()?,
            parameters: self.parameters.read()?,
            side_by_side: self.side_by_side,
        })?;
        let summary = run(&session, &studies)?;
        if !self.no_figures {
            figures::draw_all(session.results())?;
        }
        if self.preset == Preset::Paper {
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
