//! Leaving out air beyond walls and drive does not change the signal.
//!
//! Layout: 2 m x 1.6 m with much air around a slanted rigid wall, one of two branches and a robot between them at 0.4
//! m/s for 60 ms; a code on a carrier of 10 kHz, up to 14 kHz; all schemes, whole and cut cells.
//! Formula: absorbing layers stand for air without end wherever they begin, so that the domain around walls and drive
//! gives the signal of the scene's.
//! Bias: the layers' reflection, nearer and at other angles (-66 to -85 dB of the echoes).
//! Tolerance: the difference of the two signals below -60 dB of the echoes' rms. Threads, engine and interruptions, and
//! everything outside a closed room with thick walls: none, bit for bit.

use std::collections::BTreeMap;

use crate::rig::{
    Setting, assert_foreign, code_on_carrier, decibels, difference, engine, handed_over, norm,
    recorded, run_to,
};
use fdtd::grid::Grid;
use fdtd::motion::{DrivePath, MotionState};
use fdtd::scene::Scene;
use fdtd::scheme::Scheme;
use fdtd::simulation::{Simulation, SimulationOptions};
use fdtd::walls::{Branch, Impedance, Wall, WallModel};
use oracles::laws::corner;

/// Setting of a scheme's runs.
fn setting(scheme: Scheme) -> Setting {
    Setting::before_surfaces(scheme, "cropped domain", scheme.name())
}

fn scene(scheme: Scheme, wall_model: WallModel) -> Scene {
    let setting = setting(scheme);
    let conditions = &setting.conditions;
    let corner = corner::scene(&setting, scheme).expect("a valid drive");
    let wall = |from: [f64; 2], to: [f64; 2], impedance| Wall {
        points_m: [from, to].map(|point| conditions.point(point)).to_vec(),
        thickness_m: conditions.m(0.02),
        impedance,
    };
    let branches = vec![
        Branch::resonance(conditions.hz(6e3), 200.0, 500.0),
        Branch::resistance(1600.0),
    ];
    let resonant = Impedance::Branches(branches);
    let start = MotionState {
        x_m: conditions.m(0.8),
        y_m: conditions.m(0.75),
        heading_rad: 0.4,
        v_mps: conditions.mps(0.4),
        omega_radps: conditions.hz(1.0),
    };
    let path = DrivePath::uniform(start, conditions.s(0.06)).expect("a valid drive");
    Scene {
        grid: Grid {
            nx: 403,
            ny: 317,
            ..corner.grid
        },
        walls: vec![
            wall([0.5, 1.03], [1.1, 1.15], None),
            wall([1.3, 0.5], [1.3, 1.0], Some(resonant)),
        ],
        wall_model,
        paths: BTreeMap::from([("drive".into(), path)]),
        ..corner
    }
}

fn simulation(scene: &Scene, options: SimulationOptions) -> Simulation {
    let conditions = setting(scene.scheme).conditions;
    let waveform = code_on_carrier(&conditions, 127, [500.0, 14e3]);
    Simulation::new(scene, "drive", &waveform, &options).expect("a valid scene")
}

fn whole() -> SimulationOptions {
    SimulationOptions {
        whole_domain: true,
        ..SimulationOptions::default()
    }
}

#[test]
fn air_beyond_the_walls_is_not_missed() {
    for scheme in Scheme::ALL {
        for model in [WallModel::Staircase, WallModel::CutCells] {
            let scene = scene(scheme, model);
            let cropped = simulation(&scene, SimulationOptions::default());
            assert!(cropped.cells() < 3 * scene.grid.cells() / 5, "{scheme}");
            let free = SimulationOptions {
                free_field: true,
                ..SimulationOptions::default()
            };
            let [cropped, whole, free] = [
                cropped,
                simulation(&scene, whole()),
                simulation(&scene, free),
            ]
            .map(|simulation| recorded(simulation).into_iter().map(f64::from).collect())
            .map(|signal: Vec<f64>| signal);
            let echoes = norm(&difference(&whole, &free));
            let off_db = decibels(norm(&difference(&cropped, &whole)) / echoes);
            println!("cropped domain, {scheme}, {model}: {off_db:.1} dB of the echoes");
            assert!(off_db < -60.0, "{scheme}, {model}: {off_db} dB");
        }
    }
}

#[test]
fn what_lies_deep_in_the_walls_of_a_closed_room_and_beyond_is_not_missed_at_all() {
    for (scheme, impedance) in [
        (Scheme::Slf, None),
        (Scheme::O13, Some(Impedance::Real(2000.0))),
        (Scheme::D25, None),
    ] {
        for model in [WallModel::Staircase, WallModel::CutCells] {
            let open = scene(scheme, model);
            let conditions = setting(scheme).conditions;
            let [low, high] = [[0.452, 0.453], [1.5, 1.15]].map(|point| conditions.point(point));
            let room = Wall {
                points_m: vec![low, [high[0], low[1]], high, [low[0], high[1]], low],
                thickness_m: conditions.m(0.3),
                impedance: impedance.clone(),
            };
            let scene = Scene {
                walls: vec![room],
                ..open
            };
            let cropped = simulation(&scene, SimulationOptions::default());
            // 150 x 80 cells of air, four of wall, twelve and the layer, of 342 x 272 that the walls take with theirs.
            assert!(
                cropped.cells() < 40_000,
                "{scheme}: {} cells",
                cropped.cells()
            );
            assert!(
                recorded(cropped) == recorded(simulation(&scene, whole())),
                "{scheme}, {model}"
            );
        }
    }
}

#[test]
fn threads_engine_and_interruptions_do_not_matter() {
    let scene = scene(Scheme::O13, WallModel::CutCells);
    let with = |threads, reference_engine| simulation(&scene, engine(threads, reference_engine));
    let alone = recorded(with(1, false));
    assert!(alone == recorded(with(3, false)), "threads");
    assert!(alone == recorded(with(1, true)), "reference engine");

    let mut first = with(1, false);
    run_to(&mut first, 3000);
    let mut second = with(2, false);
    handed_over(&first, &mut second).expect("its own checkpoint");
    assert!(alone == recorded(second), "interrupted");
    assert_foreign(&first, &mut simulation(&scene, whole()));
}

#[test]
fn pictures_show_the_scenes_domain() {
    let scene = scene(Scheme::Slf, WallModel::Staircase);
    let frame = |options| {
        let mut simulation = simulation(&scene, options);
        run_to(&mut simulation, 256);
        simulation.pressure_frame()
    };
    let (nx, ny, cropped) = frame(SimulationOptions::default());
    let (_, _, all) = frame(whole());
    assert_eq!((nx, ny, cropped.len()), (403, 317, all.len()));
    // The layers of the two begin elsewhere, but the loudest cell lies at the robot in both.
    let loudest = |frame: &[f32]| {
        (0..frame.len())
            .max_by(|&a, &b| frame[a].abs().total_cmp(&frame[b].abs()))
            .map(|cell| (cell % nx, cell / nx))
    };
    assert_eq!(loudest(&cropped), loudest(&all));
}
