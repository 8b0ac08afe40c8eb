//! Hashes the localizer's source, so that cached trials of other code are not reused.

use std::hash::Hasher;
use std::path::{Path, PathBuf};

use fnv::FnvHasher;

/// From the package's folder, where build scripts run; relative, so that a copied build folder is not up to date by
/// mistake.
const LOCALIZER: &str = "../localizer/src";

fn main() {
    println!("cargo::rerun-if-changed={LOCALIZER}");
    let mut files = Vec::new();
    collect(Path::new(LOCALIZER), &mut files);
    files.sort();
    let mut hasher = FnvHasher::default();
    for file in files {
        println!("cargo::rerun-if-changed={}", file.display());
        hasher.write(&std::fs::read(&file).unwrap_or_default());
    }
    println!(
        "cargo::rustc-env=LOCALIZER_FINGERPRINT={:016x}",
        hasher.finish()
    );
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}
