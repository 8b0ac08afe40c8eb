//! Rows, data files and the figure of `echolot bench`.

use crate::room::{expect, refuse};

#[test]
fn bench_prints_rows_and_names_bad_flags() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let text = expect(at, &["bench", "--cells", "96x96", "--steps", "8", "--json"]);
    let rows: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
    for engine in ["reference", "fast"] {
        assert!(rows.iter().any(|row| row["engine"] == engine), "{text}");
    }
    for key in ["scheme", "nx", "ny", "threads", "gcells_per_s"] {
        assert!(rows.iter().all(|row| !row[key].is_null()), "{key}: {text}");
    }
    for cells in ["0x0", "abc", "96", "20x96", "9000000x9000000"] {
        let complaint = refuse(at, &["bench", "--cells", cells]);
        assert!(complaint.contains("--cells"), "{complaint}");
    }
    for flag in ["--steps", "--threads"] {
        assert!(refuse(at, &["bench", flag, "0"]).contains(flag));
    }
}

#[test]
fn bench_writes_its_data_and_draws_the_roofline_from_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    // One grid does not replace the whole table.
    let one = ["bench", "--cells", "96x96", "--steps", "8"];
    expect(at, &one);
    assert!(!at.join("results").exists());
    expect(at, &[&one[..], &["--output", "results/bench"]].concat());
    let read = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(at.join("results/bench").join(name)).unwrap())
            .unwrap()
    };
    let bench = read("bench.json");
    let rows = bench["rows"].as_array().unwrap();
    assert!(
        rows.iter().all(|row| row["peak_fraction"].is_f64()),
        "{bench}"
    );
    assert!(
        bench["peaks"]
            .as_array()
            .unwrap()
            .iter()
            .all(|peak| peak["memory_gbps"].is_f64())
    );
    assert!(
        bench["subnormal"]
            .as_array()
            .unwrap()
            .iter()
            .all(|row| row["time_ratio"].is_f64())
    );
    let steps = read("localizer.json");
    let stages: Vec<&str> = steps
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row["stage"].as_str().unwrap())
        .collect();
    assert_eq!(stages, ["doppler_bank", "filter_step"]);
    assert_eq!(steps[0]["directions"], 30);
    assert_eq!(steps[1]["particles"], 100);
    assert!(at.join("results/bench/roofline.png").exists());
}
