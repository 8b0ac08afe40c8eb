//! Number of periods M in one block: estimated paths and mean position error (2023 abstract, Fig. 2).

use std::path::Path;

use anyhow::Result;

use super::axes::{Axes, TITLE};
use super::axis::Axis;
use super::canvas::{self, Marker, Stroke};
use super::layout::{Layout, drive_points, path};
use super::legend::{Entry, legend};
use super::{colour, means_by, method_style};
use crate::table::Table;

const STROKES: [Stroke; 4] = [
    Stroke::solid(colour::PURPLE, 4.5).dashed(&[6.0, 8.0]),
    Stroke::solid(colour::ORANGE, 4.5).dashed(&[22.0, 9.0, 5.0, 9.0]),
    Stroke::solid(colour::GREEN, 4.5).dashed(&[22.0, 9.0]),
    Stroke::solid(colour::BLUE, 4.5),
];
const MARKERS: [Marker; 4] = [
    Marker::Diamond,
    Marker::Triangle,
    Marker::Square,
    Marker::Disc,
];

/// The style of a number of periods, the same in every preset: up to 1, 2 and 4, and more.
fn style_of(periods: f64) -> usize {
    [1.0, 2.0, 4.0]
        .iter()
        .filter(|limit| periods > **limit)
        .count()
}

/// Draws the figure.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let layout = Layout::read(data)?;
    let truth = drive_points(&Table::read(&data.join("drive.csv"))?, "localization")?;
    let paths = Table::read(&data.join("periods_paths.csv"))?;
    let table = Table::read(&data.join("periods.csv"))?;
    let cells = means_by(&table, "m", "mae_m")?;
    canvas::draw(picture, 1800, 1040, |sheet| {
        let title = "More periods in a block resolve the Doppler shift, and hold the path";
        sheet.text(title, [0.5 * sheet.width, 20.0], (0, 1), TITLE, true, false)?;
        let left = layout.axes(sheet, [120.0, 185.0, 860.0, 925.0]);
        left.grid()?;
        layout.walls(&left, Stroke::solid(colour::GREY, 6.0))?;
        let (black, name) = method_style("truth");
        path(&left, &truth, black)?;
        let mut entries = vec![Entry {
            stroke: Some(black),
            marker: None,
            text: name.to_string(),
        }];
        for periods in &paths.distinct("m")? {
            let index = style_of(periods.parse().unwrap_or(0.0));
            let rows = paths.only("m", periods)?;
            let points: Vec<(f64, f64)> = rows
                .numbers("x_m")?
                .into_iter()
                .zip(rows.numbers("y_m")?)
                .collect();
            let stroke = STROKES[index];
            left.curve(&points, stroke)?;
            entries.push(Entry {
                stroke: Some(stroke),
                marker: Some((MARKERS[index], stroke.colour)),
                text: format!("M = {periods}"),
            });
        }
        left.finish("(a) estimated positions (first trial)")?;
        let highest = cells.iter().map(|cell| cell.2[1]).fold(1e-3, f64::max);
        let right = Axes::new(
            sheet,
            [1050.0, 185.0, 1750.0, 925.0],
            Axis::around(
                cells.iter().map(|cell| cell.0),
                0.08,
                "periods M in a block",
            ),
            Axis::new(0.0, 1.08 * highest, "MAE of position [m]"),
        );
        right.grid()?;
        let curve: Vec<(f64, f64)> = cells.iter().map(|cell| (cell.0, cell.1)).collect();
        right.curve(&curve, Stroke::solid(colour::GREY, 3.0))?;
        for cell in &cells {
            let index = style_of(cell.0);
            let shade = STROKES[index].colour;
            right.whiskers(&[(cell.0, cell.2[0], cell.2[1])], shade)?;
            right.markers(&[(cell.0, cell.1)], MARKERS[index], 24.0, shade)?;
        }
        right.finish("(b) mean error, bars: 95 % interval")?;
        legend(sheet, [120.0, 80.0], 1620.0, &entries)?;
        Ok(())
    })
}
