//! Exit codes, messages and printed results of the commands.

use crate::room::{ROOM, SIMULATE, echolot, expect, project_file, refuse, scene_file};

#[test]
fn every_command_has_help_with_an_example() {
    let folder = tempfile::tempdir().unwrap();
    for command in [
        "scene",
        "simulate",
        "map",
        "localize",
        "run",
        "figures",
        "check",
        "list",
        "bench",
        "validate",
        "robustness",
        "reference",
    ] {
        let help = expect(folder.path(), &[command, "--help"]);
        assert!(help.contains("Example:\n  echolot"), "{command}: {help}");
    }
    for command in ["check", "draw", "schema"] {
        let help = expect(folder.path(), &["scene", command, "--help"]);
        assert!(
            help.contains("Example:\n  echolot"),
            "scene {command}: {help}"
        );
    }
}

#[test]
fn single_laws_are_measured_without_writing_files() {
    let folder = tempfile::tempdir().unwrap();
    let table = expect(folder.path(), &["validate", "parallel walls"]);
    assert!(
        table.contains("two parallel walls: time scale 1") && !table.contains("dispersion"),
        "{table}"
    );
    assert!(std::fs::read_dir(folder.path()).unwrap().next().is_none());
    let complaint = refuse(folder.path(), &["validate", "gravity"]);
    assert!(
        complaint.contains("LAW gravity") && complaint.contains("absorbing layer"),
        "{complaint}"
    );
}

#[test]
fn bad_input_is_one_line_that_names_file_and_field() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    let complaint = refuse(at, &["scene", "check", "none.json"]);
    assert!(
        complaint.contains("none.json") && complaint.matches("No such file").count() == 1,
        "{complaint}"
    );
    std::fs::write(
        at.join("bad.json"),
        ROOM.replace("\"nx\": 500", "\"nx\": -5"),
    )
    .unwrap();
    let complaint = refuse(at, &["scene", "check", "bad.json"]);
    assert!(
        complaint.contains("bad.json") && complaint.contains("nx"),
        "{complaint}"
    );
    let complaint = refuse(
        at,
        &[
            "simulate",
            "room.json",
            "--path",
            "drive",
            "-o",
            "recording",
        ],
    );
    assert!(
        complaint.contains("drive") && complaint.contains("localization"),
        "{complaint}"
    );
    for (more, words) in [
        (
            vec!["--absorption"],
            ["room.json", "--temperature and --humidity"],
        ),
        (
            vec!["--absorption", "--temperature", "90", "--humidity", "50"],
            ["temperature_degc: 90", "30"],
        ),
    ] {
        let complaint = refuse(at, &[&SIMULATE[..], &["recording"], &more].concat());
        assert!(
            words.iter().all(|word| complaint.contains(word)),
            "{complaint}"
        );
    }
    let complaint = refuse(at, &["map", "nothing", "-o", "map"]);
    assert!(complaint.contains("nothing"), "{complaint}");
    let complaint = refuse(at, &["localize", "nothing", "--map", "map", "-o", "e.tum"]);
    assert!(complaint.contains("nothing"), "{complaint}");
    let quick = project_file("studies/quick/quick.json");
    let complaint = refuse(at, &["run", &quick, "--only", "window-sizes"]);
    assert!(
        complaint.contains("window-sizes") && complaint.contains("window-size,"),
        "{complaint}"
    );
    let complaint = refuse(at, &["figures", "results/quick"]);
    assert!(complaint.contains("echolot run"), "{complaint}");
    let complaint = refuse(at, &["check", &quick]);
    assert!(
        complaint.contains("summary.json") && complaint.contains("echolot run"),
        "{complaint}"
    );
    std::fs::write(at.join("parameters.json"), r#"{"particle": 3}"#).unwrap();
    let complaint = refuse(
        at,
        &[
            "map",
            "nothing",
            "-o",
            "map",
            "--parameters",
            "parameters.json",
        ],
    );
    assert!(
        complaint.contains("parameters.json") && complaint.contains("particle"),
        "{complaint}"
    );
}

#[test]
fn a_folder_with_other_things_is_never_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    std::fs::create_dir(at.join("precious")).unwrap();
    std::fs::write(at.join("precious/thesis.tex"), "x").unwrap();
    for output in ["precious", "."] {
        refuse(at, &[&SIMULATE[..], &[output]].concat());
    }
    assert!(at.join("precious/thesis.tex").exists());
    expect(at, &[&SIMULATE[..], &["recording"]].concat());
    expect(at, &[&SIMULATE[..], &["recording"]].concat());
    assert!(at.join("recording/signal.wav").exists());
}

#[test]
fn results_are_json_when_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    let parse = |arguments: &[&str]| -> serde_json::Value {
        serde_json::from_str(&expect(at, arguments)).unwrap()
    };
    let scene = parse(&["scene", "check", "room.json", "--json"]);
    assert_eq!(scene["cells"], 250_000);
    assert_eq!(scene["paths"]["mapping"]["duration_s"], 15.0);
    let studies = parse(&["list", "--json"]);
    assert!(studies.as_array().unwrap().len() >= 9);
    assert!(parse(&["scene", "schema"])["properties"].is_object());
}

#[test]
fn a_scene_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    scene_file(folder.path());
    expect(
        folder.path(),
        &["scene", "draw", "room.json", "-o", "room.png"],
    );
    let bytes = std::fs::read(folder.path().join("room.png")).unwrap();
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let complaint = refuse(
        folder.path(),
        &["scene", "draw", "room.json", "-o", "room.json/room.png"],
    );
    assert!(complaint.contains("room.json"), "{complaint}");
}

#[test]
fn a_reader_that_has_had_enough_is_no_failure() {
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_echolot"))
        .args(["scene", "schema"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success() && complaint.is_empty(),
        "{complaint}"
    );
}

#[test]
fn the_order_of_images_is_for_image_sources() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    let quick = project_file("studies/quick/quick.json");
    let run = ["run", &quick, "--image-order", "4"];
    assert!(refuse(at, &run).contains("--image-order 4"));
    let simulate = |order: &'static str, engine: &[&'static str]| {
        let drive = [
            "simulate",
            "room.json",
            "--path",
            "localization",
            "-o",
            order,
        ];
        [&drive[..], &["--image-order", order], engine].concat()
    };
    assert!(refuse(at, &simulate("3", &[])).contains("--image-order 3"));
    let images = ["--engine", "image-source"];
    assert_eq!(echolot(at, &simulate("9", &images)).status.code(), Some(2));
    for order in ["1", "3"] {
        expect(at, &simulate(order, &images));
    }
    let signal = |order: &str| std::fs::read(at.join(order).join("signal.wav")).unwrap();
    assert_ne!(signal("1"), signal("3"));
}

#[test]
fn image_sources_refuse_walls_that_are_not_rigid() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for surface in [
        r#""absorption": 0.4"#,
        r#""branches": [{"resistance_pasm": 90, "compliance_mppa": 4e-8}]"#,
    ] {
        let text = ROOM.replacen("\"thickness_m\": 0.02", surface, 1);
        std::fs::write(at.join("room.json"), text).unwrap();
        let complaint = refuse(at, &[&SIMULATE[..], &["out"]].concat());
        assert!(
            complaint.contains("walls[0] has an impedance") && complaint.contains("--engine fdtd"),
            "{complaint}"
        );
    }
}

#[test]
fn absorption_weakens_the_echoes_and_is_in_the_provenance() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    let simulate = |output: &str, more: &[&str]| {
        expect(at, &[&SIMULATE[..], &[output], more].concat());
        let recording = localizer::recording::Recording::read(&at.join(output)).unwrap();
        let energy: f64 = recording.signal.iter().map(|p| f64::from(*p).powi(2)).sum();
        (energy, recording.meta.provenance["absorption"].clone())
    };
    let (without, untold) = simulate("plain", &[]);
    let more = ["--absorption", "--temperature", "20", "--humidity", "50"];
    let (with, absorbed) = simulate("absorbed", &more);
    assert!(untold.is_null());
    assert_eq!(absorbed["temperature_degc"], 20.0);
    // Two metres and more at 10 kHz take 0.3 dB and more, a room of 2.5 m not more than 3 dB.
    let loss_db = 10.0 * (without / with).log10();
    assert!((0.2..3.0).contains(&loss_db), "{loss_db}");
}

#[test]
fn both_engines_record_echoes_of_the_same_level() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    let echoes_pa = |engine: &str, more: &[&str]| {
        let usual = [
            "simulate",
            "room.json",
            "--path",
            "short",
            "--engine",
            engine,
            "-o",
            engine,
        ];
        expect(at, &[&usual[..], more].concat());
        let recording = localizer::Recording::read(&at.join(engine)).unwrap();
        let direct = recording
            .direct
            .unwrap_or(vec![0.0; recording.signal.len()]);
        let echoes = recording
            .signal
            .iter()
            .zip(&direct)
            .map(|(all, direct)| all - direct);
        // After the first echoes have arrived.
        let late: Vec<f64> = echoes.skip(direct.len() / 2).map(f64::from).collect();
        (late.iter().map(|x| x * x).sum::<f64>() / late.len() as f64).sqrt()
    };
    let field = echoes_pa("fdtd", &["--with-direct"]);
    // Image sources leave out what bends around the ends of these short walls, half of the energy.
    let images = echoes_pa("image-source", &["--image-order", "4"]);
    let ratio = images / field;
    assert!(
        (0.5..1.5).contains(&ratio),
        "{images} Pa by image sources, {field} Pa by the field"
    );
}
