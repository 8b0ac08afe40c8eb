//! The echo of a wall at a moving robot: by the sound field, and by image sources.
//!
//! `cargo run --release -p oracles --example field_and_images`

use std::path::Path;

use fdtd::scene::Scene;
use fdtd::simulation::{Flow, Simulation, SimulationOptions};
use oracles::image_source::{self, DrivingPair, ImageSourceOptions};

/// A robot that drives along a wall.
const SCENE: &str = r#"{
    "name": "wall",
    "medium": { "c_mps": 340.0, "rho_kgpm3": 1.293 },
    "grid": { "nx": 400, "ny": 240, "dx_m": 0.01, "dt_s": 1.6666666666666667e-05 },
    "walls": [{ "points_m": [[0.4, 2.0], [3.6, 2.0]], "thickness_m": 0.04 }],
    "waveform": { "carrier_hz": 2500.0, "band_hz": [1000.0, 4000.0] },
    "sample_rate_hz": 20000.0,
    "robot": { "loudspeaker_offset_m": [0.05, 0.0], "microphone_offset_m": [-0.05, 0.0] },
    "paths": {
        "drive": {
            "start": { "x_m": 2.0, "y_m": 1.4, "heading_rad": 0.4, "v_mps": 0.3 },
            "legs": [{ "duration_s": 0.06, "v_mps": 0.3, "omega_radps": 0.0 }]
        }
    }
}"#;
/// Start of the comparison in seconds, after the onset.
const FROM_S: f64 = 0.03;

fn rms(signal: &[f64]) -> f64 {
    (signal.iter().map(|p| p * p).sum::<f64>() / signal.len() as f64).sqrt()
}

fn main() -> Result<(), fdtd::Error> {
    let scene = Scene::from_json(SCENE, Path::new("wall.json"))?;
    let code = scene.source_waveform()?;
    let signal = |free_field| {
        let options = SimulationOptions {
            free_field,
            ..SimulationOptions::default()
        };
        let mut simulation = Simulation::new(&scene, "drive", &code, &options)?;
        simulation.run(&mut |_, _| Flow::Continue)?;
        Ok::<_, fdtd::Error>(simulation.signal())
    };
    let drive = DrivingPair {
        path: scene.path("drive")?,
        loudspeaker_offset_m: scene.robot.loudspeaker_offset_m,
        microphone_offset_m: scene.robot.microphone_offset_m,
    };
    let options = ImageSourceOptions {
        include_direct: false,
        ..ImageSourceOptions::default()
    };
    let rate_hz = scene.sample_rate_hz;
    let images = image_source::synthesize(
        &scene.walls,
        &drive,
        &code,
        &scene.medium,
        rate_hz,
        &options,
    );

    let first = (FROM_S * rate_hz) as usize;
    let images: Vec<f64> = images[first..].iter().copied().map(f64::from).collect();
    let (walls, open) = (signal(false)?, signal(true)?);
    let field: Vec<f64> = walls[first..]
        .iter()
        .zip(&open[first..])
        .map(|(&walls, &open)| f64::from(walls) - f64::from(open))
        .collect();
    let difference: Vec<f64> = field
        .iter()
        .zip(&images)
        .map(|(field, image)| field - image)
        .collect();
    println!(
        "echo, rms in Pa: field {:.4}, image sources {:.4}",
        rms(&field),
        rms(&images)
    );
    println!(
        "difference {:.1} % of the echo",
        100.0 * rms(&difference) / rms(&images)
    );
    Ok(())
}
