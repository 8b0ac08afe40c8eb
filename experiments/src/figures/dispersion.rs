//! Speed of sound on the grid: error of phase and group velocity over frequency, by direction, per scheme.

use std::path::Path;

use anyhow::Result;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas;
use super::drawing::colour;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::{Marker, Stroke};
use crate::data::table::Table;

/// Data files that the figure is drawn from.
pub(crate) const NEEDS: [&str; 2] = ["dispersion.csv", "velocity.csv"];

/// Line of a scheme along a direction.
fn stroke(scheme: &str, angle_deg: &str) -> Stroke {
    let shade = match scheme {
        "slf" => colour::VERMILLION,
        "m13" => colour::BLUE,
        "o13" => colour::GREEN,
        "iwb" => colour::ORANGE,
        _ => colour::BLACK,
    };
    let dashes: &[f64] = match angle_deg {
        "0" => &[],
        "22.5" => &[20.0, 9.0],
        _ => &[5.0, 9.0],
    };
    Stroke::solid(shade, 4.0).dashed(dashes)
}

/// Largest frequency in hertz that the title speaks of.
const TITLE_HZ: f64 = 10e3;

/// The title, from the measured velocities: the largest error of each scheme.
fn title(schemes: &[String], measured: &Table) -> Result<String> {
    let mut errors = Vec::new();
    for scheme in schemes {
        let rows = measured.only("scheme", scheme)?;
        let largest = rows
            .numbers("frequency_hz")?
            .into_iter()
            .zip(rows.numbers("phase_error")?)
            .filter(|(frequency_hz, _)| *frequency_hz <= TITLE_HZ)
            .fold(0.0_f64, |largest, (_, error)| largest.max(error.abs()));
        errors.push(format!("{scheme} {:.2} %", 100.0 * largest));
    }
    Ok(format!(
        "Errors of the phase velocity up to {:.0} kHz: {}",
        1e-3 * TITLE_HZ,
        errors.join(", ")
    ))
}

/// Draws the figure.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let table = Table::read(&data.join(NEEDS[0]))?;
    let measured = Table::read(&data.join(NEEDS[1]))?;
    let schemes = table.distinct("scheme")?;
    let angles = table.distinct("angle_deg")?;
    canvas::draw(picture, 1800, 1040, |sheet| {
        sheet.title(&title(&schemes, &measured)?)?;
        let panels = [
            ("phase_error", 140.0, [-3.0, 0.5], "(a) phase velocity"),
            (
                "group_error",
                1030.0,
                [-9.0, 1.5],
                "(b) group velocity, which delays echoes",
            ),
        ];
        for (column, left, range, name) in panels {
            let axes = Axes::new(
                sheet,
                [left, 235.0, left + 730.0, 920.0],
                Axis::new(0.0, 19.0, "frequency [kHz]"),
                Axis::new(range[0], range[1], "error of the speed of sound [%]"),
            );
            axes.grid()?;
            for scheme in &schemes {
                let rows = table.only("scheme", scheme)?;
                for angle in &angles {
                    let rows = rows.only("angle_deg", angle)?;
                    let errors = rows.numbers(column)?.into_iter().map(|error| 100.0 * error);
                    let points: Vec<(f64, f64)> = rows
                        .numbers("frequency_hz")?
                        .into_iter()
                        .map(|frequency_hz| 1e-3 * frequency_hz)
                        .zip(errors)
                        .collect();
                    axes.curve(&points, stroke(scheme, angle))?;
                }
                let rows = measured.only("scheme", scheme)?;
                let points: Vec<(f64, f64)> = rows
                    .numbers("frequency_hz")?
                    .into_iter()
                    .map(|frequency_hz| 1e-3 * frequency_hz)
                    .zip(rows.numbers(column)?.into_iter().map(|error| 100.0 * error))
                    .collect();
                let shade = stroke(scheme, "0").colour;
                axes.markers(&points, Marker::Disc, 17.0, shade)?;
            }
            axes.finish(name)?;
        }
        let mut entries: Vec<Entry> = schemes
            .iter()
            .map(|scheme| Entry::line(stroke(scheme, "0"), scheme))
            .collect();
        entries.extend(angles.iter().map(|angle| {
            let line = Stroke {
                colour: colour::GREY,
                ..stroke("d25", angle)
            };
            Entry::line(line, &format!("{angle}\u{b0} to an axis"))
        }));
        entries.push(Entry {
            stroke: None,
            marker: Some((Marker::Disc, colour::GREY)),
            text: "measured on the field".to_string(),
        });
        legend(sheet, [140.0, 80.0], 1640.0, &entries)?;
        Ok(())
    })
}
