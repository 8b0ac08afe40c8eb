//! What trials with known numbers say to each kind of test.

use std::sync::Arc;

use serde_json::{Value, json};

use super::*;

/// Periods of the cells and the mean error of each, in metres: the best at 4, as good within its interval at 3.
const MEANS: [(u32, f64); 5] = [(1, 0.08), (2, 0.06), (3, 0.031), (4, 0.030), (6, 0.05)];

/// Cells over periods, doppler and toa-only in each: three filters a millimetre apart around the mean, toa-only twice
/// as far off.
fn trials(change: impl Fn(&mut Row)) -> (Vec<Cell>, Vec<MethodName>, Vec<Row>) {
    let cells: Vec<Cell> = (MEANS.iter())
        .map(|(periods, _)| Cell {
            labels: vec![("localizer.periods".to_string(), periods.to_string())],
            settings: Settings::default(),
            sources: Arc::from([]),
        })
        .collect();
    let mut rows = Vec::new();
    for (cell, (_, mean_m)) in MEANS.iter().enumerate() {
        for (method, times) in [1.0, 2.0].into_iter().enumerate() {
            for filter in 0..3 {
                let own_m = times * (mean_m + 1e-3 * (f64::from(filter) - 1.0));
                let mut values = [None; Measure::ALL.len()];
                values[0] = Some(own_m);
                let mut row = Row {
                    cell,
                    method,
                    draw: [0, 0, 0, filter as u64],
                    values,
                    failure: None,
                };
                change(&mut row);
                rows.push(row);
            }
        }
    }
    (cells, vec![MethodName::Doppler, MethodName::ToaOnly], rows)
}

fn judged(test: Value, share: Option<f64>, change: impl Fn(&mut Row)) -> Judged {
    let claim: Claim = serde_json::from_value(json!({
        "id": "one", "claim": "a claim", "test": test, "share_of_layouts": share,
    }))
    .unwrap();
    let (cells, methods, rows) = trials(change);
    claim.check(&cells, &methods).unwrap();
    claim.judge(&Trials {
        cells: &cells,
        methods: &methods,
        rows: rows.iter().collect(),
    })
}

fn at(method: &str, periods: u32) -> Value {
    json!({"method": method, "where": {"localizer.periods": periods}})
}

#[track_caller]
fn says(test: Value, verdict: Verdict, words: &str) {
    let found = judged(test, None, |_| {});
    assert_eq!(found.verdict, verdict, "{}", found.ours);
    assert!(found.ours.contains(words), "{}", found.ours);
}

#[test]
fn bounds_are_of_the_mean() {
    let bound = |at_most: f64| json!({"test": "bound", "of": at("doppler", 4), "at_most": at_most});
    says(bound(0.0301), Verdict::Holds, "0.0300 m");
    says(bound(0.0299), Verdict::Fails, "0.0300 m");
    let least =
        |at_least: f64| json!({"test": "bound", "of": at("toa-only", 4), "at_least": at_least});
    says(least(0.0599), Verdict::Holds, "0.0600 m");
    says(least(0.0601), Verdict::Fails, "0.0600 m");
    let found = judged(bound(0.04), None, |_| {});
    // Of three values a millimetre apart.
    let [low, high] = found.interval.unwrap();
    assert!(
        (low - 0.029).abs() < 1e-6 && (high - 0.031).abs() < 1e-6,
        "{low} {high}"
    );
}

#[test]
fn ratios_are_of_means() {
    let ratio = |of, over, at_most: f64| json!({"test": "ratio", "of": of, "over": over, "at_most": at_most});
    says(
        ratio(at("doppler", 4), at("doppler", 1), 0.376),
        Verdict::Holds,
        "0.38",
    );
    says(
        ratio(at("doppler", 4), at("doppler", 1), 0.374),
        Verdict::Fails,
        "0.0300 m over 0.0800 m",
    );
    says(
        ratio(at("toa-only", 2), at("doppler", 2), 2.01),
        Verdict::Holds,
        "2.00",
    );
    let least = json!({"test": "ratio", "of": at("toa-only", 2), "over": at("doppler", 2), "at_least": 2.1});
    says(least, Verdict::Fails, "2.00");
}

#[test]
fn orders_are_strict() {
    let order = |of: Vec<Value>| json!({"test": "order", "of": of});
    let (best, good, bad) = (at("doppler", 4), at("doppler", 3), at("doppler", 1));
    says(
        order(vec![best.clone(), good.clone(), bad.clone()]),
        Verdict::Holds,
        "doppler, periods 4 0.0300 m; ",
    );
    says(
        order(vec![good, best.clone(), bad]),
        Verdict::Fails,
        "0.0310 m",
    );
    says(order(vec![best.clone(), best]), Verdict::Fails, "0.0300 m");
}

#[test]
fn the_best_is_judged_by_its_interval() {
    let best = |within: [f64; 2]| {
        let of = json!({"method": "doppler"});
        json!({"test": "best", "over": "localizer.periods", "of": of, "within": within})
    };
    let words = "best at 4; as good within its interval: 3 to 4";
    says(best([4.0, 6.0]), Verdict::Holds, words);
    // Not the minimum itself, but as good as it.
    says(best([2.0, 3.0]), Verdict::Holds, words);
    says(best([5.0, 8.0]), Verdict::Fails, words);
    says(best([1.0, 2.0]), Verdict::Fails, words);
}

#[test]
fn a_method_that_failed_holds_nothing() {
    let fail = |row: &mut Row| {
        if (row.cell, row.method, row.draw[3]) == (3, 0, 1) {
            (row.values, row.failure) = ([None; Measure::ALL.len()], Some("no echoes".to_string()));
        }
    };
    for test in [
        json!({"test": "bound", "of": at("doppler", 4), "at_most": 1.0}),
        json!({"test": "ratio", "of": at("doppler", 4), "over": at("doppler", 1), "at_most": 9.0}),
        json!({"test": "order", "of": [at("doppler", 4), at("doppler", 1)]}),
        json!({"test": "best", "over": "localizer.periods", "of": {"method": "doppler"}, "within": [0, 9]}),
    ] {
        let found = judged(test.clone(), None, fail);
        assert_eq!(found.verdict, Verdict::Fails, "{test}");
        assert!(found.ours.contains("failed"), "{}", found.ours);
    }
}

#[test]
fn shares_are_counted_over_layouts() {
    let test = json!({"test": "bound", "of": at("doppler", 4), "at_most": 0.0305});
    // Each filter in a layout of its own: 0.029, 0.030 and 0.031 m.
    let own_layout = |row: &mut Row| row.draw = [row.draw[3], 0, 0, 0];
    for (least, verdict) in [(0.66, Verdict::Holds), (0.67, Verdict::Fails)] {
        let found = judged(test.clone(), Some(least), own_layout);
        assert_eq!(
            (found.verdict, &*found.ours),
            (verdict, "in 2 of 3 layouts")
        );
        assert_eq!(found.interval, Some(share_interval(2, 3)));
    }
}
