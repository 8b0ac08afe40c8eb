//! `summary.json` of a study: the study itself, provenance, scores of every cell and method, claims.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Study;
use super::cells::{DRAWN, Draw};
use super::claims::Judged;
use super::file::{MethodName, StudyFile};
use super::interval::mean_and_interval;
use super::scores::{Measure, Row};
use crate::data::table::aligned;
use crate::data::{atomic, json};
use crate::metrics::rounded;
use crate::run::provenance::Provenance;

/// The results of a study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudySummary {
    /// The study.
    pub study: StudyFile,
    /// Provenance.
    pub provenance: Provenance,
    /// Scores of every cell and method.
    pub cells: Vec<CellScores>,
    /// Claims beside what came out.
    pub claims: Vec<Judged>,
}

/// The scores of a method in a cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellScores {
    /// Name of the cell.
    pub cell: String,
    /// What tells it from the others.
    pub labels: BTreeMap<String, String>,
    /// The method.
    pub method: MethodName,
    /// Number of trials.
    pub trials: usize,
    /// Trials in which the method gave no poses; they are in no score.
    pub failed: usize,
    /// How many of each were drawn.
    pub drawn: BTreeMap<String, usize>,
    /// Mean of each measure over all that was drawn.
    pub mean: BTreeMap<String, f64>,
    /// 95 % intervals of the means by nested bootstrap over all that was drawn more than once.
    pub interval: BTreeMap<String, [f64; 2]>,
    /// Greatest mean distance of a trial, metres.
    pub worst_mae_m: Option<f64>,
}

impl CellScores {
    /// The scores of all cells and methods that have trials.
    pub fn all(study: &Study, rows: &[Row]) -> Vec<Self> {
        let mut groups: BTreeMap<(usize, usize), Vec<&Row>> = BTreeMap::new();
        for row in rows {
            groups.entry((row.cell, row.method)).or_default().push(row);
        }
        let methods = study.methods();
        let groups: Vec<_> = groups.into_iter().collect();
        groups
            .into_par_iter()
            .map(|((cell, method), rows)| {
                let cell = &study.cells[cell];
                let drawn = DRAWN.iter().enumerate().map(|(level, name)| {
                    let mut numbers: Vec<u64> = rows.iter().map(|row| row.draw[level]).collect();
                    numbers.sort_unstable();
                    numbers.dedup();
                    ((*name).to_string(), numbers.len())
                });
                let (mut mean, mut interval) = (BTreeMap::new(), BTreeMap::new());
                for measure in Measure::ALL {
                    let values: Vec<(Draw, f64)> = rows
                        .iter()
                        .filter_map(|row| Some((row.draw, row.value(measure)?)))
                        .collect();
                    if !values.is_empty() {
                        let (middle, ends) = mean_and_interval(&values);
                        mean.insert(measure.name().to_string(), rounded(middle));
                        interval.insert(measure.name().to_string(), ends.map(rounded));
                    }
                }
                let worst = rows
                    .iter()
                    .filter_map(|row| row.value(Measure::MaeM))
                    .reduce(f64::max);
                Self {
                    cell: cell.name(),
                    labels: cell.labels.iter().cloned().collect(),
                    method: methods[method],
                    trials: rows.len(),
                    failed: rows.iter().filter(|row| row.failure.is_some()).count(),
                    drawn: drawn.collect(),
                    mean,
                    interval,
                    worst_mae_m: worst.map(rounded),
                }
            })
            .collect()
    }

    /// What its intervals are over, in words.
    pub fn over(&self) -> String {
        let parts: Vec<String> = DRAWN
            .iter()
            .filter_map(|name| {
                let count = *self.drawn.get(*name)?;
                (count > 1).then(|| format!("{count} {name}s"))
            })
            .collect();
        match parts.is_empty() {
            true => "one trial".to_string(),
            false => parts.join(" x "),
        }
    }
}

impl StudySummary {
    /// Reads a summary.
    ///
    /// # Errors
    /// When the file cannot be read or is no summary of a study.
    pub fn read(path: &Path) -> Result<Self> {
        json::read(path)
    }

    /// Writes the summary, indented.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        atomic::write(path, text.as_bytes())
    }
}

/// The claims and scores of a summary as Markdown: `report.md`.
pub(super) fn markdown(summary: &StudySummary) -> String {
    let cell = |text: &str| text.replace('|', "\\|");
    let study = &summary.study;
    let mut text = format!(
        "# {}\n\n{}\n\nWritten by `echolot run` (revision {}); do not edit.\n",
        study.name, study.about, summary.provenance.commit
    );
    if !summary.claims.is_empty() {
        text.push_str(
            "\n| claim | claimed | ours [95 % interval] | verdict |\n|---|---|---|---|\n",
        );
    }
    for (claim, judged) in study.claims.iter().zip(&summary.claims) {
        let interval = judged.interval.map_or(String::new(), |[low, high]| {
            format!(" [{low:.3}, {high:.3}]")
        });
        text.push_str(&format!(
            "| {} | {} | {}{interval} | {} |\n",
            cell(&claim.claim),
            cell(claim.claimed.as_deref().unwrap_or("")),
            cell(&judged.ours),
            judged.verdict.name().to_lowercase(),
        ));
    }
    text.push_str(
        "\n| cell | method | MAE [m] | 95 % interval | 90 % below | worst trial | newest pose | trials | \
         interval over |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    for scores in &summary.cells {
        let number =
            |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.4}"));
        let mean = |name: &str| number(scores.mean.get(name).copied());
        let interval = scores
            .interval
            .get("mae_m")
            .map_or(String::new(), |[low, high]| {
                format!("{low:.4} to {high:.4}")
            });
        let failed = match scores.failed {
            0 => String::new(),
            failed => format!(", {failed} failed"),
        };
        text.push_str(&format!(
            "| {} | {} | {} | {interval} | {} | {} | {} | {}{failed} | {} |\n",
            cell(&scores.cell),
            scores.method.name(),
            mean("mae_m"),
            mean("p90_m"),
            number(scores.worst_mae_m),
            mean("latest_mae_m"),
            scores.trials,
            scores.over(),
        ));
    }
    text
}

/// The scores and claims of a summary as text.
pub fn table(summary: &StudySummary) -> String {
    let mut rows = vec![
        [
            "cell",
            "method",
            "MAE [m]",
            "95 % interval [m]",
            "90 % below [m]",
            "worst trial [m]",
            "interval over",
        ]
        .map(String::from)
        .to_vec(),
    ];
    for scores in &summary.cells {
        let number = |name: &str| {
            let mean = scores.mean.get(name);
            mean.map_or("-".to_string(), |mean| format!("{mean:.4}"))
        };
        let interval = scores.interval.get("mae_m").filter(|_| scores.trials > 1);
        let failed = match scores.failed {
            0 => String::new(),
            failed => format!("; {failed} of {} failed", scores.trials),
        };
        rows.push(vec![
            scores.cell.clone(),
            scores.method.name().to_string(),
            number("mae_m"),
            interval.map_or("-".to_string(), |[low, high]| {
                format!("{low:.4} to {high:.4}")
            }),
            number("p90_m"),
            scores
                .worst_mae_m
                .map_or("-".to_string(), |worst| format!("{worst:.4}")),
            format!("{}{failed}", scores.over()),
        ]);
    }
    let mut text = aligned(&rows);
    for (claim, judged) in summary.study.claims.iter().zip(&summary.claims) {
        let verdict = judged.verdict.name();
        let interval = judged.interval.map_or(String::new(), |[low, high]| {
            format!(" [{low:.3} to {high:.3}]")
        });
        text.push_str(&format!(
            "{verdict}: {}: {}{interval}\n",
            claim.claim, judged.ours
        ));
    }
    text
}
