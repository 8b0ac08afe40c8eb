//! Hashes the localizer's source, so that cached trials of other code are not reused.

use std::path::{Path, PathBuf};

/// From the package's folder, where build scripts run; relative, so that a copied build folder is not up to date by
/// mistake.
const LOCALIZER: &str = "../localizer/src";

fn main() {
    println!("cargo::rerun-if-changed={LOCALIZER}");
    let mut files = Vec::new();
    collect(Path::new(LOCALIZER), &mut files);
    files.sort();
    // FNV-1a, 64 bits.
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for file in files {
        println!("cargo::rerun-if-changed={}", file.display());
        for byte in std::fs::read(&file).unwrap_or_default() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    println!("cargo::rustc-env=LOCALIZER_FINGERPRINT={hash:016x}");
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
