//! The scenes of the project are what the papers and their descriptions say.

use crate::scenes;
use fdtd::motion::DrivePath;
use fdtd::scene::Scene;
use fdtd::walls::rasterize;

/// Mean distance in metres between a drive and its dead reckoning with a steady error of the turn rate.
fn drift_m(path: &DrivePath, error_radps: f64) -> f64 {
    let steps = 10_000;
    let dt_s = path.duration_s() / f64::from(steps);
    let start = path.state_at(0.0);
    let (mut x, mut y, mut sum) = (start.x_m, start.y_m, 0.0);
    for step in 0..steps {
        let middle = path.state_at((f64::from(step) + 0.5) * dt_s);
        let heading = middle.heading_rad + error_radps * (f64::from(step) + 0.5) * dt_s;
        x += middle.v_mps * dt_s * heading.cos();
        y += middle.v_mps * dt_s * heading.sin();
        let now = path.state_at(f64::from(step + 1) * dt_s);
        sum += (x - now.x_m).hypot(y - now.y_m);
    }
    sum / f64::from(steps)
}

#[test]
fn four_walls_is_the_papers_study() {
    let scene = Scene::load(&scenes().join("four_walls.json")).unwrap();
    assert_eq!(
        (scene.grid.nx, scene.grid.ny, scene.grid.dx_m),
        (1000, 1000, 0.005)
    );
    assert!((scene.grid.dt_s * 120e3 - 1.0).abs() < 1e-12);
    let (localization, mapping) = (
        scene.path("localization").unwrap(),
        scene.path("mapping").unwrap(),
    );
    assert!(
        (localization.duration_s() - 40.0).abs() < 1e-9
            && (mapping.duration_s() - 45.0).abs() < 1e-9
    );
    let drift = drift_m(localization, 0.01);
    println!("dead reckoning with +0.01 rad/s is off by {drift:.3} m on average");
    // Enough for odometry to be five times worse than the paper's 0.042 m.
    assert!(drift >= 0.21);
    // Straights, turns both ways, and the speeds of a wheeled robot.
    let states: Vec<_> = (0..=4000)
        .map(|k| localization.state_at(f64::from(k) * 0.01))
        .collect();
    let share = |is: &dyn Fn(f64) -> bool| {
        states.iter().filter(|state| is(state.omega_radps)).count() as f64 / 4001.0
    };
    let turns = [
        share(&|omega| omega > 0.1),
        share(&|omega| omega < -0.1),
        share(&|omega| omega.abs() < 0.01),
    ];
    println!("left, right, straight: {turns:.2?}");
    assert!(turns[0] > 0.1 && turns[1] > 0.1 && turns[2] > 0.2);
    assert!(
        states
            .iter()
            .all(|state| state.omega_radps.abs() <= 0.61 && state.v_mps <= 0.401)
    );
    assert!(
        states.iter().filter(|state| state.v_mps < 0.199).count() < 60,
        "only the start is slower"
    );
    let (first, last) = (states[0], states[4000]);
    assert!((first.x_m - last.x_m).hypot(first.y_m - last.y_m) > 0.5);
    // The map is made with headings in all directions.
    let mut seen = [0; 12];
    for k in 0..4500 {
        let heading = mapping
            .state_at(f64::from(k) * 0.01)
            .heading_rad
            .rem_euclid(std::f64::consts::TAU);
        seen[(heading / (std::f64::consts::TAU / 12.0)) as usize % 12] += 1;
    }
    assert!(seen.iter().all(|&count| count > 180), "{seen:?}");
    // It crosses the mapping drive, but does not follow it.
    let mapped: Vec<_> = (0..=4500)
        .map(|k| mapping.state_at(f64::from(k) * 0.01))
        .collect();
    let near = states.iter().filter(|state| {
        mapped
            .iter()
            .any(|other| (state.x_m - other.x_m).hypot(state.y_m - other.y_m) < 0.02)
    });
    let share = near.count() as f64 / 4001.0;
    println!("{share:.3} of the drive lies within 2 cm of the mapping drive");
    assert!(share < 0.15);
    // A robot 0.4 m wide passes the walls on both drives.
    for path in [localization, mapping] {
        for k in 0..(10.0 * path.duration_s()) as u32 {
            let state = path.state_at(f64::from(k) * 0.1);
            for wall in &scene.walls {
                let thick = fdtd::walls::Wall {
                    thickness_m: 0.4,
                    ..wall.clone()
                };
                assert!(
                    !thick.contains([state.x_m, state.y_m]),
                    "at {:.1} s",
                    f64::from(k) * 0.1
                );
            }
        }
    }
}

#[test]
fn four_walls_is_open_with_one_closed_corner() {
    let scene = Scene::load(&scenes().join("four_walls.json")).unwrap();
    assert_eq!(scene.walls.len(), 4);
    let length_m: f64 = scene.walls.iter().map(fdtd::walls::Wall::length_m).sum();
    println!("{length_m:.2} m of wall and 4.1 m of gaps");
    assert!((8.0..12.0).contains(&length_m));
    let directions: Vec<f64> = scene
        .walls
        .iter()
        .map(|wall| {
            let [from, to] = wall.segments_m().next().unwrap();
            (to[1] - from[1])
                .atan2(to[0] - from[0])
                .to_degrees()
                .rem_euclid(180.0)
        })
        .collect();
    for (i, a) in directions.iter().enumerate() {
        for b in &directions[i + 1..] {
            let between = (a - b).rem_euclid(180.0);
            assert!(between.min(180.0 - between) > 3.0, "{directions:?}");
        }
    }
    // Walls share cells where they meet in a corner. All others are apart.
    let masks: Vec<_> = scene
        .walls
        .iter()
        .map(|wall| rasterize(&scene.grid, std::slice::from_ref(wall)))
        .collect();
    let touching = |a: usize, b: usize| {
        masks[a]
            .iter_solid()
            .any(|(ix, iy)| masks[b].is_solid(ix, iy))
    };
    let corners = (0..4)
        .flat_map(|a| (a + 1..4).map(move |b| (a, b)))
        .filter(|&(a, b)| touching(a, b))
        .count();
    assert_eq!(corners, 1);
}

#[test]
fn quick_is_the_same_physics_in_a_quarter_of_the_area() {
    let (full, quick) = (
        scenes().join("four_walls.json"),
        scenes().join("quick.json"),
    );
    let (full, quick) = (Scene::load(&full).unwrap(), Scene::load(&quick).unwrap());
    assert_eq!((quick.grid.nx, quick.grid.ny), (500, 500));
    assert_eq!(
        (quick.grid.dx_m, quick.grid.dt_s),
        (full.grid.dx_m, full.grid.dt_s)
    );
    assert_eq!(
        (quick.scheme, quick.spread, quick.waveform),
        (full.scheme, full.spread, full.waveform)
    );
    let durations = ["mapping", "localization"].map(|name| quick.path(name).unwrap().duration_s());
    assert!((durations[0] - 14.0).abs() < 1e-9 && (durations[1] - 10.0).abs() < 1e-9);
    // The drives of a scene do not run along each other.
    for scene in [full, quick] {
        let (map, drive) = (
            scene.path("mapping").unwrap(),
            scene.path("localization").unwrap(),
        );
        let points = |path: &DrivePath| -> Vec<[f64; 2]> {
            (0..=400)
                .map(|k| path.point_at(path.duration_s() * f64::from(k) / 400.0, [0.0, 0.0]))
                .collect()
        };
        let (map, drive) = (points(map), points(drive));
        let near = |p: &&[f64; 2]| map.iter().any(|q| (p[0] - q[0]).hypot(p[1] - q[1]) < 0.03);
        let shared = drive.iter().filter(near).count() as f64 / drive.len() as f64;
        println!(
            "{}: {:.0} % of the drive within 3 cm of the mapping path",
            scene.name,
            100.0 * shared
        );
        assert!(shared < 0.35);
    }
}

#[test]
fn the_site_has_corner_echoes_up_to_six_metres_and_speeds_of_the_paper() {
    // Section IV of the 2024 paper: 50 kHz, round trips up to about 6 m; 45 s of mapping, 40 s of localization.
    let scene = Scene::load(&scenes().join("site.json")).unwrap();
    assert_eq!(scene.sample_rate_hz, 50_000.0);
    let steps_per_sample = 1.0 / (scene.grid.dt_s * scene.sample_rate_hz);
    assert!((steps_per_sample - steps_per_sample.round()).abs() < 1e-9);
    let [from, to] = [
        scene.robot.loudspeaker_offset_m,
        scene.robot.microphone_offset_m,
    ];
    assert!(((from[0] - to[0]).hypot(from[1] - to[1]) - 0.1).abs() < 1e-9);
    // One wall of two parts with a right angle at its apex; the others are single and at right angles to nothing.
    let corners: Vec<_> = scene
        .walls
        .iter()
        .filter(|wall| wall.points_m.len() == 3)
        .collect();
    assert_eq!((scene.walls.len(), corners.len()), (3, 1));
    let [a, apex, b] = [0, 1, 2].map(|k| corners[0].points_m[k]);
    let arm = |end: [f64; 2]| [end[0] - apex[0], end[1] - apex[1]];
    let (one, other) = (arm(a), arm(b));
    assert!((one[0] * other[0] + one[1] * other[1]).abs() < 1e-3);
    let drive = scene.path("localization").unwrap();
    let durations = ["mapping", "localization"].map(|name| scene.path(name).unwrap().duration_s());
    assert!((durations[0] - 45.0).abs() < 1e-9 && (durations[1] - 40.0).abs() < 1e-9);
    let mut farthest_m = 0.0_f64;
    for step in 20..400 {
        let state = drive.state_at(0.1 * f64::from(step));
        assert!((0.19..=0.41).contains(&state.v_mps), "{} m/s", state.v_mps);
        farthest_m = farthest_m.max(2.0 * (apex[0] - state.x_m).hypot(apex[1] - state.y_m));
    }
    println!("corner echoes up to {farthest_m:.2} m round trip");
    assert!((farthest_m - 6.0).abs() < 0.5, "{farthest_m}");
}
