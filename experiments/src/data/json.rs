//! JSON files whose errors name the file, the field and the place.

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use serde::de::DeserializeOwned;

/// Reads a JSON file.
///
/// # Errors
/// When the file cannot be read, and as [`parse`].
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    parse(&text, path)
}

/// Reads JSON text; errors name `origin`.
///
/// # Errors
/// One line with the file, the field, the problem and its line.
pub fn parse<T: DeserializeOwned>(text: &str, origin: &Path) -> Result<T> {
    localizer::io::json::parse(text)
        .map_err(|(field, problem)| anyhow!("{}: {field}: {problem}; correct it", origin.display()))
}
