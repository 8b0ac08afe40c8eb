//! Faults from outside: killed at any moment, no room on the disk, flipped bits, two at once. What a command had
//! written before is whole after it, and the same command then ends with the same bytes.
//!
//! Plain `cargo test` tries a few moments of each; `make robustness` tries all (`ECHOLOT_MOMENTS`), or those of the
//! commands that `ECHOLOT_CASES` names (`run,slam`).

mod bits;
mod disks;
mod kills;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::room::{drives, expect, quick_scene};

/// How many moments, or bits, are tried.
pub(super) fn moments(few: usize) -> usize {
    let wanted = std::env::var("ECHOLOT_MOMENTS").ok();
    wanted.and_then(|wanted| wanted.parse().ok()).unwrap_or(few)
}

/// Numbers spread over 0 to 1, the same in every run.
pub(super) fn spread(index: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    ((index as f64 + 0.37) * GOLDEN).fract()
}

/// A command, and the files that it writes; none of them holds a time.
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) command: Vec<&'static str>,
    pub(super) files: Vec<&'static str>,
}

/// The folder with scene, recordings and map, and the commands that are tried in it.
pub(super) fn cases(at: &Path) -> Vec<Case> {
    quick_scene(at);
    drives(at);
    expect(at, &["map", "mapping", "-o", "input"]);
    let case = |name, command: &[&'static str], files: &[&'static str]| Case {
        name,
        command: command.to_vec(),
        files: files.to_vec(),
    };
    let localize = [
        "localize",
        "drive",
        "--map",
        "input",
        "--window",
        "1.5",
        "-o",
        "drive.tum",
    ];
    let run = [
        "run",
        "quick.json",
        "--only",
        "odometry-drift",
        "--engine",
        "image-source",
        "--results",
        "results",
        "--cache",
        "cache",
        "--no-figures",
    ];
    let all = vec![
        case(
            "simulate",
            &["simulate", "room.json", "--path", "short", "-o", "short"],
            &["short/signal.wav", "short/odometry.csv", "short/truth.tum"],
        ),
        case(
            "map",
            &["map", "mapping", "-o", "map"],
            &[
                "map/map.json",
                "map/map.npy",
                "map/map_toa.npy",
                "map/map.pgm",
                "map/map.yaml",
            ],
        ),
        case(
            "map by landmarks",
            &["map", "mapping", "--method", "landmarks", "-o", "marks"],
            &["marks/landmarks.json", "marks/landmarks.pgm"],
        ),
        case("localize", &localize, &["drive.tum", "drive.csv"]),
        case(
            "slam",
            &["slam", "drive", "-o", "slam.tum", "--map-out", "slammed"],
            &["slam.tum", "slam.csv", "slammed/landmarks.json"],
        ),
        case("run", &run, &["results/quick/data/drift_paths.csv"]),
    ];
    let wanted = std::env::var("ECHOLOT_CASES").ok();
    let is_wanted = |case: &Case| {
        let mut names = wanted.iter().flat_map(|names| names.split(','));
        wanted.is_none() || names.any(|name| name == case.name)
    };
    all.into_iter().filter(is_wanted).collect()
}

pub(super) fn start(at: &Path, command: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_echolot"))
        .current_dir(at)
        .args(command)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

pub(super) fn contents(at: &Path, files: &[&str]) -> Vec<Option<Vec<u8>>> {
    files
        .iter()
        .map(|file| std::fs::read(at.join(file)).ok())
        .collect()
}

/// Names of temporary files anywhere below a folder.
pub(super) fn temporaries(at: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(at).unwrap().flatten() {
        if entry.file_name().to_string_lossy().starts_with(".tmp") {
            found.push(entry.path());
        } else if entry.path().is_dir() {
            found.extend(temporaries(&entry.path()));
        }
    }
    found
}
