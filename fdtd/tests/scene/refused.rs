//! Scenes that cannot be simulated are refused, with file, field and remedy.

use crate::{read, refusal, small, with};
use fdtd::scene::Scene;
use serde_json::json;
use std::path::Path;

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
fn the_5_point_scheme_at_its_limit_leaves_nothing_to_walls_of_an_impedance() {
    let mut scene = with("/grid/dt_s", json!(1.03e-5));
    scene["scheme"] = json!("slf");
    read(&scene).unwrap();
    scene["walls"][0]["impedance_pasm"] = json!(900.0);
    let message = refusal(&scene);
    assert!(
        message.contains("grid.dt_s: 1.03e-5 s is too near") && message.contains("walls[0]"),
        "{message}"
    );
    scene["grid"]["dt_s"] = json!(9.7e-6);
    read(&scene).unwrap();
}

#[test]
fn steps_and_bands_beyond_the_limits_are_refused_with_the_limit() {
    let message = refusal(&with("/grid/dt_s", json!(1.1e-5)));
    assert!(
        message.contains("grid.dt_s: 1.1e-5 s is over the stability limit of the scheme m13"),
        "{message}"
    );
    // The largest step that the message gives is accepted, and is the largest to four digits.
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
        (json!([[0.3, 0.115], [0.6, 0.115]]), "with its thickness"),
        // The layer's slopes would meet faces that the wall closes, and a mode would grow.
        (json!([[0.1, 0.2], [0.3, 0.2]]), "walls[0].points_m[0][0]"),
    ] {
        let message = refusal(&with("/walls/0/points_m", points));
        assert!(message.contains(expected), "{message}");
    }
    // As far from the layer as the stencil reaches is right.
    read(&with(
        "/walls/0/points_m",
        json!([[0.11, 0.12], [0.6, 0.12]]),
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
