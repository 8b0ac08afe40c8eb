//! Fields arrive where they belong, have the documented defaults, and are in the schema.

use crate::{read, refusal, scenes, small, with};
use fdtd::scene::Scene;
use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::walls::{Branch, Impedance};
use serde_json::{Value, json};
use std::path::Path;

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

#[test]
fn impedance_and_absorption_are_read_or_refused() {
    let wall = |surface: &str| {
        let text = format!(
            r#"{{"name": "t", "grid": {{"nx": 200, "ny": 200, "dx_m": 0.005, "dt_s": 8.333e-6}},
            "walls": [{{"points_m": [[0.3, 0.3], [0.6, 0.3]]{surface}}}]}}"#
        );
        Scene::from_json(&text, Path::new("t.json")).map(|scene| scene.walls[0].impedance.clone())
    };
    assert_eq!(wall("").unwrap(), None);
    assert_eq!(wall(", \"absorption\": 0").unwrap(), None);
    assert_eq!(
        wall(", \"impedance_pasm\": 900").unwrap(),
        Some(Impedance::Real(900.0))
    );
    // Half of the energy: a reflection factor of 0.7071.
    let Some(Impedance::Real(half)) = wall(", \"absorption\": 0.5").unwrap() else {
        panic!("an impedance");
    };
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

#[test]
fn branches_are_read_or_refused() {
    let wall = |branches: Value| {
        let mut scene = small();
        scene["walls"][0]["branches"] = branches;
        scene
    };
    let scene = read(&wall(json!([
        { "resistance_pasm": 90.0, "inertance_kgpm2": 0.02, "compliance_mppa": 4e-8 },
        { "resistance_pasm": 900.0 },
    ])));
    let panel = Branch {
        resistance_pasm: 90.0,
        inertance_kgpm2: 0.02,
        stiffness_papm: 1.0 / 4e-8,
    };
    let expected = Impedance::Branches(vec![panel, Branch::resistance(900.0)]);
    assert_eq!(scene.unwrap().walls[0].impedance, Some(expected));
    for (branches, expected) in [
        (json!([]), "walls[0].branches: holds no branch; give one"),
        (
            json!([{ "resistance_pasm": 90.0 }, {}]),
            "walls[0].branches[1]: resists nothing; give one or more of resistance_pasm,",
        ),
        (
            json!([{ "resistance_pasm": -1.0 }]),
            "walls[0].branches[0].resistance_pasm: -1.0 Pa s/m is out of range; give a number from 0",
        ),
        (
            json!([{ "inertance_kgpm2": -0.1, "resistance_pasm": 1.0 }]),
            "walls[0].branches[0].inertance_kgpm2: -0.1 kg/m^2",
        ),
        (
            json!([{ "inertance_kgpm2": 1e300 }]),
            "walls[0].branches[0].inertance_kgpm2: 1e300",
        ),
        (
            json!([{ "compliance_mppa": 0.0 }]),
            "walls[0].branches[0].compliance_mppa: 0.0 m/Pa is out of range; give a number from 1e-18",
        ),
        (
            json!([{ "resistence_pasm": 1.0 }]),
            "walls[0].branches[0].resistence_pasm (line ",
        ),
        (
            json!({ "resistance_pasm": 1.0 }),
            "walls[0].branches (line ",
        ),
    ] {
        let message = refusal(&wall(branches));
        assert!(
            message.contains(&format!("test.json: {expected}")),
            "{message}"
        );
    }
    for other in ["impedance_pasm", "absorption"] {
        let mut scene = wall(json!([{ "resistance_pasm": 90.0 }]));
        scene["walls"][0][other] = json!(0.5);
        let message = refusal(&scene);
        let expected = format!("walls[0].branches: is given beside {other}; give one of them");
        assert!(message.contains(&expected), "{message}");
    }
}
