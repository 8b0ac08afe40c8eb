//! What one echo's peak is off by beside its Cramer-Rao bound, over noise and periods (theory of landmarks).

use std::path::Path;

use anyhow::Result;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas;
use super::drawing::colour;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::{Marker, Stroke};
use crate::data::table::Table;

/// Colours of the periods in rising order.
const COLOURS: [plotters::style::RGBColor; 4] =
    [colour::ORANGE, colour::GREEN, colour::BLUE, colour::PURPLE];

/// A panel: title, columns of measurement and bound, label, and what the numbers are multiplied by.
type Panel = (&'static str, [&'static str; 2], &'static str, f64);

const PANELS: [Panel; 2] = [
    (
        "(a) range",
        ["range_m", "range_bound_m"],
        "range off by, root mean square [mm]",
        1e3,
    ),
    (
        "(b) cosine of the bearing",
        ["cosine", "cosine_bound"],
        "cosine off by, root mean square",
        1.0,
    ),
];

/// Name of the data file.
pub(super) const DATA: &str = "landmark_bound.csv";

/// Draws the figure.
///
/// # Errors
/// When the data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let table = Table::read(&data.join(DATA))?;
    let periods = table.distinct("periods")?;
    // Over the bound where an echo stands 20 dB below the noise: what the title says.
    let weak = table.only("snr_db", "-20")?;
    let ratios: Vec<f64> = (weak.numbers("range_m")?.iter())
        .zip(weak.numbers("range_bound_m")?)
        .map(|(measured, bound)| measured / bound)
        .collect();
    let most = ratios.iter().copied().fold(0.0, f64::max);
    canvas::draw(picture, 1900, 830, |sheet| {
        sheet.title(&format!(
            "20 dB below the noise, an echo's range is off by at most {most:.1} times the Cram\u{e9}r-Rao bound"
        ))?;
        for (index, (name, [measured, bound], label, scale)) in PANELS.into_iter().enumerate() {
            let left = 200.0 + 940.0 * index as f64;
            let all = [table.numbers(measured)?, table.numbers(bound)?].concat();
            let all: Vec<f64> = all.into_iter().map(|value| scale * value).collect();
            let low = all.iter().copied().fold(f64::INFINITY, f64::min);
            let high = all.iter().copied().fold(0.0, f64::max);
            let noise = table.numbers("snr_db")?;
            let axes = Axes::new(
                sheet,
                [left, 200.0, left + 720.0, 720.0],
                Axis::around(noise, 0.05, "echo over noise [dB]"),
                Axis::logarithmic(0.7 * low, 1.4 * high, label),
            );
            axes.grid()?;
            for (periods, colour) in periods.iter().zip(COLOURS) {
                let rows = table.only("periods", periods)?;
                let points = |column: &str| -> Result<Vec<(f64, f64)>> {
                    let values = rows
                        .numbers(column)?
                        .into_iter()
                        .map(|value| (scale * value).log10());
                    Ok(rows.numbers("snr_db")?.into_iter().zip(values).collect())
                };
                axes.curve(
                    &points(bound)?,
                    Stroke::solid(colour, 3.0).dashed(&[14.0, 8.0]),
                )?;
                axes.curve(&points(measured)?, Stroke::solid(colour, 4.0))?;
                axes.markers(&points(measured)?, Marker::Disc, 14.0, colour)?;
            }
            axes.finish(name)?;
        }
        let mut entries: Vec<Entry> = periods
            .iter()
            .zip(COLOURS)
            .map(|(periods, colour)| Entry {
                stroke: Some(Stroke::solid(colour, 4.0)),
                marker: Some((Marker::Disc, colour)),
                text: format!("M = {periods}"),
            })
            .collect();
        entries.push(Entry::line(
            Stroke::solid(colour::BLACK, 3.0).dashed(&[14.0, 8.0]),
            "Cram\u{e9}r-Rao bound",
        ));
        legend(sheet, [200.0, 90.0], 1650.0, &entries)?;
        Ok(())
    })
}
