//! `echolot study`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Subcommand;

use super::output::{print, print_json};
use super::study_files::Loaded;
use crate::figures;
use crate::papers::{self, PaperStudy};
use crate::study::Study;

/// Arguments of `study`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot study check my_study.json\n  echolot run my_study.json"
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Check a study file and list its cells.
    #[command(after_help = "Example:\n  echolot study check studies/papers/ensemble.json --json")]
    Check {
        /// The study file.
        file: PathBuf,
    },
    /// Draw the figures of a study from its results, without computing anything.
    #[command(
        after_help = "Example:\n  echolot study draw studies/papers/ensemble.json --results results"
    )]
    Draw {
        /// The study file.
        file: PathBuf,
        /// Folder of the results; the study's folder is below it.
        #[arg(long, value_name = "DIR", default_value = "results")]
        results: PathBuf,
    },
    /// Print the JSON schema of study files.
    #[command(after_help = "Example:\n  echolot study schema > studies/study.schema.json")]
    Schema,
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        match self.command {
            Command::Check { file } => {
                let study = match Loaded::read(&file)? {
                    Loaded::Study(study) => study,
                    Loaded::Papers(papers) => {
                        let (name, about) = (&papers.file.name, &papers.file.about);
                        let names: Vec<_> =
                            papers.file.papers.iter().map(PaperStudy::name).collect();
                        let all =
                            serde_json::json!({"name": name, "about": about, "papers": names});
                        return match json {
                            true => print_json(&all),
                            false => print(&format!("{name}: {about}\n  {}\n", names.join("\n  "))),
                        };
                    }
                };
                let names: Vec<String> = study.cells.iter().map(|cell| cell.name()).collect();
                let methods: Vec<&str> =
                    study.methods().iter().map(|method| method.name()).collect();
                if json {
                    return print_json(&serde_json::json!({
                        "name": study.file.name,
                        "about": study.file.about,
                        "cells": names,
                        "methods": methods,
                        "claims": study.file.claims.len(),
                    }));
                }
                print(&format!(
                    "{}: {}\nmethods: {}\n{} cell(s):\n  {}\n",
                    study.file.name,
                    study.file.about,
                    methods.join(", "),
                    names.len(),
                    names.join("\n  ")
                ))
            }
            Command::Draw { file, results } => {
                let study = Study::load(&file)?;
                let drawn = figures::study::draw(&study, &results.join(&study.file.name))?;
                if json {
                    return print_json(&drawn);
                }
                drawn
                    .iter()
                    .try_for_each(|picture| print(&format!("{}\n", picture.display())))
            }
            Command::Schema => print_json(&papers::json_schema()),
        }
    }
}
