//! `echolot figures`.

use std::path::PathBuf;

use anyhow::{Result, bail};

use super::output::{print, print_json};
use crate::figures::{Drawn, draw_all, draw_bench};
use crate::run::preset::Preset;

/// Arguments of `figures`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  echolot figures --preset paper\n\n\
    Figures are drawn from the data files alone; nothing is simulated or localized.")]
pub(crate) struct Arguments {
    /// Preset whose figures are drawn.
    #[arg(long, value_enum, default_value_t = Preset::Paper)]
    preset: Preset,
    /// Folder of the results.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let folder = self.results.join(self.preset.name());
        if !folder.join("data").is_dir() {
            bail!(
                "{}: data: is missing; run `echolot run --preset {}` first",
                folder.display(),
                self.preset.name()
            );
        }
        let mut drawn = draw_all(&folder)?;
        drawn.extend(draw_bench(&self.results.join("bench"))?.map(Drawn::Picture));
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
