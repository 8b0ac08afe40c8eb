//! A free-field drive in segments of time gives the signal of the same drive in one domain.
//!
//! Layout: 1.2 m x 1 m without walls; a robot at 0.9 m/s on a curve for 0.3 s with the microphone at the loudspeaker or
//! 0.1 m ahead of it; a code on a carrier of 10 kHz, up to 14 kHz; schemes slf and o13, kaiser12.
//! Formula: without walls there are no echoes, so that a domain around the drive's present place gives the signal of
//! one around the whole drive.
//! Bias: the layers, which are nearer in a segment (-90 dB; slf with the microphone apart -80 dB). Rounding errors of
//! both runs wander at a few hertz, far below the band, -65 dB and less of the direct wave.
//! Tolerance: the difference less its mean over 1 ms around it, in every 2.5 ms, below -70 dB of the direct wave's rms;
//! all of the difference below -60 dB. Threads, engine and interruptions: none, bit for bit.

use std::collections::BTreeMap;

use crate::rig::{
    Setting, assert_foreign, code_on_carrier, decibels, engine, handed_over, recorded, run_to,
};
use fdtd::grid::Grid;
use fdtd::motion::{DriveLimits, DrivePath, MotionState, VelocityCommand};
use fdtd::scene::{Robot, Scene};
use fdtd::scheme::Scheme;
use fdtd::simulation::{Flow, Simulation, SimulationOptions};
use fdtd::spread::Spread;
use oracles::laws::corner;

const DURATION_S: f64 = 0.3;
const BAND_HZ: [f64; 2] = [0.0, 14e3];

/// Setting of a scheme's runs.
fn setting(scheme: Scheme) -> Setting {
    Setting::drawn("free field in pieces", scheme.name())
}

fn scene(scheme: Scheme, apart_m: f64, duration_s: f64) -> Scene {
    let setting = setting(scheme);
    let conditions = &setting.conditions;
    let corner = corner::scene(&setting, scheme).expect("a valid drive");
    let start = MotionState {
        x_m: conditions.m(0.4013),
        y_m: conditions.m(0.3579),
        heading_rad: 0.4,
        v_mps: conditions.mps(0.9),
        omega_radps: conditions.hz(1.0),
    };
    let leg = VelocityCommand {
        duration_s: conditions.s(duration_s),
        v_mps: conditions.mps(0.9),
        omega_radps: conditions.hz(1.0),
    };
    let path =
        DrivePath::from_commands(start, &[leg], DriveLimits::default()).expect("a valid drive");
    Scene {
        grid: Grid {
            nx: 243,
            ny: 197,
            ..corner.grid
        },
        walls: Vec::new(),
        robot: Robot {
            loudspeaker_offset_m: [0.0; 2],
            microphone_offset_m: [conditions.m(apart_m), 0.0],
        },
        spread: Spread::Kaiser12,
        paths: BTreeMap::from([("drive".into(), path)]),
        ..corner
    }
}

fn simulation(scene: &Scene, options: SimulationOptions) -> Simulation {
    let conditions = setting(scene.scheme).conditions;
    let waveform = code_on_carrier(&conditions, 511, BAND_HZ);
    let options = SimulationOptions {
        free_field: true,
        ..options
    };
    Simulation::new(scene, "drive", &waveform, &options).expect("a valid scene")
}

fn undivided() -> SimulationOptions {
    SimulationOptions {
        whole_domain: true,
        ..SimulationOptions::default()
    }
}

fn rms(signal: &[f64]) -> f64 {
    (signal.iter().map(|p| p * p).sum::<f64>() / signal.len() as f64).sqrt()
}

#[test]
fn segments_sound_like_the_whole() {
    for scheme in [Scheme::Slf, Scheme::O13] {
        for apart_m in [0.0, 0.1] {
            let scene = scene(scheme, apart_m, DURATION_S);
            let (segments, whole) = (
                simulation(&scene, SimulationOptions::default()),
                simulation(&scene, undivided()),
            );
            assert!(
                segments.steps_total() > whole.steps_total() && segments.cells() < whole.cells(),
                "{scheme}: one segment"
            );
            let (joined, whole) = (recorded(segments), recorded(whole));
            assert_eq!(joined.len(), whole.len());
            let direct = rms(&whole.iter().map(|&p| f64::from(p)).collect::<Vec<_>>());
            let difference: Vec<f64> = joined
                .iter()
                .zip(&whole)
                .map(|(a, b)| f64::from(*a) - f64::from(*b))
                .collect();
            // Forty-one samples are a millisecond.
            let quick: Vec<f64> = difference
                .windows(41)
                .map(|around| around[20] - around.iter().sum::<f64>() / 41.0)
                .collect();
            let all_db = decibels(rms(&difference) / direct);
            let worst_db = quick
                .chunks(100)
                .map(|part| decibels(rms(part) / direct))
                .fold(f64::NEG_INFINITY, f64::max);
            println!(
                "free field in segments, {scheme}, microphone {apart_m} m apart: {all_db:.1} dB in all, \
                 at most {worst_db:.1} dB above 1 kHz"
            );
            assert!(all_db < -60.0, "{scheme}, {apart_m} m: {all_db} dB");
            assert!(worst_db < -70.0, "{scheme}, {apart_m} m: {worst_db} dB");
        }
    }
}

#[test]
fn a_short_drive_is_one_piece() {
    let scene = scene(Scheme::O13, 0.1, 0.02);
    let segments = simulation(&scene, SimulationOptions::default());
    let whole = simulation(&scene, undivided());
    assert_eq!(segments.steps_total(), whole.steps_total());
    assert!(recorded(segments) == recorded(whole));
}

#[test]
fn threads_engine_and_interruptions_do_not_matter() {
    let scene = scene(Scheme::O13, 0.1, 0.2);
    let with = |threads, reference_engine| simulation(&scene, engine(threads, reference_engine));
    let alone = recorded(with(1, false));
    assert!(alone == recorded(with(3, false)), "threads");
    assert!(alone == recorded(with(1, true)), "reference engine");

    // At the end of a segment, in a warm-up, while one fades in, and a little later.
    let mut ends = Vec::new();
    let mut last_s = 0.0;
    with(1, false)
        .run(&mut |progress, simulation| {
            if simulation.time_s() < last_s && ends.is_empty() {
                let warm = progress.step;
                ends = vec![warm - 256, warm - 1, warm, warm + 900, warm + 2500];
            }
            last_s = simulation.time_s();
            Flow::Continue
        })
        .expect("a finite field");
    assert_eq!(ends.len(), 5, "there is a second segment");
    for end in ends {
        let mut first = with(1, false);
        run_to(&mut first, end);
        let mut second = with(2, false);
        handed_over(&first, &mut second).expect("its own checkpoint");
        assert_eq!(second.step(), first.step());
        assert_eq!(second.time_s(), first.time_s());
        let (columns, rows, frame) = second.pressure_frame();
        assert_eq!(frame.len(), columns * rows);
        assert!(frame == first.pressure_frame().2);
        assert!(alone == recorded(second), "interrupted at step {end}");
    }
    let mut first = with(1, false);
    run_to(&mut first, 256);
    assert_foreign(&first, &mut simulation(&scene, undivided()));
}
