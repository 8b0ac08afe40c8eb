//! Every parser against mutated files: none panics, takes more than a second, or more than 1 GiB of memory.
//!
//! Plain `cargo test` runs each target for two seconds on the files of `corpus/` and mutations of them. `make fuzz`
//! runs as many inputs as one likes; the variables of `bolero` (`BOLERO_RANDOM_ITERATIONS`,
//! `BOLERO_RANDOM_TEST_TIME_MS`, `BOLERO_RANDOM_SEED`) and its other engines work too. Under `--cfg fuzzing` the
//! field's kernels are left out, which take most of the time to compile.

mod harness;
mod streams;
#[path = "../../../experiments/src/bag/written.rs"]
mod written;

use std::path::Path;

use experiments::check::gate::Baseline;
use experiments::data::cache::unsealed;
use experiments::data::manifest::Manifest;
use experiments::data::table::Table;
use experiments::data::{estimate, json};
use experiments::figures::drawing::png;
use experiments::recordings::robot::Robot;
use experiments::study::{Study, StudySummary};
use experiments::summary::Summary;
use experiments::trials::TrialResult;
use fdtd::motion::DrivePath;
use fdtd::scene::Scene;
use fdtd::simulation::{Flow, Simulation, SimulationOptions};
use localizer::io::map_folder::parse_npy;
use localizer::io::{odometry_csv, wav};
use localizer::landmarks::LandmarkMap;
use localizer::recording::RecordingMeta;
use localizer::{MapImage, Parameters, Trajectory};

use harness::{corpus, fuzz, fuzz_text, line};

/// Cells of a field from which its check takes long, and of the largest that a machine can hold.
const MOST_CELLS: u64 = 10_000_000;
const EVERY_CELL: u64 = 1 << 40;

#[test]
fn scene() {
    fuzz_text("scene", |text| {
        // Poses of a file beside the scene are another target's.
        let text = text.replace("\"file\"", "\"none\"");
        // A field that fills the machine's memory is allowed, and its check looks at every cell of it.
        let scene: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
        let cells = |axis: &str| scene["grid"][axis].as_u64().unwrap_or_default();
        if (MOST_CELLS..=EVERY_CELL).contains(&cells("nx").saturating_mul(cells("ny"))) {
            return;
        }
        line(Scene::from_json(&text, Path::new("scene.json")));
    });
}

#[test]
fn study() {
    fuzz_text("study", |text| {
        if let Some(study) = line(Study::parse(text, Path::new("study.json"))) {
            assert!(!study.cells.is_empty() && !study.methods().is_empty());
        }
    });
    fuzz_text("study_summary", |text| {
        drop(line(json::parse::<StudySummary>(
            text,
            Path::new("summary.json"),
        )))
    });
}

#[test]
fn path() {
    for (name, is_csv) in [("path_csv", true), ("tum", false)] {
        fuzz_text(name, |text| {
            drop(line(DrivePath::from_text(text, is_csv, "path")))
        });
    }
}

#[test]
fn checkpoint() {
    let text = r#"{ "name": "open air", "grid": { "nx": 72, "ny": 72, "dx_m": 0.005, "dt_s": 8e-6 },
        "paths": { "p": { "start": { "x_m": 0.18, "y_m": 0.18, "heading_rad": 0.0 },
            "legs": [{ "duration_s": 0.01, "v_mps": 0.0, "omega_radps": 0.0 }] } } }"#;
    let scene = Scene::from_json(text, Path::new("open.json")).unwrap();
    let options = SimulationOptions {
        threads: 1,
        ..SimulationOptions::default()
    };
    let wave = scene.source_waveform().unwrap();
    let new = || Simulation::new(&scene, "p", &wave, &options).unwrap();
    let mut simulation = new();
    simulation.run(&mut |_, _| Flow::Stop).unwrap();
    let mut bytes = Vec::new();
    simulation.write_checkpoint(&mut bytes).unwrap();
    let mut other = new();
    other.read_checkpoint(&bytes, Path::new("c")).unwrap();
    assert_eq!(other.step(), simulation.step());
    let target = std::sync::Mutex::new(other);
    fuzz("checkpoint", vec![bytes], move |bytes| {
        let mut simulation = target.lock().unwrap();
        line(simulation.read_checkpoint(bytes, Path::new("c")));
    });
}

#[test]
fn recording_json() {
    fuzz_text("recording", |text| {
        if let Ok(meta) = localizer::io::json::parse::<RecordingMeta>(text)
            && line(meta.check("recording.json")).is_some()
        {
            let period = meta.signal_parameters().samples_per_period();
            assert!(period > 0 && period < 1 << 25);
            line(Parameters::default().for_recording(&meta).check());
        }
    });
}

#[test]
fn parameters() {
    fuzz_text("parameters", |text| {
        if let Ok(parameters) = localizer::io::json::parse::<Parameters>(text)
            && line(parameters.check()).is_some()
        {
            assert!(parameters.delays() > 0 && parameters.window_cells() > 0);
        }
    });
}

#[test]
fn sound() {
    fuzz("wav", corpus("wav"), |bytes| {
        for rate_hz in [40_000.0, 50_000.0] {
            if let Some(samples) = line(wav::parse(bytes.to_vec(), rate_hz, "a.wav")) {
                assert!(samples.iter().all(|sample| sample.is_finite()));
            }
        }
    });
}

#[test]
fn odometry() {
    fuzz_text("odometry", |text| {
        drop(line(odometry_csv::parse(text, "odometry.csv")))
    });
}

#[test]
fn trajectory() {
    fuzz_text("tum", |text| {
        if let Some(trajectory) = line(Trajectory::from_tum(text, "truth.tum")) {
            assert!(trajectory.t_s.is_sorted_by(|a, b| a < b));
            trajectory.jumps(1.0);
            trajectory.covered_pose_at(0.0);
        }
        estimate::is_ours(text.as_bytes());
    });
}

#[test]
fn map() {
    let map = MapImage {
        origin_cell: [-3, 5],
        cell_m: 0.1,
        intensity: ndarray::Array2::from_elem((4, 6), 1.0),
        toa_only: ndarray::Array2::from_elem((4, 6), 0.5),
        parameters: Parameters::default(),
    };
    let folder = tempfile::tempdir().unwrap();
    map.write(folder.path()).unwrap();
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let (intensity, toa) = (bytes("map.npy"), bytes("map_toa.npy"));
    let seeds = vec![bytes("map.json")];
    fuzz("map", seeds, |header| {
        let header = String::from_utf8_lossy(header);
        line(MapImage::from_bytes(
            &header,
            [&intensity, &toa],
            Path::new("map"),
        ));
    });
    fuzz(
        "npy",
        vec![bytes("map.npy"), bytes("map_toa.npy")],
        |bytes| {
            line(parse_npy(bytes, Path::new("map.npy")));
        },
    );
}

#[test]
fn landmarks() {
    fuzz_text("landmarks", |text| {
        drop(line(LandmarkMap::from_json(text, "landmarks.json")))
    });
}

#[test]
fn robot() {
    fuzz_text("robot", |text| {
        line(Robot::parse(text, Path::new("robot.json")));
    });
}

#[test]
fn baseline() {
    fuzz_text("baseline", |text| {
        if let Some(baseline) = line(Baseline::parse(text, Path::new("b.json"), "quick")) {
            assert!(!baseline.measures.is_empty());
        }
    });
}

#[test]
fn summary() {
    fuzz_text("summary", |text| {
        drop(line(json::parse::<Summary>(text, Path::new("s.json"))))
    });
}

#[test]
fn cache_entry() {
    let result = r#"{"t_s":[0.1],"x_m":[1.0],"y_m":[2.0],"heading_rad":[0.1],"error_m":[0.01],
        "heading_error_rad":[0.0]}"#;
    let value: serde_json::Value = serde_json::from_str(result).unwrap();
    let sealed = experiments::data::cache::sealed(&value)
        .unwrap()
        .into_bytes();
    assert!(unsealed::<TrialResult>(&sealed).is_some());
    fuzz("cache", vec![sealed], |bytes| {
        drop(unsealed::<TrialResult>(bytes))
    });
}

#[test]
fn manifest() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("map.npy"), "x").unwrap();
    let seed = serde_json::to_vec(&Manifest::of(folder.path()).unwrap()).unwrap();
    fuzz("manifest", vec![seed], |bytes| {
        let _ = serde_json::from_slice::<Manifest>(bytes);
    });
}

#[test]
fn table() {
    fuzz_text("table", |text| {
        if let Some(table) = line(Table::parse(text, "data.csv")) {
            line(table.numbers("snr_db"));
        }
    });
}

#[test]
fn picture() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.png");
    png::write_png(&file, 4, 3, &[7; 36]).unwrap();
    let seed = std::fs::read(&file).unwrap();
    assert!(png::is_ours(&seed));
    fuzz("png", vec![seed], |bytes| {
        png::is_ours(bytes);
    });
}
