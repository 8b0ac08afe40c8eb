//! The example recordings, in the format that a laboratory exports, go through `map` and `localize`.

use std::path::{Path, PathBuf};

use localizer::Recording;
use serde_json::Value;

use crate::room::expect;

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/site_robot")
}

#[test]
fn a_laboratorys_recordings_make_a_map_and_a_path() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let recording = |name: &str| example().join(name).display().to_string();
    expect(at, &["map", &recording("mapping"), "-o", "map"]);
    let map: Value =
        serde_json::from_str(&std::fs::read_to_string(at.join("map/map.json")).unwrap()).unwrap();
    assert_eq!(map["parameters"]["sensor_offset_m"][0].as_f64(), Some(0.05));
    assert_eq!(map["parameters"]["sample_rate_hz"].as_f64(), Some(50_000.0));
    let report: Value = serde_json::from_str(&expect(
        at,
        &[
            "localize",
            &recording("drive"),
            "--map",
            "map",
            "--window",
            "3",
            "-o",
            "drive.tum",
            "--json",
        ],
    ))
    .unwrap();
    // A map from six seconds of driving; the window's pixels are 0.1 m wide.
    let mae_m = report["mae_m"].as_f64().unwrap();
    assert!(mae_m < 0.1, "{report}");
    assert!(report["poses"].as_u64().unwrap() > 40, "{report}");
}

#[test]
fn the_example_is_what_a_laboratory_exports() {
    let mut bytes = 0;
    for name in ["mapping", "drive"] {
        let folder = example().join(name);
        let wav = std::fs::read(folder.join("signal.wav")).unwrap();
        let number =
            |at: usize| u32::from_le_bytes([wav[at], wav[at + 1], wav[at + 2], wav[at + 3]]);
        assert_eq!(
            (number(24), number(34) & 0xffff),
            (50_000, 16),
            "50 kHz, 16 bit"
        );
        let recording = Recording::read(&folder).unwrap();
        let truth = recording.truth.as_ref().unwrap();
        assert_eq!(recording.odometry[0].t_s, 0.0, "on the signal's clock");
        assert!(truth.t_s[0].abs() < 1e-5);
        assert!(
            (truth.t_s[1] - 1.0 / 120.0).abs() < 1e-5,
            "tracked at 120 Hz"
        );
        let text = std::fs::read_to_string(folder.join("truth.tum")).unwrap();
        assert!(
            text.starts_with("1716249600.5"),
            "on its own clock in the file"
        );
        bytes += std::fs::read_dir(&folder)
            .unwrap()
            .map(|entry| entry.unwrap().metadata().unwrap().len())
            .sum::<u64>();
    }
    assert!(bytes < 1_500_000, "{bytes}");
}
