//! Killed at any moment, and two at once.

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::{Case, cases, contents, moments, spread, start, temporaries};
use crate::room::{drives, expect, note};

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
        let (count, mut killed, mut index) = (moments(2), 0, 0);
        // Some come too late: the command has ended.
        while killed < count && index < 3 * count {
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
            index += 1;
        }
        note(
            "kill -9",
            name,
            killed,
            "files whole, the next run ends with the same bytes",
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

/// `track` writes nothing but lines: after a kill they are a beginning of all, and nothing else is left.
#[test]
fn a_killed_track_has_told_a_beginning() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    drives(at);
    expect(at, &["map", "mapping", "-o", "map"]);
    let run = |kill_s: Option<f64>| -> (bool, Vec<u8>) {
        let mut child = Command::new(env!("CARGO_BIN_EXE_echolot"))
            .current_dir(at)
            .args([
                "track", "--map", "map", "--window", "1.5", "--output", "tum",
            ])
            .args(["--odometry", "drive/odometry.csv", "--odometry-clock", "0"])
            .args(["--late", "0", "--drift", "0", "--start", "0.85,0.9,11.459"])
            .stdin(std::fs::File::open(at.join("drive/signal.wav")).unwrap())
            .stdout(std::fs::File::create(at.join("poses.tum")).unwrap())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        if let Some(kill_s) = kill_s {
            std::thread::sleep(Duration::from_secs_f64(kill_s));
            child.kill().unwrap();
        }
        let ended = child.wait().unwrap().success();
        (ended, std::fs::read(at.join("poses.tum")).unwrap())
    };
    let names = || {
        let entries = std::fs::read_dir(at).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let started = Instant::now();
    let (ended, whole) = run(None);
    let length_s = started.elapsed().as_secs_f64();
    assert!(ended && whole.iter().filter(|byte| **byte == b'\n').count() > 50);
    let before = names();
    let (count, mut killed, mut index) = (moments(2), 0, 0);
    while killed < count && index < 3 * count {
        let (ended, told) = run(Some(length_s * spread(index)));
        killed += usize::from(!ended);
        assert!(whole.starts_with(&told), "kill {index}");
        assert_eq!(names(), before);
        index += 1;
    }
    assert!(run(None) == (true, whole));
    note(
        "kill -9",
        "track",
        killed,
        "what it had told is a beginning, the next run tells the same bytes",
    );
}
