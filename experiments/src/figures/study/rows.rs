//! Rows with a name, a mean and an interval each: what bars and differences share.

use std::path::Path;

use anyhow::Result;
use plotters::style::RGBColor;

use crate::figures::drawing::axes::Axes;
use crate::figures::drawing::axis::Axis;
use crate::figures::drawing::canvas::{self, LABEL};
use crate::figures::drawing::colour;
use crate::figures::drawing::stroke::{Marker, Stroke};

/// Most rows of one picture.
pub(super) const MOST: usize = 60;
/// Height of a row in pixels.
const HEIGHT: f64 = 46.0;
/// Size of the names in pixels.
const NAME: f64 = LABEL - 4.0;

/// A row, in places on the axis.
pub(super) struct Row {
    pub(super) name: String,
    pub(super) mean: f64,
    pub(super) interval: [f64; 2],
    pub(super) colour: RGBColor,
}

/// Draws rows from the top; `zero` marks the axis' zero by a line.
///
/// # Errors
/// When the picture cannot be written.
pub(super) fn draw(
    rows: &[Row],
    x: Axis,
    zero: bool,
    [title, note]: [&str; 2],
    picture: &Path,
) -> Result<()> {
    let count = rows.len() as f64;
    canvas::draw(picture, 1800, (320.0 + HEIGHT * count) as u32, |sheet| {
        sheet.title(title)?;
        let widest = rows
            .iter()
            .map(|row| sheet.text_size(&row.name, NAME, false)[0])
            .fold(0.0, f64::max);
        let left = (widest + 60.0).min(1100.0);
        let frame = [left, 150.0, 1750.0, 150.0 + HEIGHT * count];
        let axes = Axes::new(sheet, frame, x, Axis::new(0.0, count, ""));
        axes.grid_upright()?;
        if zero {
            let line = [(0.0, 0.0), (0.0, count)];
            axes.curve(&line, Stroke::solid(colour::BLACK, 2.0))?;
        }
        for (index, row) in rows.iter().enumerate() {
            let y = count - 0.5 - index as f64;
            let [low, high] = row.interval;
            let [_, across] = axes.pixel(axes.x.low, y);
            let place = [left - 16.0, across];
            sheet.text(&row.name, place, (-1, 0), NAME, false, false)?;
            axes.curve(&[(low, y), (high, y)], Stroke::solid(row.colour, 5.0))?;
            axes.markers(&[(row.mean, y)], Marker::Disc, 18.0, row.colour)?;
        }
        axes.finish_upright(note)
    })
}
