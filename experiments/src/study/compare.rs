//! Two results of a study side by side: differences of the trials that both have, cell by cell.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Result, bail};
use serde::Serialize;

use super::cells::{DRAWN, Draw};
use super::interval::mean_and_interval;
use super::scores::{Measure, numbers};
use crate::data::table::{Table, aligned};
use crate::metrics::{mean, rounded};

/// The difference of a method in a cell.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// Name of the cell.
    pub cell: String,
    /// The method.
    pub method: String,
    /// Trials that both results have.
    pub trials: usize,
    /// Mean of the first.
    pub a: f64,
    /// Mean of the second.
    pub b: f64,
    /// Mean of second less first over the trials.
    pub difference: f64,
    /// Its 95 % interval by nested bootstrap over all that was drawn.
    pub interval: [f64; 2],
}

/// The trials of a results folder by cell, method and draw.
type Trials = BTreeMap<(String, String), BTreeMap<Draw, f64>>;

/// Differences of a measure between the trials of two results folders, by cells and methods that both have.
///
/// # Errors
/// When a table of trials is missing or damaged, or nothing is in both.
pub fn differences(a: &Path, b: &Path, measure: Measure) -> Result<Vec<Difference>> {
    let (one, other) = (read(a, measure)?, read(b, measure)?);
    let mut found = Vec::new();
    for ((cell, method), trials) in &one {
        let Some(others) = other.get(&(cell.clone(), method.clone())) else {
            continue;
        };
        let pairs: Vec<(Draw, f64, f64)> = trials
            .iter()
            .filter_map(|(draw, value)| Some((*draw, *value, *others.get(draw)?)))
            .collect();
        if pairs.is_empty() {
            continue;
        }
        let values: Vec<(Draw, f64)> = pairs.iter().map(|(draw, a, b)| (*draw, b - a)).collect();
        let (difference, interval) = mean_and_interval(&values);
        let mean_of = |pick: &dyn Fn(&(Draw, f64, f64)) -> f64| {
            rounded(mean(&pairs.iter().map(pick).collect::<Vec<_>>()))
        };
        found.push(Difference {
            cell: cell.clone(),
            method: method.clone(),
            trials: pairs.len(),
            a: mean_of(&|pair| pair.1),
            b: mean_of(&|pair| pair.2),
            difference: rounded(difference),
            interval: interval.map(rounded),
        });
    }
    if found.is_empty() {
        bail!(
            "{} and {}: have no trial of one cell, method and seeds in common; compare results of one study",
            a.display(),
            b.display()
        );
    }
    Ok(found)
}

/// The trials of a results folder that have the measure.
fn read(folder: &Path, measure: Measure) -> Result<Trials> {
    let table = Table::read(&folder.join("data/trials.csv"))?;
    let header = table.header();
    let labels: Vec<&String> = header.iter().take_while(|name| *name != "method").collect();
    let label_words = labels
        .iter()
        .map(|name| table.words(name))
        .collect::<Result<Vec<_>>>()?;
    let methods = table.words("method")?;
    let draws = DRAWN
        .iter()
        .map(|name| table.numbers(name))
        .collect::<Result<Vec<_>>>()?;
    let mut trials = Trials::new();
    for (row, value) in numbers(&table, measure)?.into_iter().enumerate() {
        let Some(value) = value else { continue };
        let parts: Vec<String> = labels
            .iter()
            .zip(&label_words)
            .map(|(name, words)| format!("{} = {}", super::cells::short(name), words[row]))
            .collect();
        let cell = if parts.is_empty() {
            "all".to_string()
        } else {
            parts.join(", ")
        };
        let draw: Draw = std::array::from_fn(|level| draws[level][row] as u64);
        trials
            .entry((cell, methods[row].to_string()))
            .or_default()
            .insert(draw, value);
    }
    Ok(trials)
}

/// The differences as text.
pub fn table(differences: &[Difference], measure: Measure) -> String {
    let mut rows = vec![
        [
            "cell",
            "method",
            "A",
            "B",
            "B - A",
            "95 % interval",
            "trials",
            "",
        ]
        .map(String::from)
        .to_vec(),
    ];
    for found in differences {
        let [low, high] = found.interval;
        let verdict = match (found.trials > 1, low > 0.0, high < 0.0) {
            (true, true, _) => "B is larger",
            (true, _, true) => "B is smaller",
            _ => "",
        };
        rows.push(vec![
            found.cell.clone(),
            found.method.clone(),
            format!("{:.4}", found.a),
            format!("{:.4}", found.b),
            format!("{:+.4}", found.difference),
            format!("{low:+.4} to {high:+.4}"),
            found.trials.to_string(),
            verdict.to_string(),
        ]);
    }
    format!("{}\n{}", measure.title(), aligned(&rows))
}
