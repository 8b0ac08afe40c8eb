//! Study files from the command line: the numbers of the other commands, any number of threads, a resumed run, two
//! results compared.

use std::path::Path;

use serde_json::{Value, json};

use crate::room::{echolot, expect, project_file, refuse, scene_file};

/// Writes a study of the room.
pub(crate) fn study_file(folder: &Path, changes: &[(&str, Value)]) {
    scene_file(folder);
    let mut study = json!({
        "name": "mine",
        "about": "a test",
        "scenes": ["room.json"],
        "set": {"field.engine": "image-source", "localizer.window_half_width_m": 2},
        "methods": ["doppler", "odometry", "landmarks", "slam", "multipath"],
        "figures": [
            {"kind": "bars"}, {"kind": "cdf"}, {"kind": "paths"}, {"kind": "map"},
            {"kind": "table", "measures": ["mae_m", "nees"]},
        ],
        "claims": [{
            "id": "better", "claim": "landmarks beat images",
            "test": {"test": "order", "of": [{"method": "landmarks"}, {"method": "doppler"}]}
        }],
    });
    for (field, value) in changes {
        study[*field] = value.clone();
    }
    std::fs::write(folder.join("mine.json"), study.to_string()).unwrap();
}

fn summary(folder: &Path, results: &str) -> Value {
    let text = std::fs::read_to_string(folder.join(results).join("mine/summary.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn mae_m(summary: &Value, method: &str) -> f64 {
    let cells = summary["cells"].as_array().unwrap();
    let cell = cells.iter().find(|cell| cell["method"] == method).unwrap();
    cell["mean"]["mae_m"].as_f64().unwrap()
}

#[test]
fn a_study_has_the_numbers_of_the_commands() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    study_file(at, &[]);
    let plan = expect(at, &["run", "mine.json", "--dry-run"]);
    assert!(
        plan.contains("5 trials (5 to run)") && plan.contains("(2 to simulate)"),
        "{plan}"
    );
    assert!(
        !at.join("results/mine").exists(),
        "a dry run writes nothing"
    );
    let printed = expect(at, &["run", "mine.json"]);
    assert!(
        printed.contains("holds: landmarks beat images"),
        "{printed}"
    );
    // Nothing is known of how long trials take before the first have run.
    assert!(plan.contains("slam take is known"), "{plan}");
    study_file(at, &[("seeds", json!({"filter": 3}))]);
    let more = expect(at, &["run", "mine.json", "--dry-run"]);
    assert!(
        more.contains("trials: about") && more.contains("MiB"),
        "{more}"
    );
    study_file(at, &[]);
    let ours = summary(at, "results");
    let figures = at.join("results/mine/figures");
    for figure in ["mae_m_bars", "error_cdf", "paths_0", "map_0", "landmarks_0"] {
        let picture = figures.join(format!("{figure}.png"));
        assert!(picture.exists(), "{figure}");
    }
    let table = std::fs::read_to_string(figures.join("table_0.md")).unwrap();
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows.len(), 2 + 5, "{table}");
    assert!(rows[2].starts_with("| all | doppler | 0."), "{table}");
    for path in ["mapping", "localization"] {
        let simulate = [
            "simulate",
            "room.json",
            "--engine",
            "image-source",
            "--path",
            path,
            "-o",
            path,
        ];
        expect(at, &simulate);
    }
    let by_command = |arguments: &[&str]| -> f64 {
        let all = [arguments, &["--json"]].concat();
        let report: Value = serde_json::from_str(&expect(at, &all)).unwrap();
        report["mae_m"].as_f64().unwrap()
    };
    expect(
        at,
        &["map", "mapping", "-o", "map", "--method", "landmarks"],
    );
    let landmarks = [
        "localize",
        "localization",
        "--map",
        "map",
        "--method",
        "landmarks",
        "-o",
        "l.tum",
    ];
    let slam = ["slam", "localization", "-o", "s.tum"];
    // Truth at the estimate's time is taken between its samples there, at the nearest sample here.
    for (method, command) in [("landmarks", &landmarks[..]), ("slam", &slam[..])] {
        let (study, command) = (mae_m(&ours, method), by_command(command));
        assert!(
            (study - command).abs() < 2e-3,
            "{method}: {study} {command}"
        );
    }
    assert!(mae_m(&ours, "doppler") < mae_m(&ours, "odometry"));
    assert!(mae_m(&ours, "multipath") < 0.2);
}

#[test]
fn threads_and_interruptions_change_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let changes = [
        ("vary", json!([{"noise.snr_db": [0, null]}])),
        ("seeds", json!({"filter": 2, "noise": 2})),
        ("methods", json!(["doppler", "toa-only", "landmarks"])),
        ("claims", json!([])),
    ];
    study_file(at, &changes);
    let trials = |results: &str, threads: &str| {
        let run = [
            "run",
            "mine.json",
            "--results",
            results,
            "--threads",
            threads,
            "--no-figures",
        ];
        expect(at, &run);
        std::fs::read_to_string(at.join(results).join("mine/data/trials.csv")).unwrap()
    };
    let one = trials("one", "1");
    assert_eq!(trials("two", "2"), one);
    // A run that finds half of its trials, and one that finds none of its recordings.
    let cached = std::fs::read_dir(at.join("two/cache/trials")).unwrap();
    for (number, entry) in cached.enumerate() {
        if number % 2 == 0 {
            std::fs::remove_file(entry.unwrap().path()).unwrap();
        }
    }
    assert_eq!(trials("two", "2"), one);
    std::fs::remove_dir_all(at.join("two/cache/recordings")).unwrap();
    assert_eq!(trials("two", "1"), one);
    // Where no figure shows what was heard, trials that were run need their recordings no more.
    let bars = [("figures", json!([{"kind": "bars"}]))];
    study_file(at, &[&changes[..], &bars].concat());
    std::fs::remove_dir_all(at.join("two/cache/recordings")).unwrap();
    assert_eq!(trials("two", "1"), one);
    assert!(!at.join("two/cache/recordings").exists());
    assert_eq!(one.lines().count(), 1 + 2 * (4 + 2) + 2 + 1);
}

/// Paths and maps of a cell that is not run are left out, and stay away where they were before.
#[test]
fn a_part_of_a_study_draws_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let of_the_second = json!({"localizer.particles": 60});
    study_file(
        at,
        &[
            ("vary", json!([{"localizer.particles": [50, 60]}])),
            ("methods", json!(["doppler"])),
            (
                "figures",
                json!([{"kind": "paths", "where": of_the_second}, {"kind": "map", "where": of_the_second}]),
            ),
            ("claims", json!([])),
        ],
    );
    let is_drawn = |name: &str| at.join("results/mine").join(name).exists();
    for (cell, whole) in [("particles=60", true), ("particles=50", false)] {
        expect(at, &["run", "mine.json", "--only", cell]);
        for name in ["data/paths_0.csv", "data/map_0.npy"] {
            assert_eq!(is_drawn(name), whole, "{cell}: {name}");
        }
    }
    expect(at, &["run", "mine.json"]);
    assert!(is_drawn("figures/paths_0.png") && is_drawn("figures/map_0.png"));
}

#[test]
fn two_results_are_compared_trial_by_trial() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let changes = |particles: u64| {
        [
            ("methods", json!(["doppler", "odometry"])),
            ("seeds", json!({"filter": 4})),
            (
                "set",
                json!({"field.engine": "image-source", "localizer.particles": particles}),
            ),
            ("claims", json!([])),
        ]
    };
    for (results, particles) in [("few", 5), ("many", 100)] {
        study_file(at, &changes(particles));
        expect(
            at,
            &[
                "run",
                "mine.json",
                "--results",
                results,
                "--cache",
                "cache",
                "--no-figures",
            ],
        );
    }
    let compare = [
        "compare",
        "few/mine",
        "many/mine",
        "--figure",
        "d.png",
        "--json",
    ];
    let found: Value = serde_json::from_str(&expect(at, &compare)).unwrap();
    let row = |method: &str| {
        let rows = found.as_array().unwrap().iter();
        rows.clone()
            .find(|row| row["method"] == method)
            .unwrap()
            .clone()
    };
    assert_eq!(row("doppler")["trials"], 4);
    assert!(
        row("doppler")["difference"].as_f64().unwrap() < 0.0,
        "{found}"
    );
    assert_eq!(row("odometry")["difference"], 0.0);
    assert!(at.join("d.png").exists());
    let refused = refuse(at, &["compare", "few/mine", "nothing"]);
    assert!(refused.contains("trials.csv"), "{refused}");
}

#[test]
fn a_study_replaces_only_its_own_results() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    study_file(
        at,
        &[
            ("methods", json!(["odometry"])),
            ("figures", json!([{"kind": "bars"}])),
            ("claims", json!([])),
        ],
    );
    std::fs::create_dir_all(at.join("results/mine")).unwrap();
    std::fs::write(at.join("results/mine/summary.json"), "{\"my\": \"notes\"}").unwrap();
    let refused = refuse(at, &["run", "mine.json"]);
    assert!(
        refused.contains("summary.json") && refused.contains("--force"),
        "{refused}"
    );
    let quick = &*project_file("studies/quick/quick.json");
    for (arguments, word) in [
        (
            &["run", "mine.json", "--image-order", "3"][..],
            "--image-order",
        ),
        (&["run", quick, "--only", "a=b"][..], "--only"),
        (&["run", quick, "--on", "slurm"][..], "--on"),
        (&["plan", quick][..], "echolot run"),
        (&["study", "draw", quick][..], "echolot run"),
        (&["check", "mine.json"][..], "baseline"),
        (&["run", "no_such.json"][..], "no_such.json"),
        (&["study", "check", "room.json"][..], "room.json"),
    ] {
        let refused = refuse(at, arguments);
        assert!(refused.contains(word), "{arguments:?}: {refused}");
    }
    let listed = echolot(at, &["study", "check", "mine.json"]);
    assert!(String::from_utf8_lossy(&listed.stdout).contains("1 cell(s)"));
}

/// Two workers on one cache, killed at many moments and begun again, leave the bytes of one that was not.
#[test]
fn killed_workers_leave_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    study_file(
        at,
        &[
            ("vary", json!([{"localizer.periods": [2, 3, 4, 6]}])),
            ("seeds", json!({"filter": 2})),
            ("methods", json!(["doppler", "landmarks"])),
            ("claims", json!([])),
        ],
    );
    expect(
        at,
        &["run", "mine.json", "--results", "alone", "--no-figures"],
    );
    let whole = std::fs::read_to_string(at.join("alone/mine/data/trials.csv")).unwrap();
    let moments: u64 = std::env::var("ECHOLOT_MOMENTS").map_or(8, |text| text.parse().unwrap());
    for moment in 0..moments {
        if moment % 8 == 0 {
            drop(std::fs::remove_dir_all(at.join("cache")));
        }
        let worker = || {
            std::process::Command::new(env!("CARGO_BIN_EXE_echolot"))
                .current_dir(at)
                .args(["task", "mine.json", "--cache", "cache", "--threads", "1"])
                .stderr(std::process::Stdio::null())
                .spawn()
                .unwrap()
        };
        let mut workers = [worker(), worker()];
        let pause = 20 + moment * 7919 % 1500;
        std::thread::sleep(std::time::Duration::from_millis(pause));
        workers[moment as usize % 2].kill().unwrap();
        let other = &mut workers[1 - moment as usize % 2];
        std::thread::sleep(std::time::Duration::from_millis(pause / 3));
        other.kill().unwrap();
        // One that was done before its moment ended well.
        for worker in &mut workers {
            worker.wait().unwrap();
        }
    }
    let refused = refuse(at, &["task", "mine.json", "0123", "--cache", "cache"]);
    assert!(refused.contains("0123"), "{refused}");
    expect(at, &["task", "mine.json", "--cache", "cache"]);
    let plan = expect(at, &["plan", "mine.json", "--cache", "cache", "--json"]);
    let tasks: Vec<Value> = serde_json::from_str(&plan).unwrap();
    assert_eq!(tasks.len(), 2 + 8);
    assert!(tasks.iter().all(|task| task["done"] == true), "{plan}");
    expect(
        at,
        &["gather", "mine.json", "--cache", "cache", "--no-figures"],
    );
    let gathered = std::fs::read_to_string(at.join("results/mine/data/trials.csv")).unwrap();
    assert_eq!(gathered, whole);
    let leases = std::fs::read_dir(at.join("cache/leases")).unwrap().count();
    assert_eq!(leases, 0, "leases are given back");
    crate::room::note(
        "kills",
        "two workers of a study, killed",
        moments as usize,
        "same bytes",
    );
}
