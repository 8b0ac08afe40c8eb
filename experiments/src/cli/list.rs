//! `echolot list`.

use std::path::{Path, PathBuf};

use anyhow::Result;

use super::output::{print, print_json};
use crate::data::table::aligned;
use crate::papers::STUDIES;
use crate::run::project;
use crate::study::Study;
use crate::study::file::StudyFile;

/// Arguments of `list`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot list --json\n\nThe papers' studies, and the study files of the project."
)]
pub(crate) struct Arguments {}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let presets = |study: &crate::papers::Study| -> Vec<&str> {
            study.presets.iter().map(|preset| preset.name()).collect()
        };
        let files = files();
        if json {
            let papers = STUDIES.iter().map(|study| {
                serde_json::json!({
                    "name": study.name,
                    "presets": presets(study),
                    "figures": study.figures,
                    "about": study.about,
                })
            });
            let others = files.iter().map(|(path, study)| {
                serde_json::json!({"name": study.name, "file": path, "about": study.about})
            });
            return print_json(&papers.chain(others).collect::<Vec<_>>());
        }
        let mut rows = vec![
            ["study", "presets", "figures", "what it finds"]
                .map(String::from)
                .to_vec(),
        ];
        rows.extend(STUDIES.iter().map(|study| {
            vec![
                study.name.to_string(),
                presets(study).join(", "),
                study.figures.to_string(),
                study.about.to_string(),
            ]
        }));
        print(&aligned(&rows))?;
        if files.is_empty() {
            return Ok(());
        }
        let mut rows = vec![["study file", "what it asks"].map(String::from).to_vec()];
        let row = |(path, study): &(PathBuf, StudyFile)| {
            vec![path.display().to_string(), study.about.clone()]
        };
        rows.extend(files.iter().map(row));
        print(&format!("\n{}", aligned(&rows)))
    }
}

/// The study files of the project, where it is at hand.
fn files() -> Vec<(PathBuf, StudyFile)> {
    let mut found = Vec::new();
    for folder in ["studies", "studies/papers"] {
        let folder = project::file(Path::new(folder));
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            // The schema beside them is none.
            if path.extension().is_some_and(|ending| ending == "json")
                && let Ok(study) = Study::load(&path)
            {
                found.push((path, study.file));
            }
        }
    }
    found.sort_by(|a, b| a.0.cmp(&b.0));
    found
}
