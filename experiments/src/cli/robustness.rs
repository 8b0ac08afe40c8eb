//! `echolot robustness`: what was tried against wrong inputs and faults, as a page of the documents.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};

use super::arguments::ForceArgument;
use super::output::{print, print_json};
use crate::data::place::Place;
use crate::data::{atomic, json};

/// How the page begins.
const BEGIN: &str = "# What was tried\n\nWritten by `make robustness`; do not edit.\n";
/// Most tries that a line can stand for.
const MOST: u64 = 1_000_000_000_000;

/// Arguments of `robustness`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot robustness target/tried.jsonl -o docs/validation/robustness.md\n\n\
    `make robustness` runs the tests in full number and then this command. They append a JSON object a line, with \
    kind, what, count and result, to the file that the variable ECHOLOT_TRIED names. Prints the page unless a file is \
    given."
)]
pub(crate) struct Arguments {
    /// Lines that the tests have left.
    list: PathBuf,
    /// Markdown file that is written.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: ForceArgument,
}

/// Something that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Tried {
    /// Kind, as `kill -9`.
    kind: String,
    /// What it was tried on.
    what: String,
    /// How many times.
    count: u64,
    /// What came out.
    result: String,
}

impl Arguments {
    /// Writes or prints the page.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let tried = read(&self.list)?;
        if json {
            return print_json(&tried);
        }
        let page = page(&tried);
        let Some(file) = &self.output else {
            return print(&page);
        };
        let place = Place {
            inputs: vec![self.list.clone()],
            ..Place::of(file, self.force.force)
        };
        place.file(|bytes| bytes.starts_with(BEGIN.as_bytes()))?;
        atomic::write(file, page.as_bytes())
    }
}

/// Reads the lines; those of the same kind, subject and result are added up.
fn read(list: &Path) -> Result<Vec<Tried>> {
    let text = std::fs::read_to_string(list).with_context(|| list.display().to_string())?;
    let mut counts: BTreeMap<(String, String, String), u64> = BTreeMap::new();
    for (index, line) in text.lines().enumerate() {
        let tried: Tried =
            json::parse(line, list).with_context(|| format!("line {}", index + 1))?;
        if tried.count > MOST {
            bail!(
                "{}: line {}: count: {} is too large",
                list.display(),
                index + 1,
                tried.count
            );
        }
        *counts
            .entry((tried.kind, tried.what, tried.result))
            .or_default() += tried.count;
    }
    if counts.is_empty() {
        bail!(
            "{}: nothing was tried; run the tests with ECHOLOT_TRIED",
            list.display()
        );
    }
    let tried = counts
        .into_iter()
        .map(|((kind, what, result), count)| Tried {
            kind,
            what,
            count,
            result,
        });
    Ok(tried.collect())
}

/// The page.
fn page(tried: &[Tried]) -> String {
    let mut text = format!("{BEGIN}\n| kind | tried on | times | result |\n|---|---|---|---|\n");
    for row in tried {
        let plain = |words: &str| words.replace(['|', '\n'], " ");
        text += &format!(
            "| {} | {} | {} | {} |\n",
            plain(&row.kind),
            plain(&row.what),
            row.count,
            plain(&row.result)
        );
    }
    let all: u64 = tried.iter().map(|row| row.count).sum();
    text + &format!(
        "\n{all} tries in all; a try with another result fails the test that makes it.\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_a_table() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join("tried.jsonl");
        let line = |count| {
            format!(r#"{{"kind": "kill", "what": "map", "count": {count}, "result": "whole"}}"#)
        };
        std::fs::write(&list, format!("{}\n{}\n", line(3), line(4))).unwrap();
        let page = page(&read(&list).unwrap());
        assert!(
            page.contains("| kill | map | 7 | whole |") && page.contains("7 tries"),
            "{page}"
        );
        for (text, word) in [
            ("", "nothing was tried"),
            ("{}\n", "line 1"),
            ("x\n", "line 1"),
        ] {
            std::fs::write(&list, text).unwrap();
            let error = format!("{:#}", read(&list).unwrap_err());
            assert!(
                error.contains(word) && error.contains("tried.jsonl"),
                "{error}"
            );
        }
    }
}
