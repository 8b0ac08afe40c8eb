//! Measurements of laws as text: the whole table, and one line per law.

use oracles::laws::{LAWS, Measurement};

use super::row::Row;
use crate::data::table::{aligned, cell};

/// A number for the table: three significant digits.
fn number(value: f64) -> String {
    let size = value.abs();
    if size >= 100.0 {
        cell(value, 0)
    } else if size >= 0.01 {
        cell(value, 3)
    } else {
        format!("{value:.1e}")
    }
}

/// Tolerance of a measurement as text.
fn tolerance(measurement: &Measurement) -> String {
    match (measurement.least, measurement.most) {
        (Some(least), Some(most)) if least == -most => format!("\u{b1} {}", number(most)),
        (Some(least), Some(most)) => format!("{} to {}", number(least), number(most)),
        (None, Some(most)) => format!("< {}", number(most)),
        (Some(least), None) => format!("> {}", number(least)),
        (None, None) => String::new(),
    }
}

fn verdict(row: &Row) -> &'static str {
    match (row.measurement.informative, row.passed) {
        (true, _) => "shown",
        (false, true) => "passed",
        (false, false) => "FAILED",
    }
}

/// The cells of the table, headings first.
pub(super) fn cells(rows: &[Row]) -> Vec<Vec<String>> {
    let mut cells = vec![
        [
            "law",
            "case",
            "quantity",
            "tolerance",
            "measured",
            "verdict",
        ]
        .map(String::from)
        .to_vec(),
    ];
    cells.extend(rows.iter().map(|row| {
        vec![
            row.law.to_string(),
            row.measurement.case.clone(),
            row.measurement.quantity.to_string(),
            tolerance(&row.measurement),
            number(row.measurement.measured),
            verdict(row).to_string(),
        ]
    }));
    cells
}

/// The rows as an aligned table.
pub fn table(rows: &[Row]) -> String {
    aligned(&cells(rows))
}

/// Ratio of a measurement to its limit: 1 at the limit, above 1 beyond it.
fn nearness(measurement: &Measurement) -> f64 {
    let measured = measurement.measured;
    match (measurement.least, measurement.most) {
        (Some(least), Some(most)) => {
            (measured - 0.5 * (least + most)).abs() / (0.5 * (most - least))
        }
        (None, Some(most)) if most < 0.0 => most / measured,
        (None, Some(most)) => measured / most,
        (Some(least), None) => least / measured,
        (None, None) => 0.0,
    }
}

/// `laws.md`: one line per law with its number of measurements and the one nearest to its limit.
pub fn laws(rows: &[Row]) -> String {
    let mut text = String::from(
        "| law | within tolerance | nearest to its limit | tolerance | measured | verdict |\n\
        |---|---|---|---|---|---|\n",
    );
    for law in LAWS {
        let of_law: Vec<&Row> = rows
            .iter()
            .filter(|row| row.law == law.name && !row.measurement.informative)
            .collect();
        let nearest = of_law.iter().max_by(|one, other| {
            nearness(&one.measurement).total_cmp(&nearness(&other.measurement))
        });
        let Some(nearest) = nearest else { continue };
        let passed = of_law.iter().filter(|row| row.passed).count();
        let measurement = &nearest.measurement;
        text.push_str(&format!(
            "| {} | {passed} of {} | {}: {} | {} | {} | {} |\n",
            law.name,
            of_law.len(),
            measurement.case,
            measurement.quantity,
            tolerance(measurement),
            number(measurement.measured),
            if passed == of_law.len() {
                "passed"
            } else {
                "**FAILED**"
            },
        ));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_and_verdicts_are_text() {
        let row = |measurement: Measurement| Row {
            law: "law",
            passed: measurement.passed(),
            measurement,
        };
        let good = row(Measurement::within("case".into(), "level, dB", 0.02, 0.1));
        let bad = row(Measurement::below(
            "case".into(),
            "reflection, dB",
            -20.0,
            -60.0,
        ));
        let nan = row(Measurement::within(
            "case".into(),
            "level, dB",
            f64::NAN,
            0.1,
        ));
        let beside = row(Measurement::shown("case".into(), "level, dB", 7.0));
        assert_eq!(
            [&good, &bad, &nan, &beside].map(verdict),
            ["passed", "FAILED", "FAILED", "shown"]
        );
        assert_eq!(tolerance(&good.measurement), "\u{b1} 0.100");
        assert_eq!(tolerance(&bad.measurement), "< -60.000");
        assert!(table(&[good]).contains("passed"));
    }

    #[test]
    fn the_line_of_a_law_shows_the_measurement_nearest_to_its_limit() {
        let row = |measured: f64| {
            let measurement = Measurement::within("case".into(), "level, dB", measured, 0.1);
            Row {
                law: LAWS[0].name,
                passed: measurement.passed(),
                measurement,
            }
        };
        let text = laws(&[row(0.01), row(-0.08), row(0.02)]);
        assert!(
            text.contains("| 3 of 3 | case: level, dB | \u{b1} 0.100 | -0.080 | passed |"),
            "{text}"
        );
        assert!(laws(&[row(0.2), row(0.02)]).contains("| 1 of 2 |"));
        let below = Measurement::below("case".into(), "reflection, dB", -80.0, -60.0);
        assert_eq!(nearness(&below), 0.75);
    }
}
