//! A robot drives in front of a right-angled corner: the whole chain of a recording against image sources.
//!
//! Layout: 1.8 m x 1.8 m, two walls through the layers that close a quarter of the plane; loudspeaker and microphone 8 cm apart on a robot that drives a
//! curve at 0.4 m/s; noise of 1.5 to 5 kHz for 0.15 s at 40 kHz. The free-field run of the same drive is subtracted.
//! Formula: two single echoes and the corner's, [`fdtd::image_source`], at retarded times of the moving images.
//! Bias: dispersion over 1 to 3 m; the two terms of the Hankel series leave 1e-3 of the nearest echo at 1.5 kHz.
//! Tolerance: 1 % of the echoes (root mean square), 0.02 dB. An echo left out, or one of half the strength, would be 20 % or more.

use crate::rig::{AIR, DT_S, DX_M, decibels, difference, norm};
use fdtd::grid::Grid;
use fdtd::image_source::{DrivingPair, ImageSourceOptions, synthesize};
use fdtd::motion::{DrivePath, MotionState};
use fdtd::scene::{Robot, Scene, WaveformSpec};
use fdtd::scheme::Scheme;
use fdtd::simulation::{Flow, Simulation, SimulationOptions};
use fdtd::spread::Spread;
use fdtd::walls::{Wall, WallModel};
use fdtd::waveform::PeriodicWaveform;
use std::collections::BTreeMap;

const RATE_HZ: f64 = 40e3;

fn scene() -> Scene {
    let start = MotionState {
        x_m: 0.62,
        y_m: 0.75,
        heading_rad: 0.4,
        v_mps: 0.4,
        omega_radps: 1.5,
    };
    Scene {
        name: "a right-angled corner".into(),
        description: String::new(),
        medium: AIR,
        grid: Grid {
            nx: 360,
            ny: 360,
            dx_m: DX_M,
            dt_s: DT_S,
        },
        layer_cells: 20,
        scheme: Scheme::M13,
        spread: Spread::Kaiser12,
        // Faces at x = 1.3 m and y = 1.4 m, on the cells' borders.
        walls: vec![Wall {
            points_m: vec![[1.31, -0.2], [1.31, 1.41], [-0.2, 1.41]],
            thickness_m: 0.02,
            impedance_pasm: None,
        }],
        wall_model: WallModel::default(),
        waveform: WaveformSpec::default(),
        sample_rate_hz: RATE_HZ,
        robot: Robot {
            loudspeaker_offset_m: [0.05, 0.01],
            microphone_offset_m: [-0.03, 0.0],
        },
        paths: BTreeMap::from([(
            "drive".into(),
            DrivePath::uniform(start, 0.15).expect("a valid drive"),
        )]),
    }
}

#[test]
fn a_recording_in_a_corner_is_that_of_the_image_sources() {
    let scene = scene();
    // Odd about time 0, where it starts: the field then begins without a jump.
    let chip = |k: u64| {
        if (k * k * 31 + k * 7) % 1009 < 504 {
            1.0
        } else {
            -1.0
        }
    };
    let chips: Vec<f64> = (0..1001)
        .map(|k| chip(k) - chip((1001 - k) % 1001))
        .collect();
    let waveform = PeriodicWaveform::with_band(&chips, 1001.0 / RATE_HZ, [1.5e3, 5e3], 1.0 / DT_S);
    let hear = |free_field| -> Vec<f64> {
        let options = SimulationOptions {
            free_field,
            threads: 1,
            ..SimulationOptions::default()
        };
        let mut simulation =
            Simulation::new(&scene, "drive", &waveform, &options).expect("a valid scene");
        simulation
            .run(&mut |_, _| Flow::Continue)
            .expect("a finite field");
        simulation.signal().into_iter().map(f64::from).collect()
    };
    let echoes = difference(&hear(false), &hear(true));
    let drive = DrivingPair {
        path: &scene.paths["drive"],
        loudspeaker_offset_m: scene.robot.loudspeaker_offset_m,
        microphone_offset_m: scene.robot.microphone_offset_m,
    };
    let images = |max_order| -> Vec<f64> {
        let options = ImageSourceOptions {
            max_order,
            ..ImageSourceOptions::default()
        };
        let signal = synthesize(&scene.walls, &drive, &waveform, &AIR, RATE_HZ, &options);
        signal.into_iter().map(f64::from).collect()
    };
    let expected = images(2);
    assert_eq!(echoes.len(), expected.len());
    // The field starts abruptly, the images softly: both have forgotten it by then.
    let from = (0.03 * RATE_HZ) as usize;
    let off = |expected: &[f64]| {
        norm(&difference(&echoes[from..], &expected[from..])) / norm(&expected[from..])
    };
    let level_db = decibels(norm(&echoes[from..]) / norm(&expected[from..]));
    let (error, single) = (off(&expected), off(&images(1)));
    println!(
        "corner: off by {error:.4} (without the corner's echo {single:.2}), level {level_db:+.3} dB"
    );
    assert!(error < 0.01, "off by {error}");
    assert!(level_db.abs() < 0.02, "level off by {level_db} dB");
    assert!(single > 0.2);
}
