//! The same bytes for the same physics.
//!
//! Layout: 1 m x 0.9 m with a slanted wall; a pair 6 cm apart; a broad periodic waveform; 40 ms.
//! Formula: a robot at rest is a robot of zero velocity; the number of threads and the engine are not physics.
//! Bias, tolerance: none, bit for bit.

use crate::rig::DT_S;
use fdtd::grid::Grid;
use fdtd::motion::{DriveLimits, DrivePath, Leg, MotionState, PoseSample};
use fdtd::scene::{Robot, Scene};
use fdtd::scheme::Scheme;
use fdtd::simulation::{Drive, Flow, SOURCE_STRENGTH_M2PS, Simulation, SimulationOptions};
use fdtd::validation::corner;
use fdtd::walls::Wall;
use fdtd::waveform::PeriodicWaveform;
use std::collections::BTreeMap;

const DURATION_S: f64 = 0.04;
const ROBOT: Robot = Robot {
    loudspeaker_offset_m: [0.03, 0.0],
    microphone_offset_m: [-0.03, 0.01],
};

fn pose(v_mps: f64, omega_radps: f64) -> MotionState {
    MotionState {
        x_m: 0.4013,
        y_m: 0.3579,
        heading_rad: 0.7,
        v_mps,
        omega_radps,
    }
}

fn scene(scheme: Scheme, path: DrivePath) -> Scene {
    let corner = corner::scene(scheme).expect("a valid drive");
    Scene {
        name: "a slanted wall".into(),
        grid: Grid {
            nx: 200,
            ny: 180,
            ..corner.grid
        },
        walls: vec![Wall {
            points_m: vec![[0.25, 0.7], [0.6, 0.62], [0.75, 0.3]],
            ..corner.walls[0].clone()
        }],
        robot: ROBOT,
        paths: BTreeMap::from([("drive".into(), path)]),
        ..corner
    }
}

fn waveform() -> PeriodicWaveform {
    let chips: Vec<f64> = (0..511)
        .map(|k| if (k * k + k / 3) % 7 < 3 { 1.0 } else { -1.0 })
        .collect();
    PeriodicWaveform::new(&chips, 511.0 / 40e3, 19e3, 1.0 / DT_S)
}

fn bytes(simulation: Simulation) -> Vec<u32> {
    bytes_with(simulation, |_| Flow::Continue)
}

/// What is heard when the observer says `flow` after so many steps.
fn bytes_with(mut simulation: Simulation, flow: impl Fn(u64) -> Flow) -> Vec<u32> {
    let outcome = simulation.run(&mut |progress, _| flow(progress.step));
    assert!(outcome.is_ok(), "{outcome:?}");
    let signal = simulation.signal();
    assert_eq!(signal.len(), (DURATION_S * 40e3) as usize);
    assert!(signal.iter().any(|p| p.abs() > 1e-3));
    signal.into_iter().map(f32::to_bits).collect()
}

fn heard(scheme: Scheme, path: &DrivePath, options: &SimulationOptions) -> Vec<u32> {
    bytes(
        Simulation::new(&scene(scheme, path.clone()), "drive", &waveform(), options)
            .expect("a valid scene"),
    )
}

#[test]
fn at_rest_is_zero_velocity() {
    // The pair that is pinned down below knows no drive to crop a domain to.
    let options = SimulationOptions {
        whole_domain: true,
        ..SimulationOptions::default()
    };
    let still = Leg {
        duration_s: 0.5 * DURATION_S,
        v_mps: 0.0,
        omega_radps: 0.0,
    };
    let poses = [0.0, 0.015, DURATION_S].map(|t_s| PoseSample {
        t_s,
        x_m: pose(0.0, 0.0).x_m,
        y_m: pose(0.0, 0.0).y_m,
        heading_rad: pose(0.0, 0.0).heading_rad,
    });
    for scheme in Scheme::ALL {
        let uniform = DrivePath::uniform(pose(0.0, 0.0), DURATION_S).expect("a valid drive");
        let legs = DrivePath::from_legs(pose(0.0, 0.0), &[still, still], DriveLimits::default())
            .expect("valid legs");
        let sampled = DrivePath::from_samples(&poses).expect("valid poses");
        let simulation = Simulation::new(
            &scene(scheme, uniform.clone()),
            "drive",
            &waveform(),
            &options,
        )
        .expect("a valid scene");
        let wave = waveform();
        let (source, receiver) = (
            pose(0.0, 0.0).point(ROBOT.loudspeaker_offset_m),
            pose(0.0, 0.0).point(ROBOT.microphone_offset_m),
        );
        let pinned = Drive::new(
            simulation.domain(),
            Box::new(move |_| source),
            Box::new(move |_| receiver),
            Box::new(move |t_s| SOURCE_STRENGTH_M2PS * wave.value(t_s)),
            false,
        );
        let domain = simulation.domain().clone();
        let at_rest = bytes(
            Simulation::from_parts(domain, pinned, DURATION_S, 40e3, 19e3, &options)
                .expect("valid parts"),
        );
        assert!(
            at_rest == bytes(simulation),
            "{scheme}: uniform drive of zero speed"
        );
        assert!(
            at_rest == heard(scheme, &legs, &options),
            "{scheme}: legs of zero speed"
        );
        assert!(
            at_rest == heard(scheme, &sampled, &options),
            "{scheme}: equal poses"
        );
    }
}

#[test]
fn threads_and_engine_do_not_matter() {
    let path = DrivePath::uniform(pose(0.4, 2.0), DURATION_S).expect("a valid drive");
    for scheme in Scheme::ALL {
        let with = |threads, reference_engine| {
            let options = SimulationOptions {
                threads,
                reference_engine,
                ..SimulationOptions::default()
            };
            heard(scheme, &path, &options)
        };
        let alone = with(1, false);
        for threads in [2, 3, 7] {
            assert!(alone == with(threads, false), "{scheme}: {threads} threads");
        }
        assert!(alone == with(1, true), "{scheme}: reference engine");
        let options = SimulationOptions {
            threads: 2,
            ..SimulationOptions::default()
        };
        let changing =
            Simulation::new(&scene(scheme, path.clone()), "drive", &waveform(), &options)
                .expect("a valid scene");
        let crew = |step: u64| Flow::OnThreads([1, 3, 2][(step / 700 % 3) as usize]);
        assert!(
            alone == bytes_with(changing, crew),
            "{scheme}: threads that come and go"
        );
    }
}
