//! The echo of a rigid wall: its delay and level beside those of the image source behind the wall.
//!
//! `cargo run --release -p fdtd --example echo_of_a_wall`

use std::path::Path;

use fdtd::scene::Scene;
use fdtd::simulation::{Flow, Simulation, SimulationOptions};
use fdtd::waveform::PeriodicWaveform;

/// A robot at rest in front of a wall whose face lies at y = 1.98 m.
const SCENE: &str = r#"{
    "name": "wall",
    "medium": { "c_mps": 340.0, "rho_kgpm3": 1.293 },
    "grid": { "nx": 400, "ny": 240, "dx_m": 0.01, "dt_s": 1.6666666666666667e-05 },
    "walls": [{ "points_m": [[0.4, 2.0], [3.6, 2.0]], "thickness_m": 0.04 }],
    "waveform": { "carrier_hz": 2500.0, "band_hz": [500.0, 5000.0] },
    "sample_rate_hz": 20000.0,
    "robot": { "loudspeaker_offset_m": [0.3, 0.0], "microphone_offset_m": [-0.3, 0.0] },
    "paths": {
        "rest": {
            "start": { "x_m": 2.0, "y_m": 0.8, "heading_rad": 0.0 },
            "legs": [{ "duration_s": 0.02, "v_mps": 0.0, "omega_radps": 0.0 }]
        }
    }
}"#;
/// Distance of loudspeaker and microphone, and of both to the wall's face, in metres.
const APART_M: f64 = 0.6;
const TO_WALL_M: f64 = 1.18;

fn main() -> Result<(), fdtd::Error> {
    let scene = Scene::from_json(SCENE, Path::new("wall.json"))?;
    let rate_hz = 1.0 / scene.grid.dt_s;
    let click: Vec<f64> = (0..4096)
        .map(|n| if n == 100 { 1.0 } else { 0.0 })
        .collect();
    let period_s = scene.waveform.period_s();
    let click = PeriodicWaveform::with_band(&click, period_s, scene.waveform.band_hz, rate_hz);
    let received = |free_field| {
        let options = SimulationOptions {
            free_field,
            ..SimulationOptions::default()
        };
        let mut simulation = Simulation::new(&scene, "rest", &click, &options)?;
        simulation.run(&mut |_, _| Flow::Continue)?;
        Ok::<_, fdtd::Error>(simulation.received())
    };
    let (direct, both) = (received(true)?, received(false)?);
    let echo: Vec<f32> = both
        .iter()
        .zip(&direct)
        .map(|(both, direct)| both - direct)
        .collect();

    // The lag at which the echo is most like the direct wave, between steps by a parabola.
    let product = |a: &[f32], b: &[f32]| {
        a.iter()
            .zip(b)
            .map(|(&a, &b)| f64::from(a) * f64::from(b))
            .sum::<f64>()
    };
    let like: Vec<f64> = (0..echo.len())
        .map(|lag| product(&echo[lag..], &direct))
        .collect();
    let peak = (1..like.len() - 1)
        .max_by(|&a, &b| like[a].total_cmp(&like[b]))
        .unwrap_or(1);
    let [before, at, after] = [like[peak - 1], like[peak], like[peak + 1]];
    let part = 0.5 * (before - after) / (before - 2.0 * at + after);
    let height = at - 0.25 * (before - after) * part;
    let delay_ms = 1e3 * (peak as f64 + part) / rate_hz;
    let level_db = 20.0 * (height / product(&direct, &direct)).log10();

    let image_m = APART_M.hypot(2.0 * TO_WALL_M);
    let image_ms = 1e3 * (image_m - APART_M) / scene.medium.c_mps;
    // Pressure in the plane falls with the square root of the distance.
    let image_db = -10.0 * (image_m / APART_M).log10();
    println!("after the direct wave      field     image");
    println!("delay in ms           {delay_ms:10.4}{image_ms:10.4}");
    println!("level in dB           {level_db:10.3}{image_db:10.3}");
    Ok(())
}
