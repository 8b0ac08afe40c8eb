//! `echolot validate`.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use fdtd::validation::Depth;

use super::output::{print, print_json};
use crate::check::CheckFailed;
use crate::progress::duration;
use crate::validate;

/// Arguments of `validate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  echolot validate --full\n\n\
    Exits with 1 when a measurement is outside its tolerance. Writes results/validation: validation.json, table.md, data and figures.")]
pub(crate) struct Arguments {
    /// All cases of every law instead of a few.
    #[arg(long)]
    full: bool,
    /// Only draw the figures from data that is there.
    #[arg(long, conflicts_with = "full")]
    figures_only: bool,
    /// Folder of the results.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let folder = self.results.join("validation");
        if self.figures_only {
            let pictures = validate::draw(&folder)?;
            if json {
                return print_json(&pictures);
            }
            for picture in pictures {
                print(&format!("{}\n", picture.display()))?;
            }
            return Ok(());
        }
        let depth = if self.full { Depth::Full } else { Depth::Quick };
        let started = Instant::now();
        let rows = validate::run(depth)?;
        validate::write(&rows, depth, &folder)?;
        validate::draw(&folder)?;
        if json {
            print_json(&rows)?;
        } else {
            print(&validate::table(&rows))?;
            eprintln!(
                "wrote {} in {}",
                folder.display(),
                duration(started.elapsed().as_secs_f64())
            );
        }
        let failed = rows.iter().filter(|row| !row.passed).count();
        if failed > 0 {
            let of = rows.len();
            return Err(
                CheckFailed(format!("{failed} of {of} measurements out of tolerance")).into(),
            );
        }
        Ok(())
    }
}
