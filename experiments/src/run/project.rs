//! Files of the project, wherever the program runs.

use std::path::{Path, PathBuf};

/// A file of the project: in the folder in which the program runs, else in the project's own, wherever that is. The
/// path itself where there is no such file.
pub fn file(path: &Path) -> PathBuf {
    let program = std::env::current_exe().unwrap_or_default();
    let built = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    let folders = program.ancestors().skip(1).chain(built);
    let elsewhere = folders
        .map(|folder| folder.join(path))
        .find(|found| found.exists());
    match path.exists() {
        true => path.to_owned(),
        false => elsewhere.unwrap_or_else(|| path.to_owned()),
    }
}
