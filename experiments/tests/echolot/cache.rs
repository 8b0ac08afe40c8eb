//! The key of a recording changes with all that determines it, and with nothing else.

use std::path::Path;

use experiments::recordings::fingerprint::engine_fingerprint;
use experiments::recordings::key::recording_key;
use experiments::recordings::{Engine, RecordingSpec};
use fdtd::scene::Scene;
use fdtd::scheme::Scheme;

use crate::room::{ROOM, scene};

fn key(text: &str, spec: &RecordingSpec) -> String {
    let scene = Scene::from_json(text, Path::new("room.json")).unwrap();
    recording_key(&scene, spec, "print").unwrap()
}

#[test]
fn values_without_influence_on_the_sound_do_not_enter() {
    let spec = RecordingSpec::of("localization", Engine::Fdtd);
    let original = key(ROOM, &spec);
    assert_eq!(original, key(ROOM, &spec));
    assert_eq!(
        original,
        key(&ROOM.replace("\"room\"", "\"chamber\""), &spec)
    );
    // The scene's own scheme given explicitly is the same scheme.
    let explicit = RecordingSpec {
        scheme: Some(Scheme::M13),
        ..spec.clone()
    };
    assert_eq!(original, key(ROOM, &explicit));
    // One leg cut in two is the same drive; another path does not matter.
    let legs = "{\"duration_s\": 5, \"v_mps\": 0.22, \"omega_radps\": 0.4}";
    let halves = "{\"duration_s\": 2.5, \"v_mps\": 0.22, \"omega_radps\": 0.4}";
    assert!(ROOM.contains(legs));
    let other = ROOM.replace("\"duration_s\": 8", "\"duration_s\": 7");
    assert_eq!(original, key(&other, &spec));
    assert_ne!(original, key(&ROOM.replace(legs, halves), &spec));
}

#[test]
fn values_that_determine_the_sound_enter() {
    let spec = RecordingSpec::of("localization", Engine::Fdtd);
    let original = key(ROOM, &spec);
    for (before, after) in [
        ("[2.15, 0.6]", "[2.15, 0.61]"),
        ("\"nx\": 500", "\"nx\": 501"),
        ("\"heading_rad\": 0.2,", "\"heading_rad\": 0.21,"),
        (
            "\"name\": \"room\",",
            "\"name\": \"room\", \"layer_cells\": 21,",
        ),
        (
            "\"name\": \"room\",",
            "\"name\": \"room\", \"medium\": {\"c_mps\": 341},",
        ),
    ] {
        assert!(ROOM.contains(before), "{before}");
        assert_ne!(
            original,
            key(&ROOM.replace(before, after), &spec),
            "{after}"
        );
    }
    let others = [
        RecordingSpec::of("mapping", Engine::Fdtd),
        RecordingSpec::of("localization", Engine::ImageSource),
        spec.in_free_field(),
        RecordingSpec {
            scheme: Some(Scheme::Slf),
            ..spec.clone()
        },
        spec.stamped(),
        RecordingSpec {
            wall_model: Some(fdtd::walls::WallModel::Staircase),
            ..spec.clone()
        },
        RecordingSpec {
            odometry_bias_radps: 0.0,
            ..spec.clone()
        },
    ];
    for other in &others {
        assert_ne!(original, key(ROOM, other), "{other:?}");
    }
    assert_ne!(
        original,
        recording_key(&scene(), &spec, "other print").unwrap()
    );
}

#[test]
fn the_fingerprint_of_an_engine_repeats_and_differs_between_schemes() {
    let scene = scene();
    let print = |spec: &RecordingSpec| engine_fingerprint(spec, &scene).unwrap();
    let m13 = RecordingSpec::of("localization", Engine::Fdtd);
    let slf = RecordingSpec {
        scheme: Some(Scheme::Slf),
        ..m13.clone()
    };
    assert_eq!(print(&m13), print(&m13));
    assert_ne!(print(&m13), print(&slf));
    assert_ne!(
        print(&m13),
        print(&RecordingSpec::of("localization", Engine::ImageSource))
    );
}
