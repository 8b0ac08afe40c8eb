//! Angular resolution over the number of periods M: the bank's response to one exact echo, and its half-power width
//! beside theory.

use std::path::Path;

use anyhow::Result;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas;
use super::drawing::colour;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::{Marker, Stroke};
use super::drawing::style::periods_style;
use crate::data::table::Table;

/// The title: by how much, at most, the measured widths differ from theory, both over the periods.
fn title(measured: &[(f64, f64)], theory: &[(f64, f64)]) -> String {
    let pairs = measured.iter().zip(theory);
    let worst = pairs
        .map(|(measured, theory)| 100.0 * (measured.1 / theory.1 - 1.0).abs())
        .fold(0.0, f64::max);
    format!("The half-power width over cos \u{3b8} is within {worst:.1} % of theory")
}

/// Draws the figure.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let answers = Table::read(&data.join("angular_resolution.csv"))?;
    let widths = Table::read(&data.join("angular_resolution_widths.csv"))?;
    let pairs = |column: &str| -> Result<Vec<(f64, f64)>> {
        Ok(widths
            .numbers("m")?
            .into_iter()
            .zip(widths.numbers(column)?)
            .collect())
    };
    let (measured, theory) = (pairs("half_power_width")?, pairs("theory")?);
    let line = Stroke::solid(colour::BLACK, 3.0).dashed(&[12.0, 8.0]);
    canvas::draw(picture, 1800, 1000, |sheet| {
        sheet.title(&title(&measured, &theory))?;
        let left = Axes::new(
            sheet,
            [170.0, 225.0, 870.0, 870.0],
            Axis::new(-1.0, 1.0, "cosine of the angle to the heading"),
            Axis::new(0.0, 1.05, "intensity / maximum"),
        );
        left.grid()?;
        let mut entries = Vec::new();
        for m in &answers.distinct("m")? {
            let Some((stroke, marker)) = periods_style(m) else {
                continue;
            };
            let rows = answers.only("m", m)?;
            let points: Vec<(f64, f64)> = rows
                .numbers("cos_theta")?
                .into_iter()
                .zip(rows.numbers("level")?)
                .collect();
            left.curve(&points, stroke)?;
            entries.push(Entry {
                stroke: Some(stroke),
                marker: Some((marker, stroke.colour)),
                text: format!("M = {m}"),
            });
        }
        left.finish("(a) one echo from 60\u{b0} at 0.3 m/s")?;
        let highest = measured.iter().chain(&theory).map(|point| point.1);
        let highest = highest.fold(1e-3, f64::max);
        let right = Axes::new(
            sheet,
            [1050.0, 225.0, 1750.0, 870.0],
            Axis::around(
                measured.iter().map(|point| point.0),
                0.08,
                "periods M in a block",
            ),
            Axis::new(0.0, 1.08 * highest, "half-power width in cos \u{3b8}"),
        );
        right.grid()?;
        right.curve(&theory, line)?;
        for &(m, width) in &measured {
            let style = periods_style(&m.to_string());
            let (shade, marker) = style.map_or((colour::GREY, Marker::Disc), |(stroke, marker)| {
                (stroke.colour, marker)
            });
            right.markers(&[(m, width)], marker, 24.0, shade)?;
        }
        right.finish("(b) resolution")?;
        if measured
            .iter()
            .any(|point| periods_style(&point.0.to_string()).is_none())
        {
            entries.push(Entry {
                stroke: None,
                marker: Some((Marker::Disc, colour::GREY)),
                text: "other M, only in (b)".to_string(),
            });
        }
        entries.push(Entry::line(line, "theory 0.886 c / (2 f M T v)"));
        legend(sheet, [170.0, 85.0], 1600.0, &entries)?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::title;

    #[test]
    fn the_title_holds_for_the_worst_width() {
        assert_eq!(
            title(&[(1.0, 0.96), (2.0, 0.5)], &[(1.0, 1.0), (2.0, 0.5)]),
            "The half-power width over cos \u{3b8} is within 4.0 % of theory"
        );
    }
}
