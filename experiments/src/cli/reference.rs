//! `echolot reference`: the command line as a page of the documents.

use std::path::PathBuf;

use anyhow::Result;
use clap::Command;

use super::arguments::ForceArgument;
use super::output::print;
use crate::data::atomic;
use crate::data::place::Place;

/// How the page begins.
const BEGIN: &str =
    "# Command line\n\nWritten by `make reference` from the program; do not edit.\n";

/// Arguments of `reference`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot reference -o docs/reference/command-line.md\n\n\
    Prints the page unless a file is given."
)]
pub(crate) struct Arguments {
    /// Markdown file that is written.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: ForceArgument,
}

impl Arguments {
    /// Writes or prints the page.
    pub(crate) fn run(self, page: &str) -> Result<()> {
        match self.output {
            Some(file) => {
                let is_ours = |bytes: &[u8]| bytes.starts_with(BEGIN.as_bytes());
                Place::of(&file, self.force.force).file(is_ours)?;
                atomic::write(&file, page.as_bytes())
            }
            None => print(page),
        }
    }
}

/// The help of every command below `root` as one Markdown page.
pub(super) fn page(root: Command) -> String {
    let mut text = String::from(BEGIN);
    let mut root = root.term_width(100);
    root.build();
    describe(&mut root, &mut text);
    text
}

/// The help of a command, then those of its subcommands.
fn describe(command: &mut Command, text: &mut String) {
    let name = command.get_bin_name().unwrap_or_else(|| command.get_name());
    text.push_str(&format!("\n## {name}\n\n```text\n"));
    let help = command.render_long_help().to_string();
    for line in help.trim_end().lines() {
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text.push_str("```\n");
    for inner in command.get_subcommands_mut() {
        if inner.get_name() != "help" && !inner.is_hide_set() {
            describe(inner, text);
        }
    }
}
