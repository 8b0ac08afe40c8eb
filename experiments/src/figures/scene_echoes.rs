//! Echoes of the paper-size scene, field beside image sources: the signals at one place, and level and delay of every
//! echo that stands alone.

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
pub(crate) const NEEDS: [&str; 2] = ["scene_signal.csv", "scene_echoes.csv"];

const FIELD: Stroke = Stroke::solid(colour::BLUE, 3.0);
const IMAGES: Stroke = Stroke::solid(colour::VERMILLION, 3.0).dashed(&[10.0, 7.0]);

/// Draws the figure.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let signal = Table::read(&data.join(NEEDS[0]))?;
    let echoes = Table::read(&data.join(NEEDS[1]))?;
    let times = signal.numbers("t_ms")?;
    let curve = |column: &str| -> Result<Vec<(f64, f64)>> {
        let values = signal.numbers(column)?;
        Ok(times
            .iter()
            .copied()
            .zip(values.into_iter().map(|p| 1e3 * p))
            .collect())
    };
    let (field, images) = (curve("field_pa")?, curve("images_pa")?);
    let peak = images
        .iter()
        .fold(0.0_f64, |most, (_, p)| most.max(p.abs()));
    canvas::draw(picture, 1800, 1330, |sheet| {
        let largest = |column: &str| -> Result<f64> {
            let values = echoes.numbers(column)?;
            Ok(values.into_iter().map(f64::abs).fold(0.0, f64::max))
        };
        sheet.title(&format!(
            "Echoes that stand alone are within {:.2} dB and {:.2} \u{b5}s of their images",
            largest("louder_db")?,
            largest("late_us")?
        ))?;
        let entries = [
            Entry::line(FIELD, "field, minus the same without walls"),
            Entry::line(IMAGES, "image sources of first and second order"),
        ];
        legend(sheet, [150.0, 75.0], 1600.0, &entries)?;
        let last = times.last().copied().unwrap_or(1.0);
        let axes = Axes::new(
            sheet,
            [150.0, 180.0, 1760.0, 600.0],
            Axis::new(0.0, last, "time since the burst [ms]"),
            Axis::new(-1.25 * peak, 1.25 * peak, "pressure [mPa]"),
        );
        axes.grid()?;
        axes.curve(&field, FIELD)?;
        axes.curve(&images, IMAGES)?;
        axes.finish("(a) echoes at one place, all walls")?;
        let panels = [
            (
                "louder_db",
                150.0,
                "level, field over image [dB]",
                "(b) level",
            ),
            (
                "late_us",
                1050.0,
                "delay, field minus image [\u{b5}s]",
                "(c) delay, dispersion taken out",
            ),
        ];
        for (column, left, label, name) in panels {
            let values = echoes.numbers(column)?;
            let axes = Axes::new(
                sheet,
                [left, 780.0, left + 710.0, 1170.0],
                Axis::new(0.0, 9.0, "length of the path [m]"),
                Axis::around(values.iter().copied().chain([-0.5, 0.5]), 0.15, label),
            );
            axes.grid()?;
            axes.curve(&[(0.0, 0.0), (9.0, 0.0)], Stroke::solid(colour::GREY, 2.0))?;
            for (walls, marker, size, shade) in marks() {
                let rows = echoes.only("scene", walls)?;
                let points: Vec<(f64, f64)> = rows
                    .numbers("length_m")?
                    .into_iter()
                    .zip(rows.numbers(column)?)
                    .collect();
                axes.markers(&points, marker, size, shade)?;
            }
            axes.finish(name)?;
        }
        let entries = marks().map(|(walls, marker, _, shade)| Entry {
            stroke: None,
            marker: Some((marker, shade)),
            text: format!("{walls}, as cut cells"),
        });
        legend(sheet, [150.0, 1270.0], 1600.0, &entries)?;
        Ok(())
    })
}

/// Selections of walls, and the markers of their echoes with sizes: the first remains visible beneath the second.
fn marks() -> [(&'static str, Marker, f64, plotters::style::RGBColor); 2] {
    [
        ("pair along the grid", Marker::Disc, 28.0, colour::BLUE),
        ("all walls", Marker::Triangle, 15.0, colour::ORANGE),
    ]
}
