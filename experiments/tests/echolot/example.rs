//! The example recordings, in the format that a laboratory exports, go through `record check`, `map`, `localize` and
//! `track`, and the echoes help.

use std::path::{Path, PathBuf};

use experiments::scores::Scores;
use localizer::Trajectory;
use localizer::io::recording_source::{ReadOptions, RecordingSource};
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::room::{echolot, expect, refuse};

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/site_robot")
}

fn recording(name: &str) -> String {
    example().join(name).display().to_string()
}

fn mae_m(report: &str) -> f64 {
    let report: Value = serde_json::from_str(report).unwrap();
    report["mae_m"].as_f64().unwrap()
}

#[test]
fn a_laboratorys_recordings_make_a_map_and_a_path() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let (mapping, drive) = (recording("mapping"), recording("drive"));
    expect(at, &["map", &mapping, "-o", "map"]);
    expect(at, &["map", &mapping, "--method", "landmarks", "-o", "map"]);
    let map: Value =
        serde_json::from_str(&std::fs::read_to_string(at.join("map/map.json")).unwrap()).unwrap();
    assert_eq!(map["parameters"]["sensor_offset_m"][0].as_f64(), Some(0.05));
    let localize = |method: &str| {
        let output = format!("{method}.tum");
        let arguments = ["localize", &drive, "--map", "map", "--method", method];
        mae_m(&expect(
            at,
            &[&arguments[..], &["-o", &output, "--json"]].concat(),
        ))
    };
    let [doppler, landmarks, wheels] = ["doppler", "landmarks", "odometry"].map(localize);
    // A map from fourteen seconds of driving, and wheels whose slip was drawn.
    assert!(doppler < 0.8 * wheels, "{doppler} m, wheels {wheels} m");
    assert!(landmarks < 0.005, "{landmarks} m");
    let text = std::fs::read_to_string(at.join("landmarks.tum")).unwrap();
    assert!(
        text.lines().nth(1).unwrap().starts_with("17162496"),
        "on the truth's clock"
    );
    // Estimates are on the truth's clock, and a table lies beside them.
    let text = std::fs::read_to_string(at.join("doppler.tum")).unwrap();
    let (mark, text) = text.split_once('\n').unwrap();
    assert!(mark.starts_with("# echolot estimate "), "{mark}");
    assert!(text.starts_with("17162496"), "{text:.40}");
    let table = std::fs::read_to_string(at.join("doppler.csv")).unwrap();
    assert_eq!(table.lines().count(), text.lines().count() + 1);
    // Silence in place of the sound is no sound.
    let deaf = at.join("deaf");
    std::fs::create_dir(&deaf).unwrap();
    for name in ["odometry.csv", "recording.json", "truth.tum"] {
        std::fs::copy(example().join("drive").join(name), deaf.join(name)).unwrap();
    }
    let mut wav = std::fs::read(example().join("drive/signal.wav")).unwrap();
    wav[44..].fill(0);
    std::fs::write(deaf.join("signal.wav"), wav).unwrap();
    let complaint = refuse(at, &["localize", "deaf", "--map", "map", "-o", "deaf.tum"]);
    assert!(complaint.contains("code is not heard"), "{complaint}");
    let check = echolot(at, &["record", "check", "deaf"]);
    let lines = String::from_utf8(check.stdout).unwrap();
    assert_eq!(check.status.code(), Some(1), "{lines}");
    assert!(
        lines.contains("BAD") && lines.contains("code is not heard"),
        "{lines}"
    );
}

/// What `evo_ape tum truth.tum est.tum` of evo 1.38.1 said of the example localized, see `tests/fixtures`.
#[test]
fn evo_gives_the_same_errors() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    let evo = std::fs::read_to_string(fixtures.join("evo.json")).unwrap();
    let evo: Value = serde_json::from_str(&evo).unwrap();
    let truth = Trajectory::read_tum(&example().join("drive/truth.tum")).unwrap();
    for method in ["doppler", "landmarks"] {
        let estimate = Trajectory::read_tum(&fixtures.join(format!("{method}.tum"))).unwrap();
        let poses: Vec<_> = estimate.t_s.iter().copied().zip(estimate.poses).collect();
        let (scores, coverage) = Scores::of(&poses, &truth);
        let scores = scores.unwrap();
        assert_eq!(coverage, 1.0);
        assert_eq!(evo[method]["pairs"], poses.len());
        for (field, ours) in [
            ("mean_m", scores.mae_m),
            ("rmse_m", scores.rmse_m),
            ("max_m", scores.max_m),
        ] {
            let theirs = evo[method][field].as_f64().unwrap();
            assert!(
                (ours - theirs).abs() < 1e-6,
                "{method} {field}: {ours}, evo {theirs}"
            );
        }
    }
}

/// The slip of the example's wheels was drawn, not chosen: uniform from 0 to 0.3 rad/m, by the first four bytes of the
/// SHA-256 of `site_robot 7`, the robot's name and seed.
#[test]
fn the_examples_wheels_are_drawn() {
    let digest = Sha256::digest(b"site_robot 7");
    let share = f64::from(u32::from_be_bytes(digest[..4].try_into().unwrap())) / 2_f64.powi(32);
    let robot = std::fs::read_to_string(example().join("robot.json")).unwrap();
    let robot: Value = serde_json::from_str(&robot).unwrap();
    let drawn = (0.3 * share * 1e4).round() / 1e4;
    assert_eq!(robot["drift_radpm"].as_f64(), Some(drawn));
    assert_eq!(robot["seed"], 7);
}

#[test]
fn the_example_is_late_and_drifts_and_its_numbers_are_found() {
    let mut bytes = 0;
    for name in ["mapping", "drive"] {
        let folder = example().join(name);
        let json = std::fs::read_to_string(folder.join("recording.json")).unwrap();
        let json: Value = serde_json::from_str(&json).unwrap();
        for field in [
            "late_s",
            "drift_ppm",
            "channel",
            "odometry_clock_s",
            "truth_clock_s",
        ] {
            assert!(json.get(field).is_none(), "{field}");
        }
        let source = RecordingSource::open(&folder, &ReadOptions::default()).unwrap();
        let found = &source.alignment;
        assert_eq!(
            (found.file_rate_hz, found.channels, found.channel),
            (48_000.0, 2, 1)
        );
        // The numbers of examples/site_robot/robot.json, by the recorder's clock.
        assert!((found.sound.late_s - 0.087).abs() < 1e-5, "{found:?}");
        assert!((found.sound.drift_ppm + 31.0).abs() < 1.0, "{found:?}");
        let truth = found.truth.unwrap();
        assert!(
            (truth.reading_s - 1_716_249_600.5).abs() < 0.01,
            "{truth:?}"
        );
        assert!(
            (found.odometry.reading_s - 731.25).abs() < 0.06,
            "{found:?}"
        );
        bytes += std::fs::read_dir(&folder)
            .unwrap()
            .map(|entry| entry.unwrap().metadata().unwrap().len())
            .sum::<u64>();
    }
    assert!(bytes < 6_500_000, "{bytes}");
}
