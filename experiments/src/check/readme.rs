//! Generated parts of the project's README: tables of the results between marks.

use std::path::Path;

use anyhow::{Context, Result, bail};

use super::report::{count, ours, verdict};
use super::targets::Targets;
use super::verdicts::Judged;
use crate::data::{atomic, json};
use crate::run::progress::duration;
use crate::run::provenance::{Provenance, SIMULATIONS};
use crate::study::{self, StudySummary};

/// A generated part of a Markdown file: its name, and the text between its marks.
pub struct Block {
    name: &'static str,
    text: String,
}

impl Block {
    /// The lines before and after the block.
    fn marks(&self) -> [String; 2] {
        ["begin", "end"].map(|side| format!("<!-- {}: {side} -->", self.name))
    }
}

/// The claims that README shows, and their caveats: in how many of the random layouts each holds, where a study of
/// those asks for it, and our number in the papers' size. What that study claims of its own comes last.
pub fn claims(targets: &Targets, judged: &[Judged], layouts: Option<&StudySummary>) -> Block {
    let mut text = String::from(
        "| claim | where | paper | random layouts where it holds | papers' size: ours [95 % interval] | \
        verdict there |\n|---|---|---|---|---|---|\n",
    );
    let mut add = |cells: [&str; 6]| {
        let row = cells.map(|cell| cell.replace('|', "\\|")).join(" | ");
        text.push_str(&format!("| {row} |\n"));
    };
    let share = |id: &str| {
        let found = layouts.and_then(|study| study.claims.iter().find(|claim| claim.id == id));
        found.map_or(String::new(), share)
    };
    let mut asked = Vec::new();
    for id in &targets.shown {
        for judged in judged.iter().filter(|judged| judged.target.id == *id) {
            let target = &judged.target;
            asked.extend(target.layouts.as_deref());
            add([
                &target.claim,
                &target.source,
                &target.claimed,
                &target.layouts.as_deref().map_or(String::new(), share),
                &ours(judged),
                verdict(judged),
            ]);
        }
    }
    for claim in layouts.iter().flat_map(|study| &study.study.claims) {
        if claim.source.is_none() && !asked.contains(&claim.id.as_str()) {
            add([&claim.claim, "", "", &share(&claim.id), "", ""]);
        }
    }
    text.push_str(&format!("\nAll claims: {}.\n\n", count(judged)));
    for caveat in &targets.caveats {
        text.push_str(&format!("* {}\n", wrapped(caveat, "  ")));
    }
    Block {
        name: "claims",
        text,
    }
}

/// In how many layouts a claim holds, with the interval of the share.
fn share(claim: &study::claims::Judged) -> String {
    let words = claim.ours.trim_start_matches("in ");
    let words = words.trim_end_matches(" layouts");
    claim.interval.map_or(words.to_string(), |[low, high]| {
        format!("{words} [{low:.2}, {high:.2}]")
    })
}

/// The results of the study of random layouts; `None` where there are none.
///
/// # Errors
/// When they are damaged.
pub fn random_layouts(results: &Path) -> Result<Option<StudySummary>> {
    let file = results.join("ensemble").join("summary.json");
    match file.exists() {
        true => StudySummary::read(&file).map(Some),
        false => Ok(None),
    }
}

/// The commands for newcomers, with the durations of the committed results: those of the quick studies, and of the
/// papers' size.
pub fn commands(quick: &[Provenance], paper: &[Provenance]) -> Block {
    let mut text = String::from("| command | time | what comes out |\n|---|---|---|\n");
    for (command, time, what) in [
        (
            "make sim-quick",
            taken(quick),
            "the whole chain in a small scene, and all methods in two drawn at random; a line per stage, then tables \
            and figures in `results/quick` and `results/methods`",
        ),
        (
            "make sim-experiments",
            taken(paper),
            "the papers' studies in their size in `results/paper`, landmarks and SLAM beside them in \
            `results/landmarks_*`; goes on where it was interrupted",
        ),
        (
            "make validate",
            "more than an hour".to_string(),
            "the field against laws of physics: tolerances, measurements and verdicts in `results/validation`",
        ),
        (
            "make claims",
            "a moment".to_string(),
            "a verdict on every claim in `results/paper/report.md`, and the tables of this page; exits with 1 when a \
            verdict changed",
        ),
        ("make test", "minutes".to_string(), "all tests"),
    ] {
        text.push_str(&format!("| `{command}` | {time} | {what} |\n"));
    }
    Block {
        name: "commands",
        text,
    }
}

/// Provenance of the runs of `make sim-quick` and of `make sim-experiments` whose results are in a folder; `paper` is
/// that of the papers' studies.
///
/// # Errors
/// When a summary is damaged.
pub fn runs(results: &Path, paper: &Provenance) -> Result<[Vec<Provenance>; 2]> {
    #[derive(serde::Deserialize)]
    struct Run {
        provenance: Provenance,
    }
    let of = |names: &[&str]| -> Result<Vec<Provenance>> {
        let files = names
            .iter()
            .map(|name| results.join(name).join("summary.json"));
        files
            .filter(|file| file.exists())
            .map(|file| json::read::<Run>(&file).map(|run| run.provenance))
            .collect()
    };
    let mut large = vec![paper.clone()];
    large.extend(of(&[
        "landmarks_periods",
        "landmarks_noise",
        "landmarks_site",
    ])?);
    Ok([of(&["methods", "quick"])?, large])
}

/// Durations of all stages of runs, and the machine of the first; nothing without a run. Where a run did not simulate
/// all its recordings itself, they count as if one was simulated after the other, which is the most it can take.
fn taken(runs: &[Provenance]) -> String {
    let Some(first) = runs.first() else {
        return String::new();
    };
    let in_one = |run: &Provenance| run.seconds.contains_key(SIMULATIONS);
    let seconds = runs.iter().map(|run| {
        let stages: f64 = run.seconds.values().sum();
        match in_one(run) {
            true => stages,
            false => stages + run.simulation_seconds.values().sum::<f64>(),
        }
    });
    format!(
        "{}{} ({}, {} threads)",
        if runs.iter().all(in_one) {
            ""
        } else {
            "at most "
        },
        duration(seconds.sum()),
        first.cpu,
        first.threads
    )
}

/// A text in lines of at most 116 characters, the later ones behind `indent`.
fn wrapped(text: &str, indent: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last().map_or(0, |line| line.chars().count());
        if line > 0 && line + 1 + word.chars().count() > 116 {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines.join(&format!("\n{indent}"))
}

/// Replaces the text between the marks of each block in a Markdown text; `origin` is the file it came from.
///
/// # Errors
/// When the text lacks the marks of the first block. Other blocks may be left out.
pub fn fill(text: &str, origin: &Path, blocks: &[Block]) -> Result<String> {
    let mut text = text.to_string();
    for (index, block) in blocks.iter().enumerate() {
        let [begin, end] = block.marks();
        let parts = text
            .split_once(&begin)
            .and_then(|(before, rest)| Some((before, rest.split_once(&end)?.1)));
        match parts {
            Some((before, after)) => {
                text = format!("{before}{begin}\n{}{end}{after}", block.text);
            }
            None if index == 0 => bail!(
                "{}: has no lines {begin} and {end}; add them where the {} should stand",
                origin.display(),
                block.name
            ),
            None => {}
        }
    }
    Ok(text)
}

/// Writes blocks between their marks in a Markdown file.
///
/// # Errors
/// As [`fill`], and when the file cannot be read or written.
pub fn insert(file: &Path, blocks: &[Block]) -> Result<()> {
    let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
    atomic::write(file, fill(&text, file, blocks)?.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::verdicts::judge;
    use crate::summary::Summary;

    #[test]
    fn blocks_replace_the_text_between_their_marks() {
        let targets = Targets::load().unwrap();
        let summary = Summary::named("paper");
        let judged = judge(&targets, &summary).unwrap();
        let blocks = || {
            [
                claims(&targets, &judged, None),
                commands(&[], std::slice::from_ref(&summary.provenance)),
            ]
        };
        let folder = tempfile::tempdir().unwrap();
        let readme = folder.path().join("README.md");
        let old = "a\n<!-- claims: begin -->\nold\n<!-- claims: end -->\nb\n";
        std::fs::write(&readme, old).unwrap();
        insert(&readme, &blocks()).unwrap();
        let first = std::fs::read_to_string(&readme).unwrap();
        insert(&readme, &blocks()).unwrap();
        assert_eq!(first, std::fs::read_to_string(&readme).unwrap());
        assert!(
            first.starts_with("a\n<!--")
                && first.ends_with("-->\nb\n")
                && !first.contains("\nold\n")
        );
        let rows = first.lines().filter(|line| line.starts_with('|')).count();
        assert_eq!(rows, 2 + targets.shown.len());
        std::fs::write(&readme, "nothing").unwrap();
        assert!(insert(&readme, &blocks()).is_err());
    }

    #[test]
    fn long_texts_are_wrapped() {
        let text = "word ".repeat(60);
        let lines = wrapped(&text, "  ");
        assert!(lines.lines().all(|line| line.chars().count() <= 118));
        assert_eq!(lines.split_whitespace().count(), 60);
    }

    #[test]
    fn a_run_in_parts_takes_at_most_the_sum_of_its_simulations() {
        let mut run = Provenance::here();
        run.seconds = [("periods".to_string(), 30.0)].into();
        run.simulation_seconds = [("a".to_string(), 600.0), ("b".to_string(), 300.0)].into();
        assert!(taken(std::slice::from_ref(&run)).starts_with("at most 15 min 30 s ("));
        let mut whole = run.clone();
        whole.seconds.insert(SIMULATIONS.to_string(), 500.0);
        assert!(taken(std::slice::from_ref(&whole)).starts_with("8 min 50 s ("));
        assert!(taken(&[whole, run]).starts_with("at most 24 min 20 s ("));
    }
}
