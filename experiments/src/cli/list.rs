//! `echolot list`.

use anyhow::Result;

use super::output::{print, print_json};
use crate::data::table::aligned;
use crate::papers::STUDIES;

/// Arguments of `list`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  echolot list --json")]
pub(crate) struct Arguments {}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let presets = |study: &crate::papers::Study| -> Vec<&str> {
            study.presets.iter().map(|preset| preset.name()).collect()
        };
        if json {
            let list: Vec<_> = STUDIES
                .iter()
                .map(|study| {
                    serde_json::json!({
                        "name": study.name,
                        "presets": presets(study),
                        "figures": study.figures,
                        "about": study.about,
                    })
                })
                .collect();
            return print_json(&list);
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
        print(&aligned(&rows))
    }
}
