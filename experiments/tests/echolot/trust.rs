//! Runs say how far their results can be trusted: whether the code was found, how the echoes fit, what the truth
//! covers.

use std::path::Path;

use localizer::signal::waveform;
use localizer::{Parameters, Recording};
use serde_json::Value;

use crate::room::{echolot, expect, note, refuse};

/// The drives of the example by its robot with one clock for both sound cards, so that nothing has to be found, and a
/// map of the first.
fn example(at: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/site_robot");
    let robot = std::fs::read_to_string(root.join("robot.json")).unwrap();
    let mut robot: Value = serde_json::from_str(&robot).unwrap();
    robot.as_object_mut().unwrap().remove("sound_card");
    std::fs::write(at.join("robot.json"), robot.to_string()).unwrap();
    std::fs::copy(root.join("scene.json"), at.join("scene.json")).unwrap();
    for drive in ["mapping", "drive"] {
        let simulate = ["simulate", "scene.json", "--path", drive, "-o", drive];
        let robot = ["--engine", "image-source", "--robot", "robot.json"];
        expect(at, &[&simulate[..], &robot].concat());
    }
    expect(at, &["map", "mapping", "-o", "map"]);
}

/// Another drive: the example's, changed.
fn changed(at: &Path, name: &str, change: impl FnOnce(&mut Recording)) {
    let mut recording = Recording::read(&at.join("drive")).unwrap();
    change(&mut recording);
    recording.write(&at.join(name)).unwrap();
}

/// What `localize` reports of a drive, and its warnings.
fn localize(at: &Path, drive: &str, more: &[&str]) -> (Value, String) {
    let usual = [
        "localize", drive, "--map", "map", "--window", "3", "-o", "e.tum", "--json",
    ];
    let output = echolot(at, &[&usual[..], more].concat());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{drive}: {said}");
    (serde_json::from_slice(&output.stdout).unwrap(), said)
}

#[test]
fn a_good_run_says_so_in_one_line_and_in_json() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    example(at);
    let (report, said) = localize(at, "drive", &[]);
    for field in [
        "mae_m",
        "interpolated_mae_m",
        "rmse_m",
        "p90_m",
        "max_m",
        "final_m",
        "heading_mae_rad",
    ] {
        let value = report[field].as_f64().unwrap();
        assert!(value > 0.0 && value < 0.3, "{field}: {report}");
    }
    assert_eq!(report["coverage"], 1.0);
    assert_eq!(report["code_found"], 1.0);
    assert!(report["status"]["sure"].as_f64().unwrap() > 0.9, "{report}");
    assert!(report["fit"].as_f64().unwrap() > 2.5, "{report}");
    assert!(
        report["warnings"].as_array().unwrap().is_empty() && said.is_empty(),
        "{said}"
    );
    let text = expect(
        at,
        &[
            "localize", "drive", "--map", "map", "--window", "3", "-o", "e.tum",
        ],
    );
    let line = text.lines().next().unwrap();
    for word in ["code found in 100 %", "fit", "sure"] {
        assert!(line.contains(word), "{text}");
    }
    let table = std::fs::read_to_string(at.join("e.csv")).unwrap();
    assert_eq!(
        table.lines().count(),
        1 + report["poses"].as_u64().unwrap() as usize
    );
    assert!(table.starts_with("t_s,x_m") && table.contains(",sure\n"));
}

#[test]
fn a_signal_without_the_code_is_refused_by_both_commands() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    example(at);
    let mut state = 1_u32;
    let mut noise = || {
        // A linear congruence: noise enough.
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state as f32 / u32::MAX as f32 - 0.5
    };
    changed(at, "zeros", |drive| drive.signal.fill(0.0));
    changed(at, "constant", |drive| drive.signal.fill(0.4));
    changed(at, "noise", |drive| {
        drive.signal.iter_mut().for_each(|sample| *sample = noise())
    });
    changed(at, "another", |drive| drive.signal.reverse());
    changed(at, "longer", |drive| drive.meta.code_length = 2047);
    for (drive, word) in [
        ("zeros", "dead"),
        ("constant", "dead"),
        ("noise", "no echoes"),
        ("another", "no echoes"),
        ("longer", "no echoes"),
    ] {
        let localize = ["localize", drive, "--map", "map", "-o", "e.tum"];
        for command in [&["map", drive, "-o", "new"][..], &localize] {
            let output = echolot(at, command);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(2), "{command:?}: {said}");
            assert!(said.contains("signal.wav") && said.contains(word), "{said}");
        }
        assert!(!at.join("new").exists() && !at.join("e.tum").exists());
    }
    note("recording without echoes", "map, localize", 10, "refused");
}

/// What a microphone that stands somewhere hears of a robot alone in the open: the code, later or sooner as it drives.
fn heard_at(drive: &mut Recording, place_m: [f64; 2]) {
    let parameters = Parameters::default().for_recording(&drive.meta);
    let period = waveform::transmitted(&parameters);
    let truth = drive.truth.as_ref().unwrap();
    let rate = drive.meta.sample_rate_hz;
    let times = (0..drive.signal.len()).map(|k| k as f64 / rate);
    let poses = truth.poses_at(times.clone());
    for ((sample, t_s), pose) in drive.signal.iter_mut().zip(times).zip(poses) {
        let way_m = (pose.x_m - place_m[0]).hypot(pose.y_m - place_m[1]);
        let at =
            (rate * (t_s - way_m / drive.meta.speed_of_sound_mps)).rem_euclid(period.len() as f64);
        let (before, share) = (at as usize % period.len(), at.fract());
        let after = (before + 1) % period.len();
        *sample = (0.1 * ((1.0 - share) * period[before] + share * period[after])) as f32;
    }
}

#[test]
fn a_microphone_that_is_not_on_the_robot_makes_no_sure_pose() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    example(at);
    expect(
        at,
        &["map", "mapping", "--method", "landmarks", "-o", "map"],
    );
    for (name, place_m) in [("near", [6.0, 1.0]), ("far", [100.0, -20.0])] {
        changed(at, name, |drive| heard_at(drive, place_m));
        for method in ["doppler", "landmarks"] {
            let localize = ["localize", name, "--map", "map", "--method", method];
            let output = echolot(at, &[&localize[..], &["-o", "e.tum", "--json"]].concat());
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            if output.status.code() == Some(2) {
                assert!(said.contains("no echoes"), "{name}, {method}: {said}");
                continue;
            }
            let report: Value = serde_json::from_slice(&output.stdout).unwrap();
            let sure = report["status"]["sure"].as_f64().unwrap();
            assert!(sure < 0.2, "{name}, {method}: {report}");
            assert!(said.contains("warning: "), "{name}, {method}: {said}");
        }
    }
    note(
        "microphone beside the robot",
        "localize",
        4,
        "refused or told",
    );
}

#[test]
fn doubtful_runs_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    example(at);
    changed(at, "microphone", |drive| {
        drive.meta.microphone_offset_m = [4.0, 0.0]
    });
    changed(at, "air", |drive| drive.meta.speed_of_sound_mps = 320.0);
    changed(at, "turning", |drive| {
        drive.odometry.iter_mut().for_each(|o| o.omega_radps += 0.5)
    });
    changed(at, "beside", |drive| {
        drive.truth = None;
        drive.meta.start.as_mut().unwrap().x_m += 0.6;
    });
    changed(at, "nowhere", |drive| {
        drive.truth = None;
        drive.meta.start = None;
    });
    for (drive, words) in [
        ("microphone", vec!["fit the map", "sensor_offset_m"]),
        ("air", vec!["speed_of_sound_mps: the drive has 320"]),
        ("turning", vec!["fit the map"]),
        ("beside", vec!["fit the map"]),
        ("nowhere", vec!["no start is known"]),
    ] {
        let (report, said) = localize(at, drive, &[]);
        for word in words {
            assert!(
                said.contains("warning: ") && said.contains(word),
                "{drive}: {said}"
            );
            assert!(report["warnings"].to_string().contains(word), "{report}");
        }
    }
    note("doubtful recording", "localize", 5, "told");
}

#[test]
fn only_what_the_truth_covers_is_scored_and_mapped() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    example(at);
    let keep = |drive: &mut Recording, kept: &dyn Fn(f64) -> bool| {
        let truth = drive.truth.as_mut().unwrap();
        let poses = truth.t_s.iter().copied().zip(truth.poses.iter().copied());
        (truth.t_s, truth.poses) = poses.filter(|(t_s, _)| kept(*t_s)).unzip();
    };
    let shift = |drive: &mut Recording, by: f64, scale: f64| {
        let truth = drive.truth.as_mut().unwrap();
        truth
            .t_s
            .iter_mut()
            .for_each(|t_s| *t_s = (*t_s + by) * scale);
    };
    changed(at, "half", |drive| keep(drive, &|t_s| t_s < 7.0));
    changed(at, "gap", |drive| {
        keep(drive, &|t_s| !(3.0..11.0).contains(&t_s))
    });
    changed(at, "late", |drive| keep(drive, &|t_s| t_s > 5.5));
    changed(at, "epoch", |drive| shift(drive, 1.7e9, 1.0));
    changed(at, "nanoseconds", |drive| shift(drive, 0.0, 1e9));
    for (drive, low, high) in [
        ("half", 0.4, 0.6),
        ("gap", 0.3, 0.5),
        ("late", 0.5, 0.7),
        ("epoch", 0.0, 0.0),
        ("nanoseconds", 0.0, 0.05),
    ] {
        let (report, said) = localize(at, drive, &[]);
        let coverage = report["coverage"].as_f64().unwrap();
        assert!((low..=high).contains(&coverage), "{drive}: {report}");
        assert!(said.contains("truth.tum covers"), "{drive}: {said}");
        match report["mae_m"].as_f64() {
            Some(mae_m) => assert!(mae_m < 0.1 && coverage > 0.0, "{drive}: {report}"),
            None => assert_eq!(coverage, 0.0),
        }
        let map = ["map", drive, "-o", "part", "--json"];
        if coverage < 0.2 {
            let complaint = refuse(at, &map);
            assert!(complaint.contains("truth_clock_s"), "{complaint}");
            continue;
        }
        let report: Value = serde_json::from_str(&expect(at, &map)).unwrap();
        let warnings = report["warnings"].to_string();
        assert!(
            warnings.contains("the other blocks are left out"),
            "{report}"
        );
    }
    note(
        "truth that covers a part",
        "map, localize",
        10,
        "only that is scored and mapped, or refused",
    );
}

#[test]
fn an_outlier_of_the_truth_is_told_and_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    example(at);
    changed(at, "outlier", |drive| {
        drive.truth.as_mut().unwrap().poses[200].x_m += 30.0
    });
    changed(at, "millimetres", |drive| {
        for pose in &mut drive.truth.as_mut().unwrap().poses {
            (pose.x_m, pose.y_m) = (1e3 * pose.x_m, 1e3 * pose.y_m);
        }
    });
    let size = |drive: &str| -> (Value, String) {
        let report: Value = serde_json::from_str(&expect(
            at,
            &["map", drive, "-o", drive_map(drive), "--json"],
        ))
        .unwrap();
        let warnings = report["warnings"].to_string();
        (report, warnings)
    };
    let (plain, none) = size("drive");
    let (outlier, told) = size("outlier");
    assert_eq!(none, "[]");
    assert!(
        told.contains("has outliers") && told.contains("30.0"),
        "{told}"
    );
    assert_eq!(
        (&plain["rows"], &plain["columns"]),
        (&outlier["rows"], &outlier["columns"])
    );
    let complaint = refuse(at, &["map", "millimetres", "-o", "m"]);
    assert!(complaint.contains("give metres"), "{complaint}");
    note(
        "outliers of the truth",
        "map",
        2,
        "told and left out, or refused",
    );
}

/// Folder of the map of a drive.
fn drive_map(drive: &str) -> &'static str {
    if drive == "outlier" {
        "of-outlier"
    } else {
        "of-drive"
    }
}

#[test]
fn values_that_are_ignored_or_contradict_the_map_get_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    example(at);
    let file = at.join("p.json");
    std::fs::write(
        &file,
        r#"{"speed_of_sound_mps": 300, "carrier_hz": 10000, "window_half_width_m": 3}"#,
    )
    .unwrap();
    let parameters = ["--parameters", "p.json"];
    let (_, said) = localize(at, "drive", &parameters);
    assert!(
        said.contains("p.json: speed_of_sound_mps: 300 is ignored"),
        "{said}"
    );
    assert!(!said.contains("carrier_hz"), "the same value: {said}");
    let output = echolot(
        at,
        &[&["map", "mapping", "-o", "map2"][..], &parameters].concat(),
    );
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("speed_of_sound_mps: 300 is ignored"),
        "{said}"
    );
    std::fs::write(&file, r#"{"directions": 19, "window_half_width_m": 3}"#).unwrap();
    let (_, said) = localize(at, "drive", &parameters);
    assert!(
        said.contains("directions: the drive has 19, the map was made with 29"),
        "{said}"
    );
    std::fs::write(&file, r#"{"cell_m": 0.2}"#).unwrap();
    let usual = ["localize", "drive", "--map", "map", "-o", "e.tum"];
    assert!(refuse(at, &[&usual[..], &parameters].concat()).contains("cell_m"));
}
