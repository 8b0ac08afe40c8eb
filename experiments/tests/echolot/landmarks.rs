//! Landmarks from the command line: layouts drawn at random, learnt and localized in.

use std::path::Path;

use serde_json::Value;

use crate::room::{echolot, expect, refuse};

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// Draws a layout, records both drives by image sources, and learns its landmarks into `map`.
fn learn(at: &Path, kind: &str, seed: &str) -> Value {
    expect(
        at,
        &[
            "scene",
            "random",
            "--kind",
            kind,
            "--seed",
            seed,
            "-o",
            "scene.json",
        ],
    );
    for path in ["mapping", "localization"] {
        let engine = ["--engine", "image-source", "--image-order", "2"];
        let recording = ["simulate", "scene.json", "--path", path, "-o", path];
        expect(at, &[&recording[..], &engine[..]].concat());
    }
    json(&expect(
        at,
        &[
            "map",
            "mapping",
            "--method",
            "landmarks",
            "-o",
            "map",
            "--json",
        ],
    ))
}

fn localize(at: &Path, more: &[&str]) -> Value {
    let usual = [
        "localize",
        "localization",
        "--map",
        "map",
        "-o",
        "drive.tum",
        "--method",
        "landmarks",
        "--json",
    ];
    json(&expect(at, &[&usual[..], more].concat()))
}

#[test]
fn random_layouts_are_learnt_and_localized_in_to_millimetres() {
    for (kind, seed) in [("open", "2"), ("room", "5")] {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let map = learn(at, kind, seed);
        assert!(map["landmarks"].as_u64().unwrap() >= 3, "{map}");
        for file in [
            "landmarks.json",
            "landmarks.geojson",
            "landmarks.pgm",
            "landmarks.yaml",
        ] {
            assert!(at.join("map").join(file).is_file(), "{file}");
        }
        let known = localize(at, &[]);
        assert!(
            known["mae_m"].as_f64().unwrap() < 0.004,
            "{kind} {seed}: {known}"
        );
        assert!(known["latest_mae_m"].as_f64().unwrap() < 0.006, "{known}");
        assert!(known["status"]["sure"].as_f64().unwrap() > 0.8, "{known}");
        // Wheels turn by 0.01 rad/s too much: what they lack is found with its sign.
        let lacks = known["turn_rate_error_radps"].as_f64().unwrap();
        assert!((-0.03..0.005).contains(&lacks), "{known}");
        // The same bytes again.
        let first = std::fs::read(at.join("drive.csv")).unwrap();
        localize(at, &[]);
        assert_eq!(std::fs::read(at.join("drive.csv")).unwrap(), first);
        let lines = String::from_utf8(first).unwrap();
        assert!(
            lines.starts_with("t_s,x_m,y_m,heading_rad,xx_m2"),
            "{lines}"
        );
        // Started anywhere, and with a pose by hand.
        let unknown = localize(at, &["--start", "unknown"]);
        assert!(
            unknown["final_m"].as_f64().unwrap() < 0.02,
            "{kind} {seed}: {unknown}"
        );
        let truth = std::fs::read_to_string(at.join("localization/truth.tum")).unwrap();
        let start: Vec<f64> = truth
            .lines()
            .find(|line| !line.starts_with('#'))
            .unwrap()
            .split_whitespace()
            .map(|number| number.parse().unwrap())
            .collect();
        let degrees = 2.0 * start[6].atan2(start[7]).to_degrees();
        let by_hand = format!("{},{},{degrees}", start[1], start[2]);
        let by_hand = localize(at, &["--start", &by_hand]);
        assert!(by_hand["mae_m"].as_f64().unwrap() < 0.004, "{by_hand}");
    }
}

#[test]
fn a_drive_makes_its_own_map_which_serves_another_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    learn(at, "room", "4");
    let usual = [
        "slam",
        "localization",
        "-o",
        "drive.tum",
        "--map-out",
        "own",
        "--json",
    ];
    let found = json(&expect(at, &usual));
    assert!(found["mae_m"].as_f64().unwrap() < 0.02, "{found}");
    assert!(found["status"]["sure"].as_f64().unwrap() == 1.0, "{found}");
    let lacks = found["turn_rate_error_radps"].as_f64().unwrap();
    assert!((-0.013..-0.007).contains(&lacks), "{found}");
    assert!(at.join("drive.csv").is_file() && at.join("own/landmarks.json").is_file());
    let usual = [
        "localize",
        "mapping",
        "--map",
        "own",
        "--method",
        "landmarks",
        "-o",
        "other.tum",
        "--json",
    ];
    let other = json(&expect(at, &usual));
    assert!(other["mae_m"].as_f64().unwrap() < 0.03, "{other}");
    // Without an echo there is nothing to learn, and it is said.
    let silent = at.join("localization/signal.wav");
    let mut bytes = std::fs::read(&silent).unwrap();
    let data = bytes.windows(4).position(|name| name == b"data").unwrap();
    bytes[data + 8..].fill(0);
    std::fs::write(&silent, bytes).unwrap();
    let message = refuse(at, &["slam", "localization", "-o", "silent.tum"]);
    assert!(message.contains("the microphone was dead"), "{message}");
    assert!(!at.join("silent.tum").exists());
}

#[test]
fn what_landmarks_cannot_use_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    learn(at, "room", "3");
    let usual = [
        "localize",
        "localization",
        "--map",
        "map",
        "-o",
        "drive.tum",
    ];
    let with = |more: &[&str]| refuse(at, &[&usual[..], more].concat());
    assert!(with(&["--method", "landmarks", "--window", "3"]).contains("--window"));
    assert!(with(&["--start", "unknown"]).contains("needs --method landmarks"));
    let bad = echolot(
        at,
        &[&usual[..], &["--method", "landmarks", "--start", "1,2"]].concat(),
    );
    assert_eq!(bad.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&bad.stderr).contains("1.5,2,90"));
    assert!(with(&[]).contains("map.json"), "an image map is not there");
    let path = at.join("map/landmarks.json");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replacen("\"version\": 1", "\"version\": 7", 1)).unwrap();
    assert!(with(&["--method", "landmarks"]).contains("version"));
    std::fs::remove_file(&path).unwrap();
    assert!(with(&["--method", "landmarks"]).contains("landmarks.json"));
}
