//! Tables of numbers and words: the CSV files between the studies that compute and the figures that draw.

use std::path::Path;

use anyhow::{Context, Result, bail};

use super::atomic;

/// A table with named columns. Cells hold neither commas nor line breaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
    origin: String,
}

impl Table {
    /// An empty table with these columns.
    pub fn new<'a>(header: impl IntoIterator<Item = &'a str>) -> Self {
        Self {
            header: header.into_iter().map(str::to_string).collect(),
            rows: Vec::new(),
            origin: "table".to_string(),
        }
    }

    /// Adds a row; missing cells are empty, surplus ones dropped.
    pub fn push(&mut self, row: impl IntoIterator<Item = String>) {
        let mut cells: Vec<String> = row
            .into_iter()
            .map(|cell| cell.replace([',', '\n', '\r'], " "))
            .collect();
        cells.resize(self.header.len(), String::new());
        self.rows.push(cells);
    }

    /// The names of the columns.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    fn position(&self, column: &str) -> Result<usize> {
        self.header
            .iter()
            .position(|name| name == column)
            .with_context(|| {
                format!(
                    "{}: column {column}: not there; the columns are {}",
                    self.origin,
                    self.header.join(", ")
                )
            })
    }

    /// The words of a column.
    ///
    /// # Errors
    /// When there is no such column.
    pub fn words(&self, column: &str) -> Result<Vec<&str>> {
        let position = self.position(column)?;
        Ok(self.rows.iter().map(|row| row[position].as_str()).collect())
    }

    /// The numbers of a column.
    ///
    /// # Errors
    /// When there is no such column or a cell is no number.
    pub fn numbers(&self, column: &str) -> Result<Vec<f64>> {
        self.words(column)?
            .iter()
            .enumerate()
            .map(|(row, word)| {
                word.parse().with_context(|| {
                    format!(
                        "{}: line {}, column {column}: '{word}' is no number",
                        self.origin,
                        row + 2
                    )
                })
            })
            .collect()
    }

    /// The rows in which `column` holds `word`, as a table of their own.
    ///
    /// # Errors
    /// When there is no such column.
    pub fn only(&self, column: &str, word: &str) -> Result<Self> {
        let position = self.position(column)?;
        Ok(Self {
            header: self.header.clone(),
            rows: self
                .rows
                .iter()
                .filter(|row| row[position] == word)
                .cloned()
                .collect(),
            origin: self.origin.clone(),
        })
    }

    /// The different words of a column in order of appearance.
    ///
    /// # Errors
    /// When there is no such column.
    pub fn distinct(&self, column: &str) -> Result<Vec<String>> {
        let mut found: Vec<String> = Vec::new();
        for word in self.words(column)? {
            if !found.iter().any(|known| known == word) {
                found.push(word.to_string());
            }
        }
        Ok(found)
    }

    /// Writes the table as CSV.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut text = self.header.join(",");
        text.push('\n');
        for row in &self.rows {
            text.push_str(&row.join(","));
            text.push('\n');
        }
        atomic::write(path, text.as_bytes())
    }

    /// Reads a CSV file with a header line.
    ///
    /// # Errors
    /// When the file cannot be read, is empty, or a line has another number of cells than the header.
    pub fn read(path: &Path) -> Result<Self> {
        let origin = path.display().to_string();
        let text = std::fs::read_to_string(path).with_context(|| origin.clone())?;
        Self::parse(&text, &origin)
    }

    /// Reads the text of a CSV file with a header line; errors name `origin`.
    ///
    /// # Errors
    /// As [`Table::read`].
    pub fn parse(text: &str, origin: &str) -> Result<Self> {
        let mut lines = text.lines();
        let header: Vec<String> = match lines.next() {
            Some(line) => line
                .split(',')
                .map(|name| name.trim().to_string())
                .collect(),
            None => bail!("{origin}: is empty; run the study again"),
        };
        let mut rows = Vec::new();
        for (index, line) in lines.enumerate().filter(|(_, line)| !line.is_empty()) {
            let row: Vec<String> = line
                .split(',')
                .map(|cell| cell.trim().to_string())
                .collect();
            if row.len() != header.len() {
                bail!(
                    "{origin}: line {}: {} cells; the header has {}",
                    index + 2,
                    row.len(),
                    header.len()
                );
            }
            rows.push(row);
        }
        Ok(Self {
            header,
            rows,
            origin: origin.to_string(),
        })
    }
}

/// A number as a cell: `digits` decimals, without negative zero.
pub fn cell(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let is_zero = text
        .trim_start_matches('-')
        .bytes()
        .all(|byte| byte == b'0' || byte == b'.');
    match text.strip_prefix('-') {
        Some(rest) if is_zero => rest.to_string(),
        _ => text,
    }
}

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

/// Rows as a Markdown table, their head first.
pub fn markdown(rows: &[Vec<String>]) -> String {
    let mut text = String::new();
    for (index, row) in rows.iter().enumerate() {
        let cells: Vec<String> = row.iter().map(|cell| cell.replace('|', "\\|")).collect();
        text.push_str(&format!("| {} |\n", cells.join(" | ")));
        if index == 0 {
            text.push_str(&format!("|{}\n", "---|".repeat(row.len())));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_as_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data/a.csv");
        let mut table = Table::new(["method", "mae_m"]);
        table.push(["doppler".to_string(), cell(0.04, 3)]);
        table.push(["toa,only".to_string(), cell(-0.0, 1)]);
        table.write(&path).unwrap();
        let read = Table::read(&path).unwrap();
        assert_eq!(read.words("method").unwrap(), ["doppler", "toa only"]);
        assert_eq!(read.numbers("mae_m").unwrap(), [0.04, 0.0]);
        assert_eq!(read.only("method", "doppler").unwrap().len(), 1);
        assert_eq!(read.distinct("method").unwrap().len(), 2);
        let error = read.numbers("mae").unwrap_err().to_string();
        assert!(error.contains("a.csv: column mae: not there"), "{error}");
    }

    #[test]
    fn damaged_files_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("b.csv");
        std::fs::write(&path, "a,b\n1,2\n3\n").unwrap();
        let error = Table::read(&path).unwrap_err().to_string();
        assert!(error.contains("b.csv: line 3: 1 cells"), "{error}");
        std::fs::write(&path, "a,b\n1,x\n").unwrap();
        let error = Table::read(&path)
            .unwrap()
            .numbers("b")
            .unwrap_err()
            .to_string();
        assert!(error.contains("line 2, column b: 'x'"), "{error}");
    }
}
