//! Faults from outside: killed at any moment, no room on the disk, flipped bits, two at once. What a command had
//! written before is whole after it, and the same command then ends with the same bytes.
//!
//! Plain `cargo test` tries a few moments of each; `make robustness` tries all (`ECHOLOT_MOMENTS`), or those of the
//! commands that `ECHOLOT_CASES` names (`run,slam`).

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::room::{drives, echolot, expect, note, quick_scene};

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

/// A command that runs another as a user who may write nothing of root's, or where that is not root's business already
/// nothing.
#[cfg(target_os = "linux")]
fn without_rights() -> Vec<&'static str> {
    let root = Command::new("id").arg("-u").output();
    match root.is_ok_and(|id| id.stdout == b"0\n") {
        true => vec![
            "setpriv",
            "--reuid=65534",
            "--regid=65534",
            "--clear-groups",
        ],
        false => vec!["env"],
    }
}

/// A folder in which nothing may be written, as a user who is not root.
#[cfg(target_os = "linux")]
#[test]
fn a_place_without_the_right_to_write_is_told() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let all = cases(at);
    let allow = |mode| {
        std::fs::set_permissions(at, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    // The program where anybody may run it.
    let program = at.join("program");
    std::fs::copy(env!("CARGO_BIN_EXE_echolot"), &program).unwrap();
    let mut refused = 0;
    for Case {
        name,
        command,
        files,
    } in all
    {
        allow(0o555);
        let user = without_rights();
        let output = Command::new(user[0])
            .args(&user[1..])
            .arg(&program)
            .current_dir(at)
            .args(&command)
            .output()
            .unwrap();
        allow(0o755);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        let last = said.lines().last().unwrap_or_default();
        assert!(
            last.starts_with("error: ") && last.contains("denied"),
            "{name}: {said}"
        );
        assert!(contents(at, &files).iter().all(Option::is_none), "{name}");
        refused += 1;
    }
    note(
        "no right to write",
        "simulate, map, localize, slam, run",
        refused,
        "a line, exit 2",
    );
}

/// A small disk of its own that fills up, or may only be read, where such a one may be mounted.
#[cfg(target_os = "linux")]
#[test]
fn a_small_disk_that_is_full_or_read_only_gets_whole_files_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let all = cases(at);
    let may = Command::new("unshare")
        .args(["-m", "mount", "-t", "tmpfs", "none", "/mnt"])
        .output()
        .is_ok_and(|output| output.status.success());
    if !may {
        println!("no disk can be mounted here");
        return;
    }
    for Case {
        name,
        command,
        files,
    } in all
    {
        expect(at, &command);
        let whole = contents(at, &files);
        let size: usize = whole.iter().flatten().map(Vec::len).sum();
        let (mut full, mut read_only) = (0, 0);
        for index in 0..moments(3).min(20) {
            let kept = at.join("kept");
            if kept.exists() {
                std::fs::remove_dir_all(&kept).unwrap();
            }
            std::fs::create_dir_all(at.join("disk")).unwrap();
            // In pages, from next to nothing to just below what the command writes.
            let pages = 1 + (spread(index) * size as f64 / 4096.0) as usize;
            let lock = if index == 0 {
                "mount -o remount,ro . &&"
            } else {
                ""
            };
            let script = format!(
                "mount -t tmpfs -o size={}k none disk && cd disk && ln -s ../*.json ../scenes ../mapping ../drive \
                 ../input . && cd ../disk && {lock} {} {}; code=$?; cp -a . ../kept; exit $code",
                4 * pages,
                env!("CARGO_BIN_EXE_echolot"),
                command.join(" ")
            );
            let output = Command::new("unshare")
                .current_dir(at)
                .args(["-m", "sh", "-c", &script])
                .output()
                .unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            let code = output.status.code();
            // Files of the same content take one page less or more.
            assert!(
                code == Some(2) || (code == Some(0) && index > 0),
                "{name}: {said}"
            );
            for ((file, now), whole) in files.iter().zip(contents(&kept, &files)).zip(&whole) {
                assert!(
                    now.is_none() || now == *whole,
                    "{name}, {pages} pages: {file}"
                );
                assert!(
                    code == Some(2) || now.is_some(),
                    "{name}, {pages} pages: {file}"
                );
            }
            if code == Some(2) {
                assert!(said.contains("error: "), "{name}: {said}");
                assert_eq!(
                    temporaries(&kept),
                    Vec::<PathBuf>::new(),
                    "{name}, {pages} pages"
                );
                *(if index == 0 {
                    &mut read_only
                } else {
                    &mut full
                }) += 1;
            }
        }
        note(
            "full disk (tmpfs)",
            name,
            full,
            "a line, exit 2, files whole or none",
        );
        note("read-only disk", name, read_only, "a line, exit 2, no file");
    }
}
