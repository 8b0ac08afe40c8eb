//! `echolot validate`.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, bail};
use oracles::laws::{Depth, LAWS, Law};

use super::output::{print, print_json};
use crate::check::CheckFailed;
use crate::figures;
use crate::run::progress::duration;
use crate::validate::{self, Resume};

/// Arguments of `validate`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot validate --full\n  echolot validate --full echoes impedance\n\n\
    Exits with 1 when a measurement is outside its tolerance. Laws that were measured with the present sources of \
    field and laws are not measured again; interrupted, the same command goes on. Without LAW writes \
    results/validation: validation.json, table.md, data and figures."
)]
pub(crate) struct Arguments {
    /// Only laws whose name contains one of these; table and figures stay as they are, and without --full no file is
    /// written.
    #[arg(value_name = "LAW", conflicts_with = "figures_only")]
    laws: Vec<String>,
    /// All cases of every law instead of a few.
    #[arg(long)]
    full: bool,
    /// Measure also what was measured with the present sources.
    #[arg(long, conflicts_with = "figures_only")]
    anew: bool,
    /// Draw the figures from the existing data, without measuring.
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
            let pictures = figures::draw_validation(&folder)?;
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
        let whole = self.laws.is_empty();
        // A look at single laws in a few cases leaves no file.
        let resume = (whole || self.full).then(|| Resume::below(&self.results, depth));
        let rows = validate::run(&self.chosen()?, depth, resume.as_ref(), self.anew)?;
        if whole {
            validate::write(&rows, depth, &folder)?;
            figures::draw_validation(&folder)?;
        }
        if json {
            print_json(&rows)?;
        } else {
            print(&validate::table(&rows))?;
            let taken = duration(started.elapsed().as_secs_f64());
            if whole {
                eprintln!("wrote {} in {taken}", folder.display());
            } else {
                eprintln!("measured in {taken}");
            }
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

    /// The requested laws, in their order; all when none is named.
    fn chosen(&self) -> Result<Vec<Law>> {
        for part in &self.laws {
            if !LAWS.iter().any(|law| law.name.contains(part.as_str())) {
                let names: Vec<&str> = LAWS.iter().map(|law| law.name).collect();
                bail!(
                    "LAW {part}: no law has this in its name; there are: {}",
                    names.join("; ")
                );
            }
        }
        let asked = |law: &Law| {
            self.laws.is_empty()
                || self
                    .laws
                    .iter()
                    .any(|part| law.name.contains(part.as_str()))
        };
        Ok(LAWS.into_iter().filter(asked).collect())
    }
}
