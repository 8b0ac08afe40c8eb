//! `echolot record`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Subcommand;

use super::alignment::AlignmentArguments;
use super::arguments::{ForceArgument, files_of_recording};
use super::output::{print, print_json};
use crate::check::CheckFailed;
use crate::data::place::Place;
use crate::figures;
use crate::figures::drawing::png;
use crate::inspection::{Inspection, Verdict};

/// Arguments of `record`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  echolot record check recordings/drive --figure drive.png")]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Look at a recording before it is trusted: sound, code, clocks, logs. Each line says ok, or what to do.
    #[command(after_help = "Example:\n  echolot record check recordings/drive\n  \
        echolot record check recordings/drive --figure drive.png --json\n\n\
        Exit code 1 when a line asks for something to be done before the recording is of use.")]
    Check {
        /// Recording folder.
        recording: PathBuf,
        /// Picture of level, spectrum, delays and speeds over time (PNG).
        #[arg(long, value_name = "PNG")]
        figure: Option<PathBuf>,
        #[command(flatten)]
        alignment: AlignmentArguments,
        #[command(flatten)]
        force: ForceArgument,
    },
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let Command::Check {
            recording,
            figure,
            alignment,
            force,
        } = self.command;
        if let Some(picture) = &figure {
            let inputs = [files_of_recording(&recording), alignment.files()].concat();
            let place = Place {
                inputs,
                ..Place::of(picture, force.force)
            };
            place.file(png::is_ours)?;
        }
        let inspection = Inspection::of(&recording, &alignment.options())?;
        if let Some(picture) = &figure {
            figures::inspection::draw(&inspection, picture)?;
            eprintln!("wrote {}", picture.display());
        }
        if json {
            print_json(&inspection.lines)?;
        } else {
            let width = inspection
                .lines
                .iter()
                .map(|line| line.name.len())
                .max()
                .unwrap_or(0);
            let mut text = String::new();
            for line in &inspection.lines {
                let verdict = match line.verdict {
                    Verdict::Ok => "ok",
                    Verdict::Mind => "mind",
                    Verdict::Bad => "BAD",
                };
                text += &format!("{verdict:<4}  {:<width$}  {}", line.name, line.found);
                if let Some(remedy) = &line.remedy {
                    text += &format!("; {remedy}");
                }
                text += "\n";
            }
            print(&text)?;
        }
        let bad = inspection
            .lines
            .iter()
            .filter(|line| line.verdict == Verdict::Bad)
            .count();
        match bad {
            0 => Ok(()),
            _ => {
                Err(CheckFailed(format!("{}: {bad} lines are not ok", recording.display())).into())
            }
        }
    }
}
