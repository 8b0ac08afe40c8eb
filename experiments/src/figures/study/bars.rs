//! A measure of every cell and method, with intervals: one row each.

use std::path::Path;

use anyhow::{Result, bail};

use super::{cell_in_words, number};
use crate::figures::drawing::axes::Axes;
use crate::figures::drawing::axis::Axis;
use crate::figures::drawing::canvas::{self, LABEL};
use crate::figures::drawing::stroke::{Marker, Stroke};
use crate::figures::drawing::style::method_style;
use crate::study::StudySummary;
use crate::study::scores::Measure;

/// Most rows of one picture.
const MOST: usize = 60;
/// Height of a row in pixels.
const ROW: f64 = 46.0;
/// Least ratio of largest to least mean from which on the axis is logarithmic.
const WIDE: f64 = 20.0;

/// Draws the figure.
///
/// # Errors
/// When no trial has the measure, or the picture cannot be written.
pub(super) fn draw(summary: &StudySummary, measure: Measure, picture: &Path) -> Result<()> {
    let single = summary.cells.iter().all(|cell| cell.cell == "all");
    let rows: Vec<(String, &str, f64, [f64; 2])> = summary
        .cells
        .iter()
        .filter_map(|cell| {
            let mean = *cell.mean.get(measure.name())?;
            let interval = cell
                .interval
                .get(measure.name())
                .copied()
                .unwrap_or([mean; 2]);
            let (_, method) = method_style(cell.method.name());
            let name = match single {
                true => method.to_string(),
                false => format!("{}: {method}", cell_in_words(cell)),
            };
            Some((name, cell.method.name(), mean, interval))
        })
        .collect();
    let Some(best) = rows.iter().min_by(|a, b| a.2.total_cmp(&b.2)) else {
        bail!(
            "bars: no trial has {}; leave the figure out",
            measure.name()
        );
    };
    let title = format!("Least: {}{}: {}", number(best.2), measure.unit(), best.0);
    let left_out = rows.len().saturating_sub(MOST);
    let shown = &rows[..rows.len().min(MOST)];
    let high = shown.iter().map(|row| row.3[1]).fold(0.0, f64::max);
    let low = shown
        .iter()
        .map(|row| row.3[0])
        .fold(f64::INFINITY, f64::min);
    let wide = low > 0.0 && high / low > WIDE;
    let along = |value: f64| if wide { value.log10() } else { value };
    let x = match wide {
        true => Axis::logarithmic(0.8 * low, 1.25 * high, measure.title()),
        false => Axis::new(0.0, 1.06 * high.max(1e-9), measure.title()),
    };
    let height = 320.0 + ROW * shown.len() as f64;
    canvas::draw(picture, 1800, height as u32, |sheet| {
        sheet.title(&title)?;
        let widest = shown
            .iter()
            .map(|row| sheet.text_size(&row.0, LABEL - 4.0, false)[0])
            .fold(0.0, f64::max);
        let left = (widest + 60.0).min(1100.0);
        let count = shown.len() as f64;
        let axes = Axes::new(
            sheet,
            [left, 150.0, 1750.0, 150.0 + ROW * count],
            x,
            Axis::new(0.0, count, ""),
        );
        axes.grid_upright()?;
        for (index, (name, method, mean, [low, high])) in shown.iter().enumerate() {
            let (style, _) = method_style(method);
            let stroke = Stroke::solid(style.colour, 5.0);
            let y = count - 0.5 - index as f64;
            let [_, across] = axes.pixel(axes.x.low, y);
            sheet.text(
                name,
                [left - 16.0, across],
                (-1, 0),
                LABEL - 4.0,
                false,
                false,
            )?;
            axes.curve(&[(along(*low), y), (along(*high), y)], stroke)?;
            axes.markers(&[(along(*mean), y)], Marker::Disc, 18.0, style.colour)?;
        }
        let over = summary
            .cells
            .first()
            .map_or(String::new(), |cell| cell.over());
        let note = if left_out > 0 {
            format!("; {left_out} rows left out")
        } else {
            String::new()
        };
        axes.finish_upright(&format!("mean and 95 % interval over {over}{note}"))
    })
}
