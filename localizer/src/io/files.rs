//! Reading with errors that name the file, writing to a temporary name that is then renamed.

use std::fs;
use std::path::Path;

use serde::de::DeserializeOwned;

use super::{json, temporary};
use crate::error::Error;

/// The text of a file.
pub(crate) fn read_text(path: &Path) -> Result<String, Error> {
    fs::read_to_string(path).map_err(|source| Error::io(path, source))
}

/// A JSON file as a structure.
pub(crate) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, Error> {
    json::parse(&read_text(path)?).map_err(|(field, problem)| {
        Error::invalid(
            path.display(),
            field,
            problem,
            "see the formats in docs/reference/recording.md and map.md",
        )
    })
}

/// Makes a folder and those above it.
pub(crate) fn make_folder(path: &Path) -> Result<(), Error> {
    fs::create_dir_all(path).map_err(|source| Error::io(path, source))
}

/// Writes a file whole or not at all: `fill` writes a temporary file beside it, which then takes the name. What is no
/// regular file is never replaced.
pub(crate) fn write_whole(
    path: &Path,
    fill: impl FnOnce(&Path) -> Result<(), Error>,
) -> Result<(), Error> {
    let of_system = |source| Error::io(path, source);
    temporary::check_file(path).map_err(of_system)?;
    let temporary = temporary::name_beside(path);
    let written =
        fill(&temporary).and_then(|()| temporary::put_file(&temporary, path).map_err(of_system));
    if written.is_err() {
        // The first error is the one to report; a temporary file that was never made cannot be removed either.
        let _ = fs::remove_file(&temporary);
    }
    written
}

/// Writes bytes with [`write_whole`].
pub(crate) fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    write_whole(path, |temporary| {
        fs::write(temporary, bytes).map_err(|source| Error::io(path, source))
    })
}

/// Writes a structure as indented JSON with a final newline.
pub(crate) fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<(), Error> {
    let mut text = serde_json::to_string_pretty(value).map_err(|problem| {
        Error::invalid(path.display(), "content", problem, "give finite numbers")
    })?;
    text.push('\n');
    write_bytes(path, text.as_bytes())
}

/// The first characters of a file's content, for an error message of one line.
pub(crate) fn shorten(text: &str) -> String {
    let mut letters = text.chars().filter(|letter| !letter.is_control());
    let short: String = letters.by_ref().take(40).collect();
    match letters.next() {
        Some(_) => short + "...",
        None => short,
    }
}
