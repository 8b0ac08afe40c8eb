//! A small room for tests, and the program that is tested.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use fdtd::scene::Scene;

/// A scene file with four walls and the drives `mapping`, `localization` and `short`.
pub(crate) const ROOM: &str = r#"{
  "name": "room",
  "grid": {"nx": 500, "ny": 500, "dx_m": 0.005, "dt_s": 8.333333333333333e-6},
  "walls": [
    {"points_m": [[0.35, 2.1], [0.4, 0.4], [2.0, 0.32]], "thickness_m": 0.02},
    {"points_m": [[2.15, 0.6], [2.2, 2.0]], "thickness_m": 0.02},
    {"points_m": [[0.7, 2.2], [1.9, 2.12]], "thickness_m": 0.02}
  ],
  "paths": {
    "mapping": {"start": {"x_m": 1.6, "y_m": 1.25, "heading_rad": 1.5708, "v_mps": 0.3},
      "legs": [{"duration_s": 8, "v_mps": 0.3, "omega_radps": 0.8},
        {"duration_s": 7, "v_mps": 0.3, "omega_radps": 1.0}]},
    "localization": {"start": {"x_m": 0.85, "y_m": 0.9, "heading_rad": 0.2, "v_mps": 0.22},
      "legs": [{"duration_s": 5, "v_mps": 0.22, "omega_radps": 0.4},
        {"duration_s": 5, "v_mps": 0.22, "omega_radps": 0.6}]},
    "short": {"start": {"x_m": 0.85, "y_m": 0.9, "heading_rad": 0.2, "v_mps": 0.22},
      "legs": [{"duration_s": 0.12, "v_mps": 0.22, "omega_radps": 0.4}]}
  }
}"#;

/// The room as a checked scene.
pub(crate) fn scene() -> Scene {
    Scene::from_json(ROOM, Path::new("room.json")).unwrap()
}

/// Writes the scene file into a folder.
pub(crate) fn scene_file(folder: &Path) -> PathBuf {
    let path = folder.join("room.json");
    std::fs::write(&path, ROOM).unwrap();
    path
}

/// `echolot simulate` of the drive `short` by image sources, up to the recording's name.
pub(crate) const SIMULATE: [&str; 7] = [
    "simulate",
    "room.json",
    "--path",
    "short",
    "--engine",
    "image-source",
    "-o",
];

/// Runs `echolot` in `folder`.
pub(crate) fn echolot(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_echolot"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

/// Runs `echolot` in `folder`, expects success and returns what it prints.
pub(crate) fn expect(folder: &Path, arguments: &[&str]) -> String {
    let output = echolot(folder, arguments);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {complaint}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs `echolot` in `folder`, expects exit code 2 and returns its one-line complaint.
pub(crate) fn refuse(folder: &Path, arguments: &[&str]) -> String {
    let output = echolot(folder, arguments);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {complaint}");
    assert!(complaint.starts_with("error: "), "{complaint}");
    assert_eq!(complaint.trim_end().lines().count(), 1, "{complaint}");
    complaint
}

/// The scene file, and by image sources the recordings `mapping` and `drive`.
pub(crate) fn drives(folder: &Path) {
    scene_file(folder);
    for (path, output) in [("mapping", "mapping"), ("localization", "drive")] {
        let simulate = ["simulate", "room.json", "--path", path, "-o", output];
        expect(
            folder,
            &[&simulate[..], &["--engine", "image-source"]].concat(),
        );
    }
}

/// As [`drives`], and the map `map`.
pub(crate) fn drives_and_map(folder: &Path) {
    drives(folder);
    expect(folder, &["map", "mapping", "-o", "map"]);
}

/// A path of a file of the project.
pub(crate) fn project_file(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    root.join(name).display().to_string()
}

/// The papers' studies in the quick scene, as `quick.json`, and the scene beside them.
pub(crate) fn quick_scene(folder: &Path) {
    std::fs::create_dir(folder.join("scenes")).unwrap();
    for (from, to) in [
        ("scenes/quick.json", "scenes/quick.json"),
        ("studies/quick/quick.json", "quick.json"),
    ] {
        let text = std::fs::read_to_string(project_file(from)).unwrap();
        std::fs::write(folder.join(to), text.replace("../../scenes", "scenes")).unwrap();
    }
}

/// Adds a line to the list of what was tried, where one is kept: see `echolot robustness`.
pub(crate) fn note(kind: &str, what: &str, count: usize, result: &str) {
    let Some(list) = std::env::var_os("ECHOLOT_TRIED") else {
        return;
    };
    let line = serde_json::json!({"kind": kind, "what": what, "count": count, "result": result});
    let mut file = std::fs::OpenOptions::new()
        .append(true)
        .create(true)
        .open(list)
        .unwrap();
    std::io::Write::write_all(&mut file, format!("{line}\n").as_bytes()).unwrap();
}
