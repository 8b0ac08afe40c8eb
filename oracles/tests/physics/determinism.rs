//! The same bytes for the same physics.
//!
//! Layout: 1 m x 0.9 m with a slanted wall; a pair 6 cm apart; a broad periodic waveform; 40 ms.
//! Formula: a robot at rest is a robot of zero velocity; the number of threads and the engine are not physics.
//! Bias, tolerance: none, bit for bit.

use crate::rig::{Conditions, Setting};
use fdtd::grid::Grid;
use fdtd::motion::{DriveLimits, DrivePath, MotionState, PoseSample, VelocityCommand};
use fdtd::scene::{Robot, Scene};
use fdtd::scheme::Scheme;
use fdtd::simulation::{Flow, MovingPair, SOURCE_STRENGTH_M2PS, Simulation, SimulationOptions};
use fdtd::walls::Wall;
use fdtd::waveform::PeriodicWaveform;
use oracles::laws::corner;
use std::collections::BTreeMap;

/// Upper end of the band on the papers' grid, in hertz.
const BAND_HZ: f64 = 19e3;

/// Setting of a scheme's runs.
fn setting(scheme: Scheme) -> Setting {
    Setting::drawn("determinism", scheme.name())
}

fn duration_s(conditions: &Conditions) -> f64 {
    conditions.s(0.04)
}

fn robot(conditions: &Conditions) -> Robot {
    Robot {
        loudspeaker_offset_m: conditions.point([0.03, 0.0]),
        microphone_offset_m: conditions.point([-0.03, 0.01]),
    }
}

fn pose(conditions: &Conditions, v_mps: f64, omega_radps: f64) -> MotionState {
    MotionState {
        x_m: conditions.m(0.4013),
        y_m: conditions.m(0.3579),
        heading_rad: 0.7,
        v_mps: conditions.mps(v_mps),
        omega_radps: conditions.hz(omega_radps),
    }
}

fn scene(scheme: Scheme, path: DrivePath) -> Scene {
    let setting = setting(scheme);
    let conditions = &setting.conditions;
    let corner = corner::scene(&setting, scheme).expect("a valid drive");
    Scene {
        name: "a slanted wall".into(),
        grid: Grid {
            nx: 203,
            ny: 181,
            ..corner.grid
        },
        walls: vec![Wall {
            points_m: [[0.25, 0.7], [0.6, 0.62], [0.75, 0.3]]
                .map(|point| conditions.point(point))
                .to_vec(),
            ..corner.walls[0].clone()
        }],
        robot: robot(conditions),
        paths: BTreeMap::from([("drive".into(), path)]),
        ..corner
    }
}

fn waveform(conditions: &Conditions) -> PeriodicWaveform {
    let chips: Vec<f64> = (0..511)
        .map(|k| if (k * k + k / 3) % 7 < 3 { 1.0 } else { -1.0 })
        .collect();
    let (period_s, rate_hz) = (conditions.s(511.0 / 40e3), 1.0 / conditions.dt_s);
    PeriodicWaveform::new(&chips, period_s, conditions.hz(BAND_HZ), rate_hz)
}

fn bytes(simulation: Simulation) -> Vec<u32> {
    bytes_with(simulation, |_| Flow::Continue)
}

/// Signal when the observer returns `flow` after so many steps.
fn bytes_with(mut simulation: Simulation, flow: impl Fn(u64) -> Flow) -> Vec<u32> {
    let outcome = simulation.run(&mut |progress, _| flow(progress.step));
    assert!(outcome.is_ok(), "{outcome:?}");
    let signal = simulation.signal();
    assert_eq!(signal.len(), 1600);
    assert!(signal.iter().any(|p| p.abs() > 1e-3));
    signal.into_iter().map(f32::to_bits).collect()
}

fn recorded(scheme: Scheme, path: &DrivePath, options: &SimulationOptions) -> Vec<u32> {
    let waveform = waveform(&setting(scheme).conditions);
    let scene = scene(scheme, path.clone());
    bytes(Simulation::new(&scene, "drive", &waveform, options).expect("a valid scene"))
}

#[test]
fn at_rest_is_zero_velocity() {
    // The pair that is pinned down below has no drive to crop a domain to.
    let options = SimulationOptions {
        whole_domain: true,
        ..SimulationOptions::default()
    };
    for scheme in Scheme::ALL {
        let conditions = setting(scheme).conditions;
        let (duration_s, robot) = (duration_s(&conditions), robot(&conditions));
        let pose = pose(&conditions, 0.0, 0.0);
        let still = VelocityCommand {
            duration_s: 0.5 * duration_s,
            v_mps: 0.0,
            omega_radps: 0.0,
        };
        let poses = [0.0, 0.015, duration_s].map(|t_s| PoseSample {
            t_s,
            x_m: pose.x_m,
            y_m: pose.y_m,
            heading_rad: pose.heading_rad,
        });
        let uniform = DrivePath::uniform(pose, duration_s).expect("a valid drive");
        let legs = DrivePath::from_commands(pose, &[still, still], DriveLimits::default())
            .expect("valid legs");
        let sampled = DrivePath::from_samples(&poses).expect("valid poses");
        let simulation = Simulation::new(
            &scene(scheme, uniform.clone()),
            "drive",
            &waveform(&conditions),
            &options,
        )
        .expect("a valid scene");
        let wave = waveform(&conditions);
        let (source, receiver) = (
            pose.point(robot.loudspeaker_offset_m),
            pose.point(robot.microphone_offset_m),
        );
        let pinned = MovingPair::new(
            simulation.domain(),
            Box::new(move |_| source),
            Box::new(move |_| receiver),
            Box::new(move |t_s| SOURCE_STRENGTH_M2PS * wave.value(t_s)),
            false,
        );
        let domain = simulation.domain().clone();
        let [rate_hz, band_hz] = [40e3, BAND_HZ].map(|hz| conditions.hz(hz));
        let at_rest = bytes(
            Simulation::from_parts(domain, pinned, duration_s, rate_hz, band_hz, &options)
                .expect("valid parts"),
        );
        assert!(
            at_rest == bytes(simulation),
            "{scheme}: uniform drive of zero speed"
        );
        assert!(
            at_rest == recorded(scheme, &legs, &options),
            "{scheme}: legs of zero speed"
        );
        assert!(
            at_rest == recorded(scheme, &sampled, &options),
            "{scheme}: equal poses"
        );
    }
}

#[test]
fn threads_and_engine_do_not_matter() {
    for scheme in Scheme::ALL {
        let conditions = setting(scheme).conditions;
        let start = pose(&conditions, 0.4, 2.0);
        let path = DrivePath::uniform(start, duration_s(&conditions)).expect("a valid drive");
        let with = |threads, reference_engine| {
            let options = SimulationOptions {
                threads,
                reference_engine,
                ..SimulationOptions::default()
            };
            recorded(scheme, &path, &options)
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
        let changing = Simulation::new(
            &scene(scheme, path),
            "drive",
            &waveform(&conditions),
            &options,
        )
        .expect("a valid scene");
        let crew = |step: u64| Flow::OnThreads([1, 3, 2][(step / 700 % 3) as usize]);
        assert!(
            alone == bytes_with(changing, crew),
            "{scheme}: threads that come and go"
        );
    }
}
