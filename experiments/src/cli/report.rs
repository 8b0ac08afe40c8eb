//! `echolot report`.

use std::path::PathBuf;

use anyhow::Result;

use super::arguments::ForceArgument;
use crate::data::atomic;
use crate::data::place::Place;
use crate::report;

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot report results/my_study -o my_study.html\n  \
    echolot report results/paper -o paper.html\n\n\
    One file that holds everything: claims, scores, figures whose text can be selected, a replay of the drive \
    where the study has a figure of paths or is of the papers. Nothing is loaded from elsewhere; links lead to the \
    data files."
)]
pub(crate) struct Arguments {
    /// Folder of a study's results.
    results: PathBuf,
    /// The page (HTML).
    #[arg(short, long, value_name = "FILE.html")]
    output: PathBuf,
    #[command(flatten)]
    force: ForceArgument,
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self) -> Result<()> {
        let place = Place {
            inputs: vec![self.results.join("summary.json")],
            ..Place::of(&self.output, self.force.force)
        };
        place.file(report::is_ours)?;
        let page = report::page(&self.results, &self.output)?;
        atomic::write(&self.output, page.as_bytes())?;
        eprintln!("wrote {}", self.output.display());
        Ok(())
    }
}
