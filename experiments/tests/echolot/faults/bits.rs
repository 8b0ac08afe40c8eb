//! Flipped bits in files that are read back.

use std::path::PathBuf;

use super::{Case, cases, contents, moments, spread};
use crate::room::{echolot, expect, note};

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
