//! Scene files: the scenes of the project, fields and defaults, and what is refused and how.

mod any_change;
mod fields;
mod project;
mod random;
mod refused;

use fdtd::scene::Scene;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

pub(crate) fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes")
}

/// A small scene that is in order.
pub(crate) fn small() -> Value {
    json!({
        "name": "small",
        "description": "A wall in front of a robot",
        "medium": { "c_mps": 340.0, "rho_kgpm3": 1.293 },
        "grid": { "nx": 200, "ny": 160, "dx_m": 0.005, "dt_s": 8.333333333333333e-6 },
        "layer_cells": 20,
        "scheme": "m13",
        "spread": "kaiser8",
        "walls": [
            { "points_m": [[0.7, 0.2], [0.75, 0.6]], "thickness_m": 0.02 },
            { "points_m": [[0.2, 0.15], [0.5, 0.15]] }
        ],
        "waveform": { "code_length": 1023, "chip_rate_hz": 1e4, "carrier_hz": 1e4, "band_hz": [0.0, 19000.0] },
        "sample_rate_hz": 40000.0,
        "robot": { "loudspeaker_offset_m": [0.0, 0.0], "microphone_offset_m": [0.01, 0.0] },
        "paths": {
            "forward": {
                "start": { "x_m": 0.3, "y_m": 0.4, "heading_rad": 0.0, "v_mps": 0.3 },
                "acceleration_mps2": 1.0,
                "legs": [
                    { "duration_s": 0.5, "v_mps": 0.3, "omega_radps": 0.0 },
                    { "duration_s": 0.5, "v_mps": 0.2, "omega_radps": 0.5 }
                ]
            }
        }
    })
}

pub(crate) fn read(value: &Value) -> Result<Scene, fdtd::Error> {
    Scene::from_json(&value.to_string(), Path::new("somewhere/test.json"))
}

/// The message of a scene that must be refused.
pub(crate) fn refusal(value: &Value) -> String {
    let message = read(value).expect_err("must be refused").to_string();
    assert!(!message.contains('\n'), "{message}");
    assert!(message.starts_with("somewhere/"), "{message}");
    message
}

/// `small()` with the value at a JSON pointer replaced.
pub(crate) fn with(pointer: &str, value: Value) -> Value {
    let mut scene = small();
    *scene.pointer_mut(pointer).expect("the pointer is right") = value;
    scene
}
