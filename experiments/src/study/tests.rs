//! Study files: what is refused and in which words, and what becomes of those that are not.

use std::path::Path;

use serde_json::{Value, json};

use super::*;
use crate::papers::{PaperSession, Papers};

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes");

/// A study on a scene of the project with some fields replaced.
fn study(changes: &[(&str, Value)]) -> Value {
    let mut study = json!({
        "name": "small",
        "about": "a test",
        "scenes": ["scenes/quick.json"],
        "methods": ["doppler", "odometry"],
    });
    for (field, value) in changes {
        study[*field] = value.clone();
    }
    study
}

fn parse(study: &Value) -> Result<Study> {
    Study::parse(&study.to_string(), Path::new("small.json"))
}

fn refused(changes: &[(&str, Value)], words: &[&str]) {
    let message = match parse(&study(changes)) {
        Ok(study) => panic!("{changes:?} is taken: {:?}", study.file),
        Err(error) => format!("{error:#}"),
    };
    for word in ["small.json"].iter().chain(words) {
        assert!(message.contains(word), "{changes:?}: {message}");
    }
    assert_eq!(message.lines().count(), 1, "{message}");
}

#[test]
fn what_cannot_be_used_is_refused_by_name() {
    refused(&[("name", json!("../evil"))], &["name", "folder"]);
    refused(&[("name", json!(""))], &["name"]);
    refused(&[("name", json!("a".repeat(4000)))], &["name"]);
    refused(
        &[("set", json!({"scene.a\nb": 1}))],
        &["names of values", "a\\nb"],
    );
    refused(
        &[("vary", json!([{"scene.name": ["two\nlines"]}]))],
        &["vary"],
    );
    refused(&[("colour", json!(1))], &["colour"]);
    refused(&[("scenes", json!([]))], &["scenes"]);
    refused(&[("scenes", json!([7]))], &["scenes"]);
    refused(
        &[("scenes", json!([{"random": "maze", "seeds": [1, 2]}]))],
        &["scenes", "maze"],
    );
    refused(
        &[("scenes", json!([{"random": "open", "seeds": [5, 2]}]))],
        &["scenes[0].seeds", "5 to 2"],
    );
    refused(
        &[("scenes", json!(["a/room.json", "b/room.json"]))],
        &["scenes[1]", "twice"],
    );
    let drawn = |figure: Value| [("figures", json!([figure]))];
    refused(
        &drawn(json!({"kind": "table", "measures": []})),
        &["figures[0]", "measures"],
    );
    refused(
        &drawn(json!({"kind": "table", "measures": ["speed"]})),
        &["speed"],
    );
    refused(
        &drawn(json!({"kind": "map", "where": {"localizer.periods": 9}})),
        &["figures[0]", "where"],
    );
    refused(
        &[
            ("methods", json!(["odometry", "multipath"])),
            ("figures", json!([{"kind": "map"}])),
        ],
        &["figures[0]", "map"],
    );
    refused(&[("methods", json!([]))], &["methods"]);
    refused(&[("methods", json!(["magic"]))], &["methods", "magic"]);
    refused(
        &[("methods", json!(["slam", "slam"]))],
        &["methods[1]", "twice"],
    );
    refused(
        &[("set", json!({"speed": 1}))],
        &["set.speed", "localizer."],
    );
    refused(
        &[("set", json!({"field.colour": 1}))],
        &["set.field.colour"],
    );
    refused(
        &[("set", json!({"robot.drift_radpm": 1}))],
        &["set.robot.drift_radpm", "no robot file"],
    );
    refused(
        &[
            ("set", json!({"localizer.periods": 2})),
            ("vary", json!([{"localizer.periods": [1, 2]}])),
        ],
        &["vary[0].localizer.periods", "elsewhere"],
    );
    refused(
        &[(
            "vary",
            json!([{"localizer.periods": [1, 2], "localizer.particles": [10]}]),
        )],
        &["vary[0]", "2 values beside 1"],
    );
    refused(
        &[("vary", json!([{"localizer.periods": []}]))],
        &["vary[0]", "no values"],
    );
    refused(&[("vary", json!([{}]))], &["vary[0]", "empty"]);
    for step in [0.0, -1.0, 1e-9] {
        refused(
            &[(
                "vary",
                json!([{"noise.snr_db": {"from": 0, "to": 10, "step": step}}]),
            )],
            &["vary[0].noise.snr_db", "range"],
        );
    }
    let long: Vec<u64> = (0..400).collect();
    refused(
        &[(
            "vary",
            json!([{"localizer.particles": long}, {"localizer.bins": long}]),
        )],
        &["vary", "cells"],
    );
    refused(&[("seeds", json!({"filter": 0}))], &[]);
    refused(&[("seeds", json!({"slip": 3}))], &["seeds.slip", "robot"]);
    refused(
        &[("seeds", json!({"noise": 3}))],
        &["seeds.noise", "snr_db"],
    );
    refused(
        &[(
            "figures",
            json!([{"kind": "curve", "over": "localizer.periods"}]),
        )],
        &["figures[0]", "does not vary"],
    );
    refused(
        &[("figures", json!([{"kind": "pie"}]))],
        &["figures", "pie"],
    );
}

#[test]
fn claims_that_could_not_be_tested_are_refused() {
    let claim = |test: Value| ("claims", json!([{"id": "a", "claim": "b", "test": test}]));
    refused(
        &[claim(json!({"test": "bound", "of": {"method": "doppler"}}))],
        &["claims[0]", "at_most"],
    );
    refused(
        &[claim(
            json!({"test": "bound", "of": {"method": "slam"}, "at_most": 1}),
        )],
        &["claims[0]", "slam"],
    );
    refused(
        &[claim(json!({"test": "bound", "of": {}, "at_most": 1}))],
        &["claims[0]", "several"],
    );
    refused(
        &[claim(
            json!({"test": "order", "of": [{"method": "doppler"}]}),
        )],
        &["claims[0]", "two"],
    );
    let elsewhere = json!({"method": "doppler", "where": {"localizer.periods": 2}});
    refused(
        &[claim(
            json!({"test": "bound", "of": elsewhere, "at_most": 1}),
        )],
        &["claims[0]", "no cell"],
    );
    refused(
        &[("claims", json!([{"id": "a", "claim": "b"}]))],
        &["claims[0]", "why"],
    );
}

#[test]
fn cells_are_the_product_of_what_varies() {
    let study = parse(&study(&[
        ("scenes", json!(["scenes/quick.json", {"random": "room", "seeds": [3, 6]}])),
        (
            "alternatives",
            json!([{"name": "plain", "set": {}}, {"name": "few", "set": {"localizer.particles": 10}}]),
        ),
        (
            "vary",
            json!([
                {"localizer.periods": [2, 6], "localizer.window_half_width_m": [1.5, 2]},
                {"noise.snr_db": {"from": -1, "to": 0, "step": 0.1}},
            ]),
        ),
    ]))
    .unwrap();
    assert_eq!(study.cells.len(), 2 * 2 * 2 * 11);
    let last = study.cells.last().unwrap();
    assert_eq!(
        last.name(),
        "scene = random room, alternative = few, periods = 6, window_half_width_m = 2, snr_db = 0"
    );
    assert_eq!(last.sources.len(), 4);
    assert_eq!(last.settings["localizer.particles"], json!(10));
    assert_eq!(study.cells[1].settings["noise.snr_db"], json!(-0.9));
}

/// Plans are made of values that trials can be run with, or refused by the cell's name.
#[test]
fn plans_refuse_values_that_no_trial_can_have() {
    let folder = tempfile::tempdir().unwrap();
    let workspace = crate::session::Workspace::new(folder.path(), Some(1));
    let fast = ("field.engine", json!("image-source"));
    let plan = |changes: &[(&str, Value)]| {
        let study = parse(&study(changes)).unwrap();
        Plan::new(&study, &[], &workspace).map(|plan| plan.trials())
    };
    let set = |name: &str, value: Value| {
        let mut set = json!({name: value});
        if name != fast.0 {
            set[fast.0] = fast.1.clone();
        }
        plan(&[("set", set)])
    };
    assert_eq!(set("field.image_order", json!(3)).unwrap(), 2);
    for (name, value, word) in [
        ("localizer.periods", json!(0), "periods"),
        ("localizer.periods", json!("six"), "periods"),
        ("localizer.colour", json!(1), "localizer.colour"),
        ("localizer.method", json!("doppler"), "methods"),
        ("scene.medium.c_mps", json!(-3), "c_mps"),
        ("scene.colour", json!(3), "colour"),
        ("scene.walls.77.thickness_m", json!(0.1), "scene.walls.77"),
        (
            "drive.mapping",
            json!("upstairs"),
            "no path \"upstairs\"; it has localization, mapping",
        ),
        ("drive.localization", json!(2), "drive.localization"),
        ("field.image_order", json!(40), "field.image_order"),
        ("noise.snr_db", json!("loud"), "noise.snr_db"),
        ("noise.snr_db", json!(1e9), "noise.snr_db"),
        (
            "robot.odometry_bias_radps",
            json!(1e9),
            "odometry_bias_radps",
        ),
        ("field.engine", json!("magic"), "magic"),
    ] {
        let message = format!("{:#}", set(name, value.clone()).unwrap_err());
        assert!(
            message.contains(word) && message.contains("cell all"),
            "{name} {value}: {message}"
        );
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    let order = json!({"field.image_order": 3});
    let message = format!("{:#}", plan(&[("set", order)]).unwrap_err());
    assert!(message.contains("field.engine"), "{message}");
    let missing = format!(
        "{:#}",
        plan(&[("scenes", json!(["no/such.json"]))]).unwrap_err()
    );
    assert!(missing.contains("no/such.json"), "{missing}");
    let many = plan(&[
        ("seeds", json!({"filter": 1_000_000})),
        ("vary", {
            let list: Vec<u64> = (10..40).collect();
            json!([{"localizer.particles": list}])
        }),
    ]);
    assert!(format!("{:#}", many.unwrap_err()).contains("seeds"));
}

/// Drives are paths of the scene: another way round needs another recording, the same way none.
#[test]
fn the_drives_of_a_study_are_paths_of_its_scene() {
    let folder = tempfile::tempdir().unwrap();
    let workspace = crate::session::Workspace::new(folder.path(), Some(1));
    let drives = json!(["localization", "example_drive", "example_mapping"]);
    let study = parse(&study(&[
        ("scenes", json!(["scenes/site.json"])),
        ("set", json!({"drive.mapping": "example_mapping"})),
        ("vary", json!([{"drive.localization": drives}])),
        ("methods", json!(["odometry"])),
    ]))
    .unwrap();
    let plan = Plan::new(&study, &[], &workspace).unwrap();
    assert_eq!((plan.trials(), plan.jobs.len()), (3, 3));
    let courses: Vec<f64> = (plan.setups.iter())
        .map(|setup| setup.scene.path("localization").unwrap().duration_s())
        .collect();
    let scene = fdtd::scene::Scene::load(&Path::new(SCENES).join("site.json")).unwrap();
    let of = |name: &str| scene.path(name).unwrap().duration_s();
    assert_eq!(
        courses,
        ["localization", "example_drive", "example_mapping"].map(of)
    );
    let cell = study.cells[1].name();
    assert!(cell.contains("localization = example_drive"), "{cell}");
}

#[test]
fn what_a_method_does_not_depend_on_is_drawn_once() {
    let folder = tempfile::tempdir().unwrap();
    let workspace = crate::session::Workspace::new(folder.path(), Some(1));
    let study = parse(&study(&[
        ("scenes", json!([{"random": "open", "seeds": [7, 8]}])),
        ("robot", json!("experiments/robots/site.json")),
        (
            "set",
            json!({"field.engine": "image-source", "noise.snr_db": 3}),
        ),
        ("methods", json!(["doppler", "odometry", "slam"])),
        ("seeds", json!({"slip": 2, "noise": 3, "filter": 5})),
    ]))
    .unwrap();
    let plan = Plan::new(&study, &[], &workspace).unwrap();
    // Layouts x slips x noises x filters.
    let (doppler, odometry, slam) = (2 * 2 * 3 * 5, 2 * 2, 2 * 2 * 3);
    assert_eq!(plan.trials(), doppler + odometry + slam);
    let text = plan.text(&study, &workspace).unwrap();
    assert!(
        text.contains("76 trials (76 to run) on 6 recordings (6 to simulate)"),
        "{text}"
    );
    let one = Plan::new(&study, &["scene=quick".to_string()], &workspace);
    assert!(format!("{:#}", one.err().unwrap()).contains("--only"));
}

/// The studies of the project can be run, and the schema beside them is the program's. `BLESS=1` writes it.
#[test]
fn the_projects_studies_are_whole() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studies");
    let schema = serde_json::to_string_pretty(&crate::papers::json_schema()).unwrap() + "\n";
    let file = folder.join("study.schema.json");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&file, &schema).unwrap();
    }
    let known = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(
        known == schema,
        "studies/study.schema.json is not current; BLESS=1 cargo test writes it"
    );
    let temporary = tempfile::tempdir().unwrap();
    let workspace = crate::session::Workspace::new(temporary.path(), Some(1));
    let folders = ["", "papers", "quick"].map(|name| folder.join(name));
    let all = folders
        .iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap());
    let paths = all.map(|entry| entry.unwrap().path());
    let mut count = [0; 2];
    for path in paths.filter(|path| path.extension().is_some_and(|ending| ending == "json")) {
        if path == file {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let of_papers = is_of_papers(&text);
        count[usize::from(of_papers)] += 1;
        if of_papers {
            let mut papers = Papers::load(&path).unwrap();
            papers.set_engine(Engine::ImageSource, 2).unwrap();
            let session = PaperSession::open(papers, temporary.path(), &workspace).unwrap();
            let studies = session.papers.chosen(&[]).unwrap();
            assert!(
                !crate::papers::missing(&session, &studies)
                    .unwrap()
                    .is_empty()
            );
            continue;
        }
        let mut study = Study::load(&path).unwrap();
        if !study.file.set.contains_key("field.engine") {
            study.set_engine(Engine::ImageSource, 2).unwrap();
        }
        let plan = Plan::new(&study, &[], &workspace).unwrap();
        assert!(plan.trials() > 0, "{}", path.display());
    }
    assert!(count[0] > 3 && count[1] >= 2, "{count:?}");
}
