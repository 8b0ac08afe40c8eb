//! The field against laws of physics: runs them, and writes table, data and figure.

use std::f64::consts::TAU;
use std::path::Path;

use anyhow::Result;
use fdtd::scheme::Scheme;
use fdtd::validation::rig::{AIR, DT_S, DX_M};
use fdtd::validation::{Depth, LAWS, Measurement, dispersion, scene_echoes};
use rayon::prelude::*;
use serde::Serialize;

use crate::atomic;
use crate::check::aligned;
use crate::figures;
use crate::interrupt;
use crate::progress::Board;
use crate::provenance::Provenance;
use crate::table::{Table, cell};

/// Directions of the curves of the dispersion relation, degrees.
const ANGLES_DEG: [f64; 3] = [0.0, 22.5, 45.0];

/// One line of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The law.
    pub law: &'static str,
    /// What was measured.
    #[serde(flatten)]
    pub measurement: Measurement,
    /// Whether it is within its range.
    pub passed: bool,
}

/// Measures all laws; several run side by side, the order of the rows does not depend on it.
///
/// # Errors
/// When a field becomes non-finite, or [`interrupt::Interrupted`].
pub fn run(depth: Depth) -> Result<Vec<Row>> {
    let board = Board::new();
    let task = board.task("validate", LAWS.len() as u64);
    let done = std::sync::atomic::AtomicU64::new(0);
    let found: Vec<Result<Vec<Row>>> = LAWS
        .par_iter()
        .map(|law| {
            interrupt::check()?;
            let measurements = (law.measure)(depth)?;
            task.set(1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed));
            Ok(measurements
                .into_iter()
                .map(|measurement| Row {
                    law: law.name,
                    passed: measurement.passed(),
                    measurement,
                })
                .collect())
        })
        .collect();
    task.finish();
    let mut rows = Vec::new();
    for part in found {
        rows.extend(part?);
    }
    Ok(rows)
}

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

/// What a measurement may be, in words.
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
fn cells(rows: &[Row]) -> Vec<Vec<String>> {
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

/// Curves of the dispersion relation on the papers' grid.
fn curves() -> Table {
    let header = [
        "scheme",
        "angle_deg",
        "frequency_hz",
        "phase_error",
        "group_error",
    ];
    let mut table = Table::new(header);
    for scheme in Scheme::ALL {
        let grid = scheme.polynomial(AIR.c_mps * DT_S / DX_M);
        for angle_deg in ANGLES_DEG {
            for step in 1..=76 {
                let frequency_hz = 250.0 * f64::from(step);
                let (omega_dt, angle_rad) = (TAU * frequency_hz * DT_S, angle_deg.to_radians());
                let velocities = grid
                    .phase_velocity(omega_dt, angle_rad)
                    .zip(grid.group_velocity(omega_dt, angle_rad));
                if let Some((phase, group)) = velocities {
                    table.push([
                        scheme.to_string(),
                        angle_deg.to_string(),
                        cell(frequency_hz, 0),
                        cell(phase - 1.0, 7),
                        cell(group - 1.0, 7),
                    ]);
                }
            }
        }
    }
    table
}

/// Phase velocities measured on the field.
fn measured(depth: Depth) -> Result<Table> {
    let header = ["scheme", "angle_deg", "frequency_hz", "phase_error"];
    let mut table = Table::new(header);
    for velocity in dispersion::all(depth)? {
        table.push([
            velocity.scheme.to_string(),
            cell(velocity.angle_rad.to_degrees(), 1),
            cell(velocity.frequency_hz, 0),
            cell(velocity.expected * (1.0 + velocity.error) - 1.0, 7),
        ]);
    }
    Ok(table)
}

/// Echoes of the scene, field and images: the signals at a place of the whole scene, and what every echo that stands alone is off.
fn scene_echoes(depth: Depth, data: &Path) -> Result<()> {
    let places = scene_echoes::places(depth)?;
    let mut signal = Table::new(["t_ms", "field_pa", "images_pa"]);
    if let Some(place) = places.iter().find(|place| place.whole) {
        // At 60 kHz, from the burst's peak on.
        let since_s = |n: usize| n as f64 * DT_S - scene_echoes::burst().centre_s;
        for n in (0..place.heard.len())
            .step_by(2)
            .filter(|&n| since_s(n) >= 0.0)
        {
            signal.push([
                cell(1e3 * since_s(n), 4),
                format!("{:.4e}", place.heard[n]),
                format!("{:.4e}", place.images[n]),
            ]);
        }
    }
    signal.write(&data.join("scene_signal.csv"))?;
    let header = [
        "x_m",
        "y_m",
        "scene",
        "kind",
        "walls",
        "length_m",
        "louder_db",
        "late_us",
        "late_on_c_us",
    ];
    let mut table = Table::new(header);
    for place in &places {
        for echo in &place.echoes {
            table.push([
                cell(place.place_m[0], 4),
                cell(place.place_m[1], 4),
                if place.whole {
                    "all walls"
                } else {
                    "pair along the grid"
                }
                .to_string(),
                echo.kind.name().to_string(),
                if echo.along_grid {
                    "along the grid"
                } else {
                    "slanted"
                }
                .to_string(),
                cell(echo.length_m, 4),
                cell(echo.louder_db, 3),
                cell(1e6 * echo.late_s, 2),
                cell(1e6 * echo.late_on_c_s, 1),
            ]);
        }
    }
    table.write(&data.join("scene_echoes.csv"))
}

/// Writes `validation.json`, `table.md`, `laws.md` and the data of the figures into `folder`.
///
/// # Errors
/// When a file cannot be written.
pub fn write(rows: &[Row], depth: Depth, folder: &Path) -> Result<()> {
    let full = depth == Depth::Full;
    let json = serde_json::json!({
        "full": full, "provenance": Provenance::here(), "measurements": rows,
    });
    atomic::write(
        &folder.join("validation.json"),
        &serde_json::to_vec_pretty(&json)?,
    )?;
    let mut text = String::new();
    for (index, row) in cells(rows).iter().enumerate() {
        text.push_str(&format!("| {} |\n", row.join(" | ")));
        if index == 0 {
            text.push_str(&format!("|{}\n", "---|".repeat(row.len())));
        }
    }
    atomic::write(&folder.join("table.md"), text.as_bytes())?;
    atomic::write(&folder.join("laws.md"), laws(rows).as_bytes())?;
    let data = folder.join("data");
    scene_echoes(depth, &data)?;
    curves().write(&data.join("dispersion.csv"))?;
    measured(depth)?.write(&data.join("phase_velocity.csv"))
}

/// How near to its limit a measurement comes: 1 at the limit, above beyond it.
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

/// One line per law: how much was measured, and what came nearest to its limit. README quotes it.
pub fn laws(rows: &[Row]) -> String {
    let mut text = String::from(
        "| law | within tolerance | nearest to its limit | tolerance | measured | verdict |\n|---|---|---|---|---|---|\n",
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

/// Draws the figures from the data in `folder`.
///
/// # Errors
/// When the data is missing or damaged, or the picture cannot be written.
pub fn draw(folder: &Path) -> Result<Vec<std::path::PathBuf>> {
    let (data, figures) = (folder.join("data"), folder.join("figures"));
    let pictures = ["fig_dispersion.png", "fig_scene_echoes.png"].map(|name| figures.join(name));
    figures::dispersion::draw(&data, &pictures[0])?;
    figures::scene_echoes::draw(&data, &pictures[1])?;
    Ok(pictures.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_and_verdicts_are_said_in_words() {
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
    fn a_law_is_told_by_what_comes_nearest_to_its_limit() {
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

    #[test]
    fn the_curves_hold_every_scheme() {
        let table = curves();
        assert_eq!(
            table.distinct("scheme").unwrap(),
            ["slf", "m13", "o13", "d25"]
        );
    }
}
