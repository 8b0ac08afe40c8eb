//! Scene files: the scenes of the project, the schema, defaults, and what is refused and how.

use fdtd::motion::DrivePath;
use fdtd::scene::Scene;
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::walls::rasterize;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes")
}

/// A small scene that is in order.
fn small() -> Value {
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

fn read(value: &Value) -> Result<Scene, fdtd::Error> {
    Scene::from_json(&value.to_string(), Path::new("somewhere/test.json"))
}

/// The message of a scene that must be refused.
fn refusal(value: &Value) -> String {
    let message = read(value).expect_err("must be refused").to_string();
    assert!(!message.contains('\n'), "{message}");
    assert!(message.starts_with("somewhere/"), "{message}");
    message
}

/// `small()` with the value at a JSON pointer replaced.
fn with(pointer: &str, value: Value) -> Value {
    let mut scene = small();
    *scene.pointer_mut(pointer).expect("the pointer is right") = value;
    scene
}

#[test]
fn fields_arrive_where_they_belong() {
    let scene = read(&small()).unwrap();
    assert_eq!(
        (scene.name.as_str(), scene.grid.nx, scene.grid.ny),
        ("small", 200, 160)
    );
    assert_eq!(
        (scene.scheme, scene.spread, scene.layer_cells),
        (Scheme::M13, Spread::Kaiser8, 20)
    );
    assert_eq!(scene.walls[1].thickness_m, 0.02);
    assert_eq!(scene.robot.microphone_offset_m, [0.01, 0.0]);
    assert!((scene.waveform.period_s() - 0.1023).abs() < 1e-15);
    let path = scene.path("forward").unwrap();
    assert_eq!(path.duration_s(), 1.0);
    assert_eq!(path.state_at(0.0).v_mps, 0.3);
    let message = scene.path("back").unwrap_err().to_string();
    assert!(
        message.contains("\"back\"") && message.contains("forward"),
        "{message}"
    );
}

#[test]
fn what_is_left_out_is_as_in_the_papers_tables() {
    let scene = read(
        &json!({ "name": "bare", "grid": { "nx": 100, "ny": 100, "dx_m": 0.005, "dt_s": 8e-6 } }),
    )
    .unwrap();
    assert_eq!((scene.medium.c_mps, scene.medium.rho_kgpm3), (340.0, 1.293));
    assert_eq!(
        (scene.scheme, scene.spread, scene.layer_cells),
        (Scheme::M13, Spread::Kaiser12, 20)
    );
    assert_eq!(
        (scene.waveform.code_length, scene.waveform.band_hz),
        (1023, [0.0, 19e3])
    );
    assert_eq!(scene.sample_rate_hz, 40e3);
}

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
            && (mapping.duration_s() - 37.4).abs() < 1e-9
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
    for k in 0..3740 {
        let heading = mapping
            .state_at(f64::from(k) * 0.01)
            .heading_rad
            .rem_euclid(std::f64::consts::TAU);
        seen[(heading / (std::f64::consts::TAU / 12.0)) as usize % 12] += 1;
    }
    assert!(seen.iter().all(|&count| count > 180), "{seen:?}");
    // The robot's centre keeps 0.35 m from walls on both drives.
    for path in [localization, mapping] {
        for k in 0..400 {
            let state = path.state_at(f64::from(k) * 0.1);
            for wall in &scene.walls {
                let thick = fdtd::walls::Wall {
                    thickness_m: 0.7,
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
    println!("{length_m:.2} m of wall around 15.8 m");
    assert!((9.0..12.0).contains(&length_m));
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
    assert!((durations[0] - 15.0).abs() < 1e-9 && (durations[1] - 10.0).abs() < 1e-9);
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
fn the_schema_file_is_current() {
    let file = scenes().join("scene.schema.json");
    let schema = serde_json::to_string_pretty(&Scene::json_schema()).unwrap() + "\n";
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&file, &schema).unwrap();
    }
    let stored = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(
        stored == schema,
        "scenes/scene.schema.json is out of date: run this test with BLESS=1"
    );
}

#[test]
fn the_parser_names_the_field_and_the_place() {
    let text = serde_json::to_string_pretty(&small()).unwrap();
    for (from, to, expected) in [
        (
            "\"v_mps\": 0.2",
            "\"v_mps\": \"fast\"",
            "paths.forward.legs[1].v_mps (line ",
        ),
        (
            "\"v_mps\": 0.2",
            "\"v_mph\": 0.2",
            "paths.forward.legs[1].v_mph (line ",
        ),
        (
            "\"v_mps\": 0.2",
            "\"v_mps\": 1e999",
            "paths.forward.legs[1].v_mps (line ",
        ),
        (
            "\"v_mps\": 0.2",
            "\"v_mps\": NaN",
            "paths.forward.legs[1].v_mps (line ",
        ),
        (
            "\"duration_s\": 0.5,\n",
            "",
            "paths.forward.legs[0].duration_s (line ",
        ),
        (
            "\"scheme\": \"m13\"",
            "\"scheme\": \"m14\"",
            "scheme (line ",
        ),
        ("\"nx\": 200", "\"nx\": -3", "grid.nx (line "),
        ("\"nx\": 200", "\"nx\": 200.5", "grid.nx (line "),
        ("\"dx_m\": 0.005,", "", "grid.dx_m (line "),
        ("\"name\": \"small\",", "", "the scene"),
        (
            "\"name\": \"small\",",
            "\"name\": \"small\", \"name\": \"again\",",
            "name (line ",
        ),
    ] {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text, "{from}");
        let message = Scene::from_json(&changed, Path::new("bad.json"))
            .unwrap_err()
            .to_string();
        let expected = if expected == "the scene" {
            "name (line "
        } else {
            expected
        };
        assert!(
            message.starts_with(&format!("bad.json: {expected}")),
            "{message}"
        );
        assert!(
            message.contains("column") && !message.contains('\n'),
            "{message}"
        );
    }
    for text in [
        "",
        "{",
        "[]",
        "nonsense",
        "{\"name\": \"a\" \"grid\": 3}",
        "\u{feff}{}",
        "{\"a\nb\": 1}",
    ] {
        let message = Scene::from_json(text, Path::new("bad.json"))
            .unwrap_err()
            .to_string();
        assert!(
            message.starts_with("bad.json: ") && !message.contains('\n'),
            "{message}"
        );
    }
}

#[test]
fn steps_and_bands_beyond_the_limits_are_refused_with_the_limit() {
    let message = refusal(&with("/grid/dt_s", json!(1e-5)));
    assert!(
        message.contains("grid.dt_s: 1e-5 s is over the stability limit of the scheme m13"),
        "{message}"
    );
    // What the message gives as the largest step is accepted, and is the largest to four digits.
    let step_s: f64 = message
        .rsplit("step is ")
        .next()
        .unwrap()
        .trim_end_matches(" s")
        .parse()
        .unwrap();
    read(&with("/grid/dt_s", json!(step_s))).unwrap();
    refusal(&with("/grid/dt_s", json!(step_s * 1.002)));
    let mut other = with("/grid/dt_s", json!(1.03e-5));
    other["scheme"] = json!("slf");
    read(&other).unwrap();
    let mut fine = with("/waveform/band_hz", json!([0.0, 23e3]));
    fine["sample_rate_hz"] = json!(50e3);
    let message = refusal(&fine);
    assert!(
        message.contains("waveform.band_hz[1]")
            && message.contains("22666 Hz")
            && message.contains("0.004927 m"),
        "{message}"
    );
    fine["waveform"]["band_hz"] = json!([0.0, 22_666.0]);
    read(&fine).unwrap();
    let message = refusal(&with("/waveform/band_hz", json!([0.0, 19_900.0])));
    assert!(message.contains("sampling rate"), "{message}");
}

#[test]
fn a_medium_may_be_given_by_its_weather() {
    let humid = |medium| read(&with("/medium", medium));
    let scene =
        humid(json!({ "temperature_degc": 20.0, "relative_humidity_percent": 50.0 })).unwrap();
    // Cramer 1993 and CIPM-2007; the papers' 340 m/s is air of 14 degC.
    assert!(
        (scene.medium.c_mps - 344.0).abs() < 0.1,
        "{:?}",
        scene.medium
    );
    assert!(
        (scene.medium.rho_kgpm3 - 1.199).abs() < 1e-3,
        "{:?}",
        scene.medium
    );
    assert_eq!(scene.air.unwrap().pressure_pa, 101_325.0);
    let high = humid(
        json!({ "temperature_degc": 20.0, "relative_humidity_percent": 50.0, "pressure_pa": 8e4 }),
    )
    .unwrap();
    assert!(high.medium.rho_kgpm3 < 0.8 * scene.medium.rho_kgpm3);
    assert_eq!(
        read(&with("/medium", json!({ "c_mps": 343.0 })))
            .unwrap()
            .air,
        None
    );
    for (medium, field) in [
        (
            json!({ "temperature_degc": 20.0 }),
            "medium: `relative_humidity_percent` is missing",
        ),
        (
            json!({ "relative_humidity_percent": 50.0, "pressure_pa": 1e5 }),
            "medium: `temperature_degc` is missing",
        ),
        (json!({ "pressure_pa": 1e5 }), "medium: `pressure_pa` needs"),
        (
            json!({ "c_mps": 343.0, "pressure_pa": 1e5 }),
            "medium: `pressure_pa` needs",
        ),
        (
            json!({ "temperature_degc": 20.0, "relative_humidity_percent": 50.0, "rho_kgpm3": 1.2 }),
            "medium: speed of sound or density stands beside",
        ),
        (
            json!({ "temperature_degc": 293.15, "relative_humidity_percent": 50.0 }),
            "medium.temperature_degc: 293.15",
        ),
        (
            json!({ "temperature_degc": 20.0, "relative_humidity_percent": 0.5e3 }),
            "medium.relative_humidity_percent: 500",
        ),
        (
            json!({ "temperature_degc": 20.0, "relative_humidity_percent": 50.0, "pressure_pa": 1013.25 }),
            "medium.pressure_pa: 1013.25",
        ),
    ] {
        let message = refusal(&with("/medium", medium));
        assert!(message.contains(field), "{message}");
        assert_eq!(message.lines().count(), 1);
    }
}

#[test]
fn numbers_out_of_range_are_refused() {
    for (pointer, value, expected) in [
        ("/medium/c_mps", json!(-340.0), "medium.c_mps"),
        ("/medium/rho_kgpm3", json!(0.0), "medium.rho_kgpm3"),
        ("/grid/nx", json!(30), "grid.nx"),
        ("/grid/nx", json!(9_007_199_254_740_993_u64), "grid.nx"),
        ("/grid/dx_m", json!(0.0), "grid.dx_m"),
        ("/grid/dt_s", json!(-1e-6), "grid.dt_s"),
        ("/layer_cells", json!(0), "layer_cells"),
        ("/waveform/code_length", json!(1000), "waveform.code_length"),
        (
            "/waveform/code_length",
            json!(4_294_967_295_u32),
            "waveform.code_length",
        ),
        (
            "/waveform/carrier_hz",
            json!(19_500.0),
            "waveform.carrier_hz",
        ),
        (
            "/waveform/band_hz",
            json!([5000.0, 4000.0]),
            "waveform.band_hz",
        ),
        ("/sample_rate_hz", json!(44_100.0), "sample_rate_hz"),
        ("/sample_rate_hz", json!(130e3), "sample_rate_hz"),
        (
            "/robot/microphone_offset_m",
            json!([1e9, 0.0]),
            "robot.microphone_offset_m[0]",
        ),
        (
            "/walls/0/thickness_m",
            json!(0.0099),
            "walls[0].thickness_m",
        ),
        (
            "/walls/0/points_m",
            json!([[0.7, 0.2]]),
            "walls[0].points_m",
        ),
        (
            "/walls/0/points_m",
            json!([[0.7, 0.2], [0.7, 0.2]]),
            "walls[0].points_m[1]",
        ),
        (
            "/paths/forward/legs/1/duration_s",
            json!(0.0),
            "paths.forward.legs[1].duration_s",
        ),
        (
            "/paths/forward/legs/1/v_mps",
            json!(1e4),
            "paths.forward.legs[1].v_mps",
        ),
        (
            "/paths/forward/acceleration_mps2",
            json!(0.0),
            "paths.forward.acceleration_mps2",
        ),
        ("/paths/forward/legs", json!([]), "paths.forward.legs"),
        ("/paths/forward/legs/0/v_mps", json!(200.0), "paths.forward"),
    ] {
        let message = refusal(&with(pointer, value));
        assert!(
            message.contains(&format!("test.json: {expected}: ")),
            "{message}"
        );
    }
    let huge = with(
        "/grid",
        json!({ "nx": 1_000_000, "ny": 1_000_000, "dx_m": 0.005, "dt_s": 8e-6 }),
    );
    assert!(refusal(&huge).contains("GiB"), "{}", refusal(&huge));
}

#[test]
fn walls_in_the_layer_are_refused() {
    for (points, expected) in [
        (json!([[0.05, 0.2], [0.3, 0.2]]), "walls[0].points_m[0][0]"),
        (json!([[0.3, 0.2], [0.3, 0.79]]), "walls[0].points_m[1][1]"),
        (json!([[0.3, 0.105], [0.6, 0.105]]), "with its thickness"),
    ] {
        let message = refusal(&with("/walls/0/points_m", points));
        assert!(message.contains(expected), "{message}");
    }
    // Flush with the layer is right.
    read(&with(
        "/walls/0/points_m",
        json!([[0.1, 0.11], [0.6, 0.11]]),
    ))
    .unwrap();
}

#[test]
fn paths_too_near_something_are_refused() {
    let drive = |x: f64, y: f64, heading: f64| {
        let legs = json!([{ "duration_s": 1.0, "v_mps": 0.3, "omega_radps": 0.0 }]);
        let start = json!({ "x_m": x, "y_m": y, "heading_rad": heading, "v_mps": 0.3 });
        with("/paths/forward", json!({ "start": start, "legs": legs }))
    };
    // Through the wall, beside its end, from its other side, into the layer, out of the domain.
    let message = refusal(&drive(0.5, 0.4, 0.0));
    assert!(
        message.contains("paths.forward: at 0.")
            && message.contains("the microphone") | message.contains("the loudspeaker"),
        "{message}"
    );
    assert!(
        message.contains("walls[0]") && message.contains("kaiser8"),
        "{message}"
    );
    assert!(refusal(&drive(0.3, 0.185, 0.0)).contains("walls[1]"));
    assert!(refusal(&drive(0.3, 0.7, 1.0)).contains("layer"));
    assert!(refusal(&drive(-5.0, 0.4, 0.0)).contains("outside the domain"));
    assert!(refusal(&drive(1e6, 0.4, 0.0)).contains("outside the domain"));
    // A kernel and scheme of less reach may go nearer.
    let mut nearer = drive(0.22, 0.185, 0.0);
    nearer["scheme"] = json!("slf");
    nearer["spread"] = json!("bilinear");
    read(&nearer).unwrap();
    // The loudspeaker's offset counts too.
    let mut reaching = small();
    reaching["robot"]["loudspeaker_offset_m"] = json!([0.4, 0.0]);
    assert!(refusal(&reaching).contains("the loudspeaker"));
}

#[test]
fn drives_come_from_files_beside_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("drive.csv"),
        "t_s,x_m,y_m,heading_rad\n0,0.3,0.4,0\n1,0.4,0.4,0\n2,0.5,0.4,0\n",
    )
    .unwrap();
    let file = folder.path().join("scene.json");
    let load = |path: Value| {
        std::fs::write(&file, with("/paths/forward", path).to_string()).unwrap();
        Scene::load(&file)
    };
    let scene = load(json!({ "file": "drive.csv" })).unwrap();
    assert!((scene.path("forward").unwrap().state_at(1.0).v_mps - 0.1).abs() < 1e-9);
    for (path, expected) in [
        (json!({ "file": "none.csv" }), "none.csv"),
        (
            json!({ "file": "drive.csv", "acceleration_mps2": 1.0 }),
            "paths.forward",
        ),
        (
            json!({ "start": { "x_m": 0.3, "y_m": 0.4, "heading_rad": 0.0 } }),
            "`legs` is missing",
        ),
        (json!({}), "`start` is missing"),
    ] {
        let message = load(path).unwrap_err().to_string();
        assert!(
            message.contains(expected) && !message.contains('\n'),
            "{message}"
        );
    }
    assert!(
        Scene::load(&folder.path().join("no.json"))
            .unwrap_err()
            .to_string()
            .contains("no.json")
    );
}

/// Every JSON pointer into a value.
fn pointers(value: &Value, prefix: &str, out: &mut Vec<String>) {
    out.push(prefix.to_string());
    match value {
        Value::Object(fields) => fields
            .iter()
            .for_each(|(key, field)| pointers(field, &format!("{prefix}/{key}"), out)),
        Value::Array(items) => items
            .iter()
            .enumerate()
            .for_each(|(i, item)| pointers(item, &format!("{prefix}/{i}"), out)),
        _ => {}
    }
}

fn any_value() -> impl Strategy<Value = Value> {
    prop_oneof![
        any::<f64>().prop_map(|x| json!(x)),
        (-2.0..2.0f64).prop_map(|x| json!(x)),
        (1e-7..1e-4f64).prop_map(|x| json!(x)),
        any::<i64>().prop_map(|n| json!(n)),
        (0..400u32).prop_map(|n| json!(n)),
        any::<String>().prop_map(Value::String),
        Just(Value::Null),
        Just(json!([])),
        Just(json!({})),
        Just(json!([[0.3, 0.3], [0.4, 0.5]])),
        any::<bool>().prop_map(Value::Bool),
    ]
}

fn only_one_line(result: Result<Scene, fdtd::Error>) {
    if let Err(error) = result {
        let message = error.to_string();
        assert!(
            message.starts_with("somewhere/") && !message.contains('\n') && message.len() < 900,
            "{message}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn changed_values_are_read_or_refused_in_one_line(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any_value()), 1..4),
    ) {
        let mut scene = small();
        for (place, value) in changes {
            let mut places = Vec::new();
            pointers(&scene, "", &mut places);
            let pointer: &String = place.get(&places);
            *scene.pointer_mut(pointer).unwrap() = value;
        }
        only_one_line(read(&scene));
    }

    #[test]
    fn changed_numbers_are_read_or_refused_in_one_line(
        changes in prop::collection::vec((any::<prop::sample::Index>(), -3.0..3.0f64), 1..4),
    ) {
        let mut scene = small();
        for (place, exponent) in changes {
            let mut places = Vec::new();
            pointers(&scene, "", &mut places);
            places.retain(|pointer| scene.pointer(pointer).is_some_and(Value::is_f64));
            let pointer: &String = place.get(&places);
            let number = scene.pointer_mut(pointer).unwrap();
            *number = json!(number.as_f64().unwrap() * 10_f64.powf(exponent));
        }
        only_one_line(read(&scene));
    }

    #[test]
    fn changed_bytes_are_read_or_refused_in_one_line(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<char>()), 1..5),
    ) {
        let mut text: Vec<char> = serde_json::to_string_pretty(&small()).unwrap().chars().collect();
        for (place, letter) in changes {
            let index = place.index(text.len());
            text[index] = letter;
        }
        let text: String = text.into_iter().collect();
        only_one_line(Scene::from_json(&text, Path::new("somewhere/test.json")));
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
    // One wall of two pieces with a right angle at its apex; the others are single and at right angles to nothing.
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

#[test]
fn impedance_and_absorption_are_read_or_refused() {
    let wall = |surface: &str| {
        let text = format!(
            r#"{{"name": "t", "grid": {{"nx": 200, "ny": 200, "dx_m": 0.005, "dt_s": 8.333e-6}},
            "walls": [{{"points_m": [[0.3, 0.3], [0.6, 0.3]]{surface}}}]}}"#
        );
        Scene::from_json(&text, Path::new("t.json")).map(|scene| scene.walls[0].impedance_pasm)
    };
    assert_eq!(wall("").unwrap(), None);
    assert_eq!(wall(", \"absorption\": 0").unwrap(), None);
    assert_eq!(wall(", \"impedance_pasm\": 900").unwrap(), Some(900.0));
    // Half of the energy: a reflection factor of 0.7071.
    let half = wall(", \"absorption\": 0.5").unwrap().unwrap();
    assert!((half / (1.293 * 340.0) - 5.8284).abs() < 1e-3, "{half}");
    for (surface, field) in [
        (", \"impedance_pasm\": 0", "walls[0].impedance_pasm"),
        (", \"impedance_pasm\": -1", "walls[0].impedance_pasm"),
        (", \"absorption\": 1.1", "walls[0].absorption"),
        (
            ", \"absorption\": 0.1, \"impedance_pasm\": 900",
            "walls[0].absorption",
        ),
    ] {
        let error = wall(surface).unwrap_err().to_string();
        assert!(error.contains(field), "{error}");
    }
}
