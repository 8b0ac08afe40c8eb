//! From a scene to a pose by image sources, and a whole study from its scene to its figures and checks.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde_json::Value;

use crate::room::{echolot, expect, project_file, refuse, scene_file};

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let all = [arguments, &["--json"]].concat();
    serde_json::from_str(&expect(folder, &all)).unwrap()
}

#[test]
fn a_simulated_robot_finds_itself() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    for path in ["mapping", "localization"] {
        let recording = [
            "simulate",
            "room.json",
            "--path",
            path,
            "--engine",
            "image-source",
            "-o",
            path,
        ];
        expect(at, &recording);
    }
    expect(at, &["map", "mapping", "-o", "map"]);
    let localize = |method: &str, output: &str| {
        let fixed = [
            "localize",
            "localization",
            "--map",
            "map",
            "--window",
            "2",
            "--method",
            method,
            "-o",
            output,
        ];
        json(at, &fixed)["mae_m"].as_f64().unwrap()
    };
    let doppler = localize("doppler", "doppler.tum");
    let odometry = localize("odometry", "odometry.tum");
    assert!(
        doppler < 0.05 && odometry > 1.2 * doppler,
        "{doppler} {odometry}"
    );
    assert_eq!(localize("doppler", "again.tum"), doppler);
    let bytes = |name: &str| std::fs::read(at.join(name)).unwrap();
    assert_eq!(bytes("doppler.tum"), bytes("again.tum"));
    let text = String::from_utf8(bytes("doppler.tum")).unwrap();
    assert!(
        text.lines()
            .skip(1)
            .all(|line| line.split(' ').count() == 8)
    );

    // A recording made by hand has no truth: the start comes from recording.json, and no error is printed.
    std::fs::remove_file(at.join("localization/truth.tum")).unwrap();
    let report = json(
        at,
        &[
            "localize",
            "localization",
            "--map",
            "map",
            "-o",
            "blind.tum",
        ],
    );
    assert!(
        report["mae_m"].is_null() && report["poses"].as_u64().unwrap() > 30,
        "{report}"
    );
}

#[test]
fn a_study_goes_from_scene_to_verdict() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = tempfile::tempdir().unwrap();
    let results = folder.path().to_str().unwrap();
    let baseline = folder.path().join("baseline.json");
    let baseline = baseline.to_str().unwrap();
    let study = [
        "run",
        "studies/quick/quick.json",
        "--only",
        "layout",
        "--only",
        "odometry-drift",
        "--engine",
        "image-source",
        "--results",
        results,
    ];
    let summary = json(&project, &study);
    for method in ["doppler", "toa_only", "odometry"] {
        let accuracy = &summary["odometry_drift"][method];
        let mae_m = accuracy["mae_m"].as_f64().unwrap();
        assert!(mae_m > 0.0 && mae_m < 1.0, "{accuracy}");
        assert!(
            accuracy["interval_m"][0].as_f64().unwrap() <= mae_m,
            "{accuracy}"
        );
        assert!(accuracy["trials"].as_u64().unwrap() > 0, "{accuracy}");
    }
    assert!(summary["provenance"]["commit"].is_string());
    for figure in [
        "fig04_scene_and_map",
        "fig05_speeds",
        "fig06_paths",
        "fig06_cdf",
    ] {
        assert!(
            folder
                .path()
                .join(format!("quick/figures/{figure}.png"))
                .exists(),
            "{figure}"
        );
    }

    // The second run finds everything in the cache and prints the same.
    let cached = || -> Vec<(PathBuf, SystemTime)> {
        let mut files: Vec<_> = ["recordings", "trials"]
            .iter()
            .flat_map(|kind| std::fs::read_dir(folder.path().join("cache").join(kind)).unwrap())
            .map(|entry| entry.unwrap())
            .map(|entry| (entry.path(), entry.metadata().unwrap().modified().unwrap()))
            .collect();
        files.sort();
        files
    };
    let before = cached();
    assert!(before.len() > 10);
    let again = json(&project, &study);
    assert_eq!(again["odometry_drift"], summary["odometry_drift"]);
    assert_eq!(cached(), before);

    let check = [
        "check",
        "studies/quick/quick.json",
        "--results",
        results,
        "--baseline",
        baseline,
    ];
    expect(&project, &[&check[..], &["--bless"]].concat());
    assert!(expect(&project, &check).contains("ok"));
    let better = std::fs::read_to_string(baseline).unwrap();
    let mut better: Value = serde_json::from_str(&better).unwrap();
    better["measures"][0]["mae_m"] = 1e-4.into();
    better["measures"][0]["interval_m"] = serde_json::json!([1e-4, 1e-4]);
    std::fs::write(baseline, better.to_string()).unwrap();
    let output = echolot(&project, &check);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stdout).contains("WORSE"));
    assert!(String::from_utf8_lossy(&output.stderr).contains("1 of 3 measures worse"));
}

/// All noises and levels run through the drive together; a trial alone, or on another number of threads, gives the
/// same.
#[test]
fn trials_with_noise_do_not_depend_on_their_company() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = tempfile::tempdir().unwrap();
    let results = folder.path().to_str().unwrap();
    let file = folder.path().join("mine.json");
    std::fs::write(
        &file,
        r#"{"name": "mine", "about": "Noise.", "scene": "scenes/quick.json", "seeds": {"filter": 1, "noise": 3},
        "set": {"localizer.window_half_width_m": 2}, "papers": [{"study": "snr", "snr_db": [-15, 0, 20]}]}"#,
    )
    .unwrap();
    let snr = |threads: &str| -> String {
        let study = [
            "run",
            file.to_str().unwrap(),
            "--engine",
            "image-source",
            "--no-figures",
            "--results",
            results,
            "--threads",
            threads,
        ];
        expect(&project, &study);
        std::fs::read_to_string(folder.path().join("mine/data/snr.csv")).unwrap()
    };
    let together = snr("2");
    let trials = folder.path().join("cache/trials");
    let mut files: Vec<PathBuf> = std::fs::read_dir(&trials)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    // Three levels of three noises.
    assert_eq!(files.len(), 9);
    for file in files.iter().step_by(3) {
        std::fs::remove_file(file).unwrap();
        assert_eq!(snr("1"), together, "{}", file.display());
    }
    std::fs::remove_dir_all(&trials).unwrap();
    assert_eq!(snr("1"), together);
    // No two have the same error.
    let mut rows: Vec<&str> = together.lines().skip(1).collect();
    rows.iter_mut()
        .for_each(|row| *row = row.rsplit(',').next().unwrap());
    rows.sort_unstable();
    rows.dedup();
    assert_eq!(rows.len(), 9, "{together}");
}

/// Results of another scene, robot or values do not stand beside new ones, nor do figures of them.
#[test]
fn another_files_results_do_not_mix() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let write = |name: &str, bias: f64| {
        let text = format!(
            r#"{{"name": "mine", "about": "Two.", "scene": "{}", "papers": [{{"study": "odometry-drift"}},
            {{"study": "periods", "periods": [6]}}], "set": {{"localizer.window_half_width_m": 2,
            "robot.odometry_bias_radps": {bias}}}}}"#,
            project_file("scenes/quick.json")
        );
        std::fs::write(at.join(name), text).unwrap();
    };
    let run = |file: &str, only: &str| {
        let images = ["--engine", "image-source", "--no-figures"];
        json(at, &[&["run", file, "--only", only][..], &images].concat())
    };
    write("mine.json", 0.01);
    let periods = at.join("results/mine/data/periods.csv");
    run("mine.json", "periods");
    let both = run("mine.json", "odometry-drift");
    assert!(periods.exists() && both["periods"].is_array(), "{both}");
    let first = both["odometry_drift"]["odometry"]["mae_m"]
        .as_f64()
        .unwrap();
    write("mine.json", 0.02);
    let other = run("mine.json", "odometry-drift");
    assert!(!periods.exists() && other["periods"].is_null(), "{other}");
    let second = other["odometry_drift"]["odometry"]["mae_m"]
        .as_f64()
        .unwrap();
    assert!(second > 1.5 * first, "{first} {second}");
    // Two files of one name would write the same folder.
    write("twin.json", 0.01);
    let refused = refuse(at, &["run", "mine.json", "twin.json"]);
    assert!(refused.contains("twin.json: name: mine"), "{refused}");
}
