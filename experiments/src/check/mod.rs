//! Verdicts on a summary: against a baseline (regression gate) and against the paper's claims.

pub mod gate;
pub mod readme;
pub mod report;
pub mod targets;

mod rules;

/// What a command returns when a check did not pass; the table has been printed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CheckFailed(
    /// One line that says what failed.
    pub String,
);

impl std::fmt::Display for CheckFailed {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl std::error::Error for CheckFailed {}

/// Lays out rows of cells as columns of even width, the first row as header.
pub fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns)
        .map(|column| {
            rows.iter()
                .filter_map(|row| row.get(column))
                .map(|cell| cell.chars().count())
                .max()
                .unwrap_or(0)
        })
        .collect();
    let mut text = String::new();
    for row in rows {
        let line: Vec<String> = row
            .iter()
            .zip(&widths)
            .map(|(cell, width)| format!("{cell:<width$}"))
            .collect();
        text.push_str(line.join("  ").trim_end());
        text.push('\n');
    }
    text
}
