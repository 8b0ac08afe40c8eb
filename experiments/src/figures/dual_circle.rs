//! Nine test points inside four receivers: true, published and ours (Hsu et al., Sens. Mater. 2021, Fig. 14 and Tables 1 and 2).

use std::path::Path;

use anyhow::Result;
use plotters::style::RGBColor;

use super::axes::Axes;
use super::axis::Axis;
use super::canvas::{self, Marker, Stroke};
use super::colour;
use super::legend::{Entry, legend};
use crate::table::Table;

/// How much longer errors are drawn than they are.
const MAGNIFIED: f64 = 5.0;

/// Estimates of a method: true position plus the magnified error.
fn points(table: &Table, method: &str) -> Result<Vec<(f64, f64)>> {
    let rows = table.only("method", method)?;
    let axis = |found: &str, truth: &str| -> Result<Vec<f64>> {
        let pairs = rows.numbers(found)?.into_iter().zip(rows.numbers(truth)?);
        Ok(pairs
            .map(|(found, truth)| truth + MAGNIFIED * (found - truth))
            .collect())
    };
    let y = axis("y_m", "y_true_m")?;
    Ok(axis("x_m", "x_true_m")?.into_iter().zip(y).collect())
}

/// Draws the figure.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let published = Table::read(&data.join("dual_circle_published.csv"))?;
    let ours = Table::read(&data.join("dual_circle.csv"))?.only("trial", "0")?;
    let styles: [(&Table, &str, &str, Marker, RGBColor); 5] = [
        (
            &published,
            "dual-circle",
            "published, dual circle",
            Marker::Square,
            colour::VERMILLION,
        ),
        (
            &published,
            "triangulation",
            "published, triangulation",
            Marker::Triangle,
            colour::ORANGE,
        ),
        (
            &ours,
            "dual-circle",
            "ours, dual circle",
            Marker::Square,
            colour::BLUE,
        ),
        (
            &ours,
            "triangulation",
            "ours, triangulation",
            Marker::Triangle,
            colour::SKY,
        ),
        (
            &ours,
            "least-squares",
            "ours, least squares",
            Marker::Diamond,
            colour::GREEN,
        ),
    ];
    canvas::draw(picture, 1300, 1440, |sheet| {
        let title = "Nine points by the circles around four receivers";
        sheet.title(title)?;
        let axes = Axes::equal(
            sheet,
            [130.0, 320.0, 1260.0, 1340.0],
            Axis::new(-0.25, 4.25, "x [m]"),
            Axis::new(-0.25, 4.25, "y [m]"),
        );
        axes.grid()?;
        let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)];
        let site = [&corners[..], &corners[..1]].concat();
        axes.curve(&site, Stroke::solid(colour::GREY, 3.0))?;
        axes.markers(&corners, Marker::Disc, 30.0, colour::GREY)?;
        let entry = |marker, text: &str| Entry {
            stroke: None,
            marker: Some(marker),
            text: text.to_string(),
        };
        let mut entries = vec![
            entry((Marker::Disc, colour::GREY), "receiver"),
            entry((Marker::Disc, colour::BLACK), "true"),
        ];
        let rows = published.only("method", "dual-circle")?;
        let y = rows.numbers("y_true_m")?;
        let truth: Vec<(f64, f64)> = rows.numbers("x_true_m")?.into_iter().zip(y).collect();
        axes.markers(&truth, Marker::Disc, 15.0, colour::BLACK)?;
        for (table, method, text, marker, shade) in styles {
            let found = points(table, method)?;
            for (from, to) in truth.iter().zip(&found) {
                axes.curve(&[*from, *to], Stroke::solid(shade, 2.5))?;
            }
            axes.markers(&found, marker, 17.0, shade)?;
            entries.push(entry((marker, shade), text));
        }
        axes.finish("errors drawn 5 times as long; ours: first trial")?;
        legend(sheet, [110.0, 80.0], 1150.0, &entries)?;
        Ok(())
    })
}
