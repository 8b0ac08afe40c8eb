//! The field against laws of physics: runs them, and writes table, data and figure.

mod data;
mod words;

use std::path::Path;

use anyhow::Result;
use fdtd::validation::{Depth, Law, Measurement};
use rayon::prelude::*;
use serde::Serialize;

use crate::atomic;
use crate::figures;
use crate::interrupt;
use crate::progress::Board;
use crate::provenance::Provenance;

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

/// Measures some laws; several run side by side, the order of the rows does not depend on it.
///
/// # Errors
/// When a field becomes non-finite, or [`interrupt::Interrupted`].
pub fn run(laws: &[Law], depth: Depth) -> Result<Vec<Row>> {
    let board = Board::new();
    let task = board.task("validate", laws.len() as u64);
    let done = std::sync::atomic::AtomicU64::new(0);
    let found: Vec<Result<Vec<Row>>> = laws
        .par_iter()
        .map(|law| {
            interrupt::check()?;
            let measurements = (law.measure)(depth)?;
            task.set(1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed));
            Ok(measurements
                .into_iter()
                .map(|measurement| Row {
                    law: law.name,
                    passed: measurement.passed(),
                    measurement,
                })
                .collect())
        })
        .collect();
    task.finish();
    let mut rows = Vec::new();
    for part in found {
        rows.extend(part?);
    }
    Ok(rows)
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
    data::measured(depth)?.write(&folder.join("velocity.csv"))
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
