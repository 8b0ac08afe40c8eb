//! The field against laws of physics: runs them, and writes table, data and figure.

mod data;
mod kept;
mod words;

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use anyhow::Result;
use oracles::laws::{Depth, Law, Measurement};
use rayon::prelude::*;
use serde::Serialize;

use crate::atomic;
use crate::figures;
use crate::interrupt;
use crate::progress::{Board, duration};
use crate::provenance::Provenance;

pub use self::kept::Kept;
pub use self::words::{laws, table};

/// One line of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The law.
    pub law: &'static str,
    /// What was measured.
    #[serde(flatten)]
    pub measurement: Measurement,
    /// Whether it is within its range.
    pub passed: bool,
}

/// Measures some laws but those that are kept; several run side by side, the order of the rows does not depend on it. Ctrl-C ends the program at once.
///
/// # Errors
/// When a field becomes non-finite, or what is measured cannot be kept.
pub fn run(laws: &[Law], depth: Depth, kept: Option<&Kept>) -> Result<Vec<Row>> {
    let _at_once = interrupt::at_once();
    let board = Board::new();
    let all: u64 = laws.iter().map(|law| effort(law, depth)).sum();
    let task = board.task("validate", all);
    let known: Vec<_> = (laws.iter())
        .map(|law| kept.and_then(|kept| kept.read(law.name)))
        .collect();
    let of_known = laws.iter().zip(&known).filter(|(_, known)| known.is_some());
    let done = AtomicU64::new(of_known.map(|(law, _)| effort(law, depth)).sum());
    task.set(done.load(Ordering::Relaxed));
    if kept.is_some() {
        let (measured, of) = (known.iter().flatten().count(), laws.len());
        board.say(format!(
            "{measured} of {of} laws are measured; interrupt at any time, the same command goes on"
        ));
    }
    let measure = |law: &Law| -> Result<Vec<Measurement>> {
        let started = Instant::now();
        let measurements = (law.measure)(depth)?;
        if let Some(kept) = kept {
            kept.write(law.name, &measurements)?;
        }
        let taken = duration(started.elapsed().as_secs_f64());
        board.say(format!("measured {} in {taken}", law.name));
        let effort = effort(law, depth);
        task.set(effort + done.fetch_add(effort, Ordering::Relaxed));
        Ok(measurements)
    };
    let found: Vec<Result<Vec<Row>>> = (laws.par_iter())
        .zip(known)
        .map(|(law, known)| {
            let measurements = known.map_or_else(|| measure(law), Ok)?;
            let rows = measurements.into_iter().map(|measurement| Row {
                law: law.name,
                passed: measurement.passed(),
                measurement,
            });
            Ok(rows.collect())
        })
        .collect();
    task.finish();
    let mut rows = Vec::new();
    for part in found {
        rows.extend(part?);
    }
    Ok(rows)
}

/// What a law takes beside others, for the time that is left.
fn effort(law: &Law, depth: Depth) -> u64 {
    u64::from(law.effort[usize::from(depth == Depth::Full)])
}

/// Writes `validation.json`, `table.md`, `laws.md` and the data of the figures into `folder`.
///
/// # Errors
/// When a file cannot be written.
pub fn write(rows: &[Row], depth: Depth, folder: &Path) -> Result<()> {
    let full = depth == Depth::Full;
    let json = serde_json::json!({
        "full": full, "provenance": Provenance::here(), "measurements": rows,
    });
    atomic::write(
        &folder.join("validation.json"),
        &serde_json::to_vec_pretty(&json)?,
    )?;
    let mut text = String::new();
    for (index, row) in words::cells(rows).iter().enumerate() {
        text.push_str(&format!("| {} |\n", row.join(" | ")));
        if index == 0 {
            text.push_str(&format!("|{}\n", "---|".repeat(row.len())));
        }
    }
    atomic::write(&folder.join("table.md"), text.as_bytes())?;
    atomic::write(&folder.join("laws.md"), laws(rows).as_bytes())?;
    let folder = folder.join("data");
    data::scene_echoes(depth, &folder)?;
    data::curves().write(&folder.join("dispersion.csv"))?;
    data::measured()?.write(&folder.join("velocity.csv"))
}

/// Draws the figures from the data in `folder`.
///
/// # Errors
/// When the data is missing or damaged, or the picture cannot be written.
pub fn draw(folder: &Path) -> Result<Vec<std::path::PathBuf>> {
    let (data, figures) = (folder.join("data"), folder.join("figures"));
    let pictures = ["fig_dispersion.png", "fig_scene_echoes.png"].map(|name| figures.join(name));
    figures::dispersion::draw(&data, &pictures[0])?;
    figures::scene_echoes::draw(&data, &pictures[1])?;
    Ok(pictures.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_that_are_kept_are_not_measured_again() {
        let results = tempfile::tempdir().unwrap();
        let kept = Kept::below(results.path(), Depth::Quick).unwrap();
        let number = |x: f64| vec![Measurement::below("case".to_string(), "level, dB", x, 1.0)];
        let law = |name, measure| Law {
            name,
            effort: [1, 1],
            measure,
        };
        let laws = [
            law("known", |_| unreachable!("it is kept")),
            law("new", |_| {
                Ok(vec![Measurement::below(
                    "case".to_string(),
                    "level, dB",
                    2.0,
                    1.0,
                )])
            }),
        ];
        kept.write("known", &number(0.5)).unwrap();
        let rows = run(&laws, Depth::Quick, Some(&kept)).unwrap();
        let said: Vec<_> = (rows.iter())
            .map(|row| (row.law, row.measurement.measured, row.passed))
            .collect();
        assert_eq!(said, [("known", 0.5, true), ("new", 2.0, false)]);
        assert_eq!(kept.read("new"), Some(number(2.0)));
        let kept_nothing = run(&laws[1..], Depth::Quick, None).unwrap();
        assert_eq!(kept_nothing.len(), 1);
    }
}
