//! Faults from outside: killed at any moment, no room on the disk, flipped bits, two at once. What a command had
//! written before is whole after it, and the same command then ends with the same bytes.
//!
//! Plain `cargo test` tries a few moments of each; `make robustness` tries all (`ECHOLOT_MOMENTS`).

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::room::{echolot, expect, note, scene_file};

/// How many moments, or bits, are tried.
fn moments(few: usize) -> usize {
    let wanted = std::env::var("ECHOLOT_MOMENTS").ok();
    wanted.and_then(|wanted| wanted.parse().ok()).unwrap_or(few)
}

/// Numbers spread over 0 to 1, the same in every run.
fn spread(index: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    ((index as f64 + 0.37) * GOLDEN).fract()
}

/// A command, and the files that it writes; none of them holds a time.
struct Case {
    name: &'static str,
    command: Vec<&'static str>,
    files: Vec<&'static str>,
}

/// The folder with scene, recordings and map, and the commands that are tried in it.
fn cases(at: &Path) -> Vec<Case> {
    scene_file(at);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    std::fs::create_dir(at.join("scenes")).unwrap();
    std::fs::copy(root.join("scenes/quick.json"), at.join("scenes/quick.json")).unwrap();
    for (path, output) in [("mapping", "mapping"), ("localization", "drive")] {
        let simulate = ["simulate", "room.json", "--path", path, "-o", output];
        expect(at, &[&simulate[..], &["--engine", "image-source"]].concat());
    }
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
        "odometry-drift",
        "--preset",
        "quick",
        "--engine",
        "image-source",
        "--results",
        "results",
        "--cache",
        "cache",
        "--no-figures",
    ];
    vec![
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
        case("run", &run, &["results/quick/data/drift_paths.csv"]),
    ]
}

fn start(at: &Path, command: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_echolot"))
        .current_dir(at)
        .args(command)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

fn contents(at: &Path, files: &[&str]) -> Vec<Option<Vec<u8>>> {
    files
        .iter()
        .map(|file| std::fs::read(at.join(file)).ok())
        .collect()
}

/// Names of temporary files anywhere below a folder.
fn temporaries(at: &Path) -> Vec<PathBuf> {
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

#[test]
fn a_kill_at_any_moment_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for Case {
        name,
        command,
        files,
    } in cases(at)
    {
        let started = Instant::now();
        expect(at, &command);
        let length_s = started.elapsed().as_secs_f64();
        let whole = contents(at, &files);
        assert!(whole.iter().all(Option::is_some), "{name}");
        let (count, mut killed) = (moments(2), 0);
        for index in 0..count {
            // Every other time there is nothing yet, or for `run` nothing in the cache.
            let anew = index % 2 == 1;
            if anew && name == "run" {
                std::fs::remove_dir_all(at.join("cache")).unwrap();
            } else if anew {
                for file in &files {
                    let top = at.join(file.split('/').next().unwrap());
                    if top.is_dir() {
                        std::fs::remove_dir_all(top).unwrap();
                    } else if top.exists() {
                        std::fs::remove_file(top).unwrap();
                    }
                }
            }
            let before = contents(at, &files);
            let mut child = start(at, &command);
            std::thread::sleep(Duration::from_secs_f64(length_s * spread(index)));
            child.kill().unwrap();
            killed += usize::from(!child.wait().unwrap().success());
            // Each file is the old one or the new one, or not there when it was not there.
            for ((file, before), after) in files.iter().zip(&before).zip(contents(at, &files)) {
                let new = whole[files.iter().position(|other| other == file).unwrap()].as_ref();
                assert!(
                    after == *before || after.as_ref() == new,
                    "{name}, kill {index}: {file}"
                );
            }
            expect(at, &command);
            assert_eq!(contents(at, &files), whole, "{name}, kill {index}");
            assert_eq!(
                temporaries(at),
                Vec::<PathBuf>::new(),
                "{name}, kill {index}"
            );
        }
        note(
            "kill -9",
            name,
            killed,
            "files whole, the next run ends with the same bytes",
        );
    }
}

/// Writes fail beyond a size of file, as on a full disk: first the probe, then one file after the other.
#[cfg(unix)]
#[test]
fn a_disk_without_room_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for Case {
        name,
        command,
        files,
    } in cases(at)
    {
        expect(at, &command);
        let whole = contents(at, &files);
        let sizes: Vec<u64> = files
            .iter()
            .map(|file| std::fs::metadata(at.join(file)).unwrap().len())
            .collect();
        let largest = sizes.iter().copied().max().unwrap();
        if name == "run" {
            std::fs::remove_dir_all(at.join("cache")).unwrap();
        }
        let (count, mut refused) = (moments(3).min(20), 0);
        for index in 0..count {
            // In blocks of 512 bytes, from nothing to just below the largest file.
            let limit = (spread(index) * largest as f64 / 512.0) as u64;
            let limited = format!(
                "trap '' XFSZ; ulimit -f {limit}; exec {} {}",
                env!("CARGO_BIN_EXE_echolot"),
                command.join(" ")
            );
            let output = Command::new("sh")
                .current_dir(at)
                .args(["-c", &limited])
                .output()
                .unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            if !output.status.success() {
                refused += 1;
                assert_eq!(output.status.code(), Some(2), "{name}: {said}");
                assert!(said.contains("error: "), "{name}: {said}");
                assert_eq!(
                    contents(at, &files),
                    whole,
                    "{name}, {limit} blocks: {said}"
                );
            }
            assert_eq!(
                temporaries(at),
                Vec::<PathBuf>::new(),
                "{name}, {limit} blocks"
            );
        }
        expect(at, &command);
        assert_eq!(contents(at, &files), whole, "{name}");
        note(
            "no room for a file",
            name,
            refused,
            "a line, exit 2, files whole",
        );
    }
}

/// A flipped bit of any file that is read back is refused, told of, or changes nothing.
#[test]
fn flipped_bits_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let all = cases(at);
    let of = |name: &str| all.iter().find(|case| case.name == name).unwrap();
    let (localize, run) = (of("localize"), of("run"));
    expect(at, &localize.command);
    expect(at, &run.command);
    let entries = |kind: &str| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(at.join("cache").join(kind)).unwrap();
        let mut entries: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        entries.sort();
        entries
    };
    let recording = entries("recordings").remove(0);
    let trial = entries("trials").remove(0);
    let kinds: Vec<(&str, PathBuf, &Case)> = vec![
        ("signal.wav", at.join("drive/signal.wav"), localize),
        ("odometry.csv", at.join("drive/odometry.csv"), localize),
        ("recording.json", at.join("drive/recording.json"), localize),
        ("truth.tum", at.join("drive/truth.tum"), localize),
        ("map.json", at.join("input/map.json"), localize),
        ("map.npy", at.join("input/map.npy"), localize),
        ("cached signal.wav", recording.join("signal.wav"), run),
        (
            "cached recording.json",
            recording.join("recording.json"),
            run,
        ),
        ("cached trial", trial, run),
    ];
    for (kind, file, case) in kinds {
        let good = contents(at, &case.files);
        let bytes = std::fs::read(&file).unwrap();
        let count = moments(2);
        for index in 0..count {
            let mut flipped = bytes.clone();
            let bit = (spread(index) * 8.0 * bytes.len() as f64) as usize;
            flipped[bit / 8] ^= 1 << (bit % 8);
            std::fs::write(&file, &flipped).unwrap();
            let output = echolot(at, &case.command);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            match output.status.code() {
                Some(0) => {
                    let told = said.contains("is not as this program wrote it")
                        || said.contains("made anew");
                    let same = contents(at, &case.files) == good;
                    assert!(told || same, "{kind}, bit {bit}: {said}");
                    // What is made anew is what it was.
                    assert!(case.name != "run" || same, "{kind}, bit {bit}: {said}");
                }
                Some(2) => assert!(
                    said.contains("error: ") && !said.contains("panicked"),
                    "{said}"
                ),
                code => panic!("{kind}, bit {bit}: {code:?}, {said}"),
            }
            if case.name != "run" {
                std::fs::write(&file, &bytes).unwrap();
                expect(at, &case.command);
            }
        }
        note(
            "flipped bit",
            kind,
            count,
            "refused, told, or nothing changes",
        );
    }
}

/// Two of the same at once share their output, or their cache, and end with the same bytes.
#[test]
fn two_at_once_do_not_harm_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for Case {
        name,
        command,
        files,
    } in cases(at)
    {
        expect(at, &command);
        let whole = contents(at, &files);
        let count = moments(1).min(20);
        for index in 0..count {
            if name == "run" {
                std::fs::remove_dir_all(at.join("cache")).unwrap();
            }
            let mut both = [start(at, &command), start(at, &command)];
            for child in &mut both {
                assert!(child.wait().unwrap().success(), "{name}, pair {index}");
            }
            assert_eq!(contents(at, &files), whole, "{name}, pair {index}");
            assert_eq!(
                temporaries(at),
                Vec::<PathBuf>::new(),
                "{name}, pair {index}"
            );
        }
        note("two at once", name, count, "both end with the same bytes");
    }
}
