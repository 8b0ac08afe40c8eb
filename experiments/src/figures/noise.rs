//! Figures 9 and 16: mean position error over the signal-to-noise ratio, eqs. (19)-(21) and (22)-(24).

use std::path::Path;

use anyhow::Result;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas;
use super::drawing::colour;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::{Marker, Stroke};
use super::drawing::style::method_style;
use super::means::means_by;
use crate::data::table::Table;

/// Draws figure 9.
///
/// # Errors
/// When the data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    draw_with(data, picture, 0.05)
}

/// Draws figure 16.
///
/// # Errors
/// As [`draw`].
pub(crate) fn draw_site(data: &Path, picture: &Path) -> Result<()> {
    draw_with(data, picture, 0.1)
}

/// Draws the errors beside the paper's bound from 3 dB on, metres.
fn draw_with(data: &Path, picture: &Path, limit_m: f64) -> Result<()> {
    let table = Table::read(&data.join("snr.csv"))?;
    let cells = means_by(&table, "snr_db", "mae_m")?;
    let curve: Vec<(f64, f64)> = cells.iter().map(|cell| (cell.0, cell.1)).collect();
    let whiskers: Vec<(f64, f64, f64)> = cells
        .iter()
        .map(|cell| (cell.0, cell.2[0], cell.2[1]))
        .collect();
    let highest = whiskers
        .iter()
        .map(|bar| bar.2)
        .fold(1.2 * limit_m, f64::max);
    let (stroke, _) = method_style("doppler");
    let limit = Stroke::solid(colour::BLACK, 2.5).dashed(&[12.0, 8.0]);
    let worst_above_3 = cells
        .iter()
        .filter(|cell| cell.0 >= 3.0)
        .map(|cell| cell.1)
        .fold(0.0, f64::max);
    canvas::draw(picture, 1600, 1100, |sheet| {
        let title = format!("From 3 dB on the mean error is {worst_above_3:.3} m at most");
        sheet.title(&title)?;
        let axes = Axes::new(
            sheet,
            [190.0, 210.0, 1550.0, 980.0],
            Axis::around(
                curve.iter().map(|point| point.0),
                0.05,
                "signal-to-noise ratio [dB]",
            ),
            Axis::new(0.0, 1.06 * highest, "MAE of position [m]"),
        );
        axes.grid()?;
        axes.curve(&[(axes.x.low, limit_m), (axes.x.high, limit_m)], limit)?;
        axes.curve(&[(3.0, 0.0), (3.0, axes.y.high)], limit)?;
        axes.curve(&curve, stroke)?;
        axes.whiskers(&whiskers, stroke.colour)?;
        axes.markers(&curve, Marker::Disc, 20.0, stroke.colour)?;
        axes.finish("noise added to the localization drive")?;
        let trials = table.distinct("trial")?.len();
        let entries = [
            Entry {
                stroke: Some(stroke),
                marker: Some((Marker::Disc, stroke.colour)),
                text: format!("Doppler, mean of {trials} noise seeds; bars: 95 % interval"),
            },
            Entry {
                stroke: Some(limit),
                marker: None,
                text: format!("paper: below {limit_m} m above 3 dB"),
            },
        ];
        legend(sheet, [190.0, 72.0], 1400.0, &entries)?;
        Ok(())
    })
}
