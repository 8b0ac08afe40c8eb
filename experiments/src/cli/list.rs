//! `echolot list`.

use std::path::{Path, PathBuf};

use anyhow::Result;

use super::output::{print, print_json};
use super::study_files::{Loaded, files};
use crate::data::table::aligned;
use crate::papers::STUDIES;
use crate::run::project;

/// Folders of the project that hold study files.
const FOLDERS: [&str; 3] = ["studies", "studies/papers", "studies/quick"];

/// Arguments of `list`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot list --json\n\nThe study files of the project, and what the papers' studies find."
)]
pub(crate) struct Arguments {}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let files = known();
        if json {
            let others = files.iter().map(|(path, study)| {
                let (name, about) = (study.name(), study.about());
                serde_json::json!({"name": name, "file": path, "about": about})
            });
            let papers = STUDIES.iter().map(|study| {
                serde_json::json!({"name": study.name, "figures": study.figures, "about": study.about})
            });
            return print_json(&others.chain(papers).collect::<Vec<_>>());
        }
        let mut rows = vec![
            ["study of a paper", "figures", "what it finds"]
                .map(String::from)
                .to_vec(),
        ];
        rows.extend(STUDIES.iter().map(|study| {
            [study.name, study.figures, study.about]
                .map(String::from)
                .to_vec()
        }));
        print(&aligned(&rows))?;
        if files.is_empty() {
            return Ok(());
        }
        let mut rows = vec![["study file", "what it asks"].map(String::from).to_vec()];
        let row = |(path, study): &(PathBuf, Loaded)| {
            vec![path.display().to_string(), study.about().to_string()]
        };
        rows.extend(files.iter().map(row));
        print(&format!("\n{}", aligned(&rows)))
    }
}

/// The study files of the project, where it is at hand.
fn known() -> Vec<(PathBuf, Loaded)> {
    let folders = FOLDERS.map(|folder| project::file(Path::new(folder)));
    let paths = folders
        .iter()
        .flat_map(|folder| files(std::slice::from_ref(folder)).unwrap_or_default());
    paths
        .filter_map(|path| Some((path.clone(), Loaded::read(&path).ok()?)))
        .collect()
}
