//! Means over the trials of a study, with intervals.

use anyhow::Result;

use crate::data::table::Table;
use crate::metrics::{bootstrap_interval, mean};

/// Mean over the trials of each cell of a study: (cell, mean, interval), for the rows of `table` grouped by `key`.
pub(super) fn means_by(table: &Table, key: &str, value: &str) -> Result<Vec<(f64, f64, [f64; 2])>> {
    let mut cells: Vec<(f64, Vec<f64>)> = Vec::new();
    for (cell, number) in table.numbers(key)?.into_iter().zip(table.numbers(value)?) {
        match cells.iter_mut().find(|(known, _)| *known == cell) {
            Some((_, numbers)) => numbers.push(number),
            None => cells.push((cell, vec![number])),
        }
    }
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(cells
        .into_iter()
        .map(|(cell, numbers)| (cell, mean(&numbers), bootstrap_interval(&numbers)))
        .collect())
}
