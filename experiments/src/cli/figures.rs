//! `echolot figures`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use super::output::{print, print_json};
use crate::figures::{Drawn, draw_all, draw_bench, draw_bound, study};
use crate::study::{Study, StudySummary};

/// Arguments of `figures`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot figures results/paper results/bench\n\n\
    Figures are drawn from the data files alone; nothing is simulated or localized."
)]
pub(crate) struct Arguments {
    /// Folders of results: of studies, or of `echolot bench`.
    #[arg(required = true, value_name = "RESULTS")]
    results: Vec<PathBuf>,
}

/// Draws what a folder of results has data for.
fn draw(folder: &Path) -> Result<Vec<Drawn>> {
    let alone = [draw_bench(folder)?, draw_bound(folder)?];
    if let Some(picture) = alone.into_iter().flatten().next() {
        return Ok(vec![Drawn::Picture(picture)]);
    }
    if !folder.join("data").is_dir() {
        bail!(
            "{}: data: is missing; name a folder of results that `echolot run` wrote",
            folder.display()
        );
    }
    match StudySummary::read(&folder.join("summary.json")) {
        Ok(summary) => {
            let of = Study::of_results(&summary.study);
            let of = of.with_context(|| folder.display().to_string())?;
            Ok(study::draw(&of, folder)?
                .into_iter()
                .map(Drawn::Picture)
                .collect())
        }
        Err(_) => draw_all(folder),
    }
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let mut drawn = Vec::new();
        for folder in &self.results {
            drawn.extend(draw(folder)?);
        }
        if json {
            let pictures: Vec<_> = drawn
                .iter()
                .filter_map(|drawn| match drawn {
                    Drawn::Picture(path) => Some(path),
                    Drawn::Missing { .. } => None,
                })
                .collect();
            return print_json(&pictures);
        }
        for drawn in drawn {
            match drawn {
                Drawn::Picture(path) => print(&format!("{}\n", path.display()))?,
                Drawn::Missing { figure, file } => {
                    eprintln!("left out {figure}: no {}", file.display())
                }
            }
        }
        Ok(())
    }
}
