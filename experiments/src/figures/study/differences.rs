//! Differences between two results of a study, cell by cell, with intervals.

use std::path::Path;

use anyhow::Result;

use crate::figures::drawing::axes::Axes;
use crate::figures::drawing::axis::Axis;
use crate::figures::drawing::canvas::{self, LABEL};
use crate::figures::drawing::colour;
use crate::figures::drawing::stroke::{Marker, Stroke};
use crate::study::compare::Difference;
use crate::study::scores::Measure;

/// Most rows of one picture, and the height of one in pixels.
const MOST: usize = 60;
const ROW: f64 = 46.0;

/// The title: in how many cells the second is clearly better or worse.
fn title(differences: &[Difference]) -> String {
    let clear = |sign: f64| {
        let beyond = |d: &&Difference| {
            d.trials > 1 && sign * d.interval[0] > 0.0 && sign * d.interval[1] > 0.0
        };
        differences.iter().filter(beyond).count()
    };
    let (larger, smaller) = (clear(1.0), clear(-1.0));
    let rest = differences.len() - larger - smaller;
    format!(
        "B is smaller in {smaller}, larger in {larger}, neither clearly in {rest} of {} rows",
        differences.len()
    )
}

/// Draws the figure.
///
/// # Errors
/// When the picture cannot be written.
pub(crate) fn draw(differences: &[Difference], measure: Measure, picture: &Path) -> Result<()> {
    let shown = &differences[..differences.len().min(MOST)];
    let reach = shown
        .iter()
        .flat_map(|d| d.interval)
        .fold(1e-9, |most: f64, end| most.max(end.abs()));
    let count = shown.len() as f64;
    canvas::draw(picture, 1800, (320.0 + ROW * count) as u32, |sheet| {
        sheet.title(&title(differences))?;
        let names: Vec<String> = shown
            .iter()
            .map(|d| match d.cell.as_str() {
                "all" => d.method.clone(),
                cell => format!("{cell}: {}", d.method),
            })
            .collect();
        let widest = names
            .iter()
            .map(|name| sheet.text_size(name, LABEL - 4.0, false)[0])
            .fold(0.0, f64::max);
        let left = (widest + 60.0).min(1100.0);
        let x = Axis::new(
            -1.1 * reach,
            1.1 * reach,
            &format!("B - A: {}", measure.title()),
        );
        let frame = [left, 150.0, 1750.0, 150.0 + ROW * count];
        let axes = Axes::new(sheet, frame, x, Axis::new(0.0, count, ""));
        axes.grid_upright()?;
        axes.curve(
            &[(0.0, 0.0), (0.0, count)],
            Stroke::solid(colour::BLACK, 2.0),
        )?;
        for (index, (difference, name)) in shown.iter().zip(&names).enumerate() {
            let y = count - 0.5 - index as f64;
            let [low, high] = difference.interval;
            let colour = match (low > 0.0, high < 0.0) {
                (true, _) => colour::VERMILLION,
                (_, true) => colour::BLUE,
                _ => colour::GREY,
            };
            let [_, across] = axes.pixel(axes.x.low, y);
            sheet.text(
                name,
                [left - 16.0, across],
                (-1, 0),
                LABEL - 4.0,
                false,
                false,
            )?;
            axes.curve(&[(low, y), (high, y)], Stroke::solid(colour, 5.0))?;
            axes.markers(&[(difference.difference, y)], Marker::Disc, 18.0, colour)?;
        }
        axes.finish_upright("mean of the paired differences and 95 % interval")
    })
}
