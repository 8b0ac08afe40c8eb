//! Whatever is changed in a scene file: it is read, or refused in one line.

use crate::{read, small};
use fdtd::scene::Scene;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::path::Path;

/// A scene with walls of all kinds.
fn scene() -> Value {
    let mut scene = small();
    scene["walls"][0]["branches"] = json!([
        { "resistance_pasm": 90.0, "inertance_kgpm2": 0.02, "compliance_mppa": 4e-8 },
        { "resistance_pasm": 900.0 },
    ]);
    scene["walls"][1]["absorption"] = json!(0.3);
    scene
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
        let mut scene = scene();
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
        let mut scene = scene();
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
        let mut text: Vec<char> = serde_json::to_string_pretty(&scene()).unwrap().chars().collect();
        for (place, letter) in changes {
            let index = place.index(text.len());
            text[index] = letter;
        }
        let text: String = text.into_iter().collect();
        only_one_line(Scene::from_json(&text, Path::new("somewhere/test.json")));
    }
}
