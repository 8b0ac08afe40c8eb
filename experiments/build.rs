//! Hashes sources, so that cached trials and measured laws of other code are not reused.

use std::hash::Hasher;
use std::path::{Path, PathBuf};

use fnv::FnvHasher;

/// Folders by the variable that holds their hash: from the package's folder, where build scripts run; relative, so
/// that a copied build folder is not up to date by mistake.
const HASHED: [(&str, &[&str]); 2] = [
    ("LOCALIZER_FINGERPRINT", &["../localizer/src"]),
    ("FIELD_FINGERPRINT", &["../fdtd/src", "../oracles/src"]),
];

/// How scene files are spelt, checked and drawn at random: no law asks for it.
const NOT_PHYSICS: [&str; 7] = [
    "fdtd/src/scene/check.rs",
    "fdtd/src/scene/clearance.rs",
    "fdtd/src/scene/file.rs",
    "fdtd/src/scene/locate.rs",
    "fdtd/src/scene/path_file.rs",
    "fdtd/src/scene/random.rs",
    "fdtd/src/scene/wall_file.rs",
];

fn main() {
    for (variable, folders) in HASHED {
        let mut files = Vec::new();
        for folder in folders {
            println!("cargo::rerun-if-changed={folder}");
            collect(Path::new(folder), &mut files);
        }
        files.sort();
        files.retain(|file| !NOT_PHYSICS.iter().any(|name| file.ends_with(name)));
        let mut hasher = FnvHasher::default();
        for file in files {
            println!("cargo::rerun-if-changed={}", file.display());
            hasher.write(&std::fs::read(&file).unwrap_or_default());
        }
        println!("cargo::rustc-env={variable}={:016x}", hasher.finish());
    }
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
