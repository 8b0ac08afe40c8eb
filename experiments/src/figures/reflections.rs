//! Figure 8: reflected intensity over time and round-trip distance beside the distances that ray theory gives.

use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use super::axes::Axes;
use super::axis::Axis;
use super::canvas::{self, Marker};
use super::colour;
use super::legend::{Entry, legend};
use crate::metrics::quantile;
use crate::table::Table;

/// Where the cells of `reflections.npy` (rows: time, columns: round-trip distance) lie, as written to `reflections.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct IntensityPlace {
    /// Times of the first and last row's outer edges, seconds.
    pub(crate) t_s: [f64; 2],
    /// Round-trip distances of the first and last column's outer edges, metres.
    pub(crate) range_m: [f64; 2],
}

/// Draws the figure.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let image_path = data.join("reflections.npy");
    let image: ndarray::Array2<f32> =
        ndarray_npy::read_npy(&image_path).with_context(|| image_path.display().to_string())?;
    let place_path = data.join("reflections.json");
    let place: IntensityPlace = serde_json::from_str(&std::fs::read_to_string(&place_path)?)
        .with_context(|| place_path.display().to_string())?;
    let rays = Table::read(&data.join("rays.csv"))?;
    let values: Vec<f64> = image.iter().map(|value| f64::from(*value)).collect();
    let reference = quantile(&values, 0.9995).max(f64::MIN_POSITIVE);
    let decibels =
        image.mapv(|value| (20.0 * (f64::from(value) / reference).max(1e-6).log10()) as f32);
    let scale = [-30.0, 0.0];
    let kinds = [
        ("double", colour::GREY, "double reflection"),
        ("corner", colour::PURPLE, "corner"),
        ("single", colour::VERMILLION, "single reflection"),
    ];
    let farthest = rays
        .only("kind", "single")?
        .numbers("round_trip_m")?
        .into_iter()
        .chain(rays.only("kind", "corner")?.numbers("round_trip_m")?)
        .fold(0.0, f64::max);
    canvas::draw(picture, 1800, 1100, |sheet| {
        let title = format!(
            "The echoes are the walls' and the corner's; eq. (3) holds for those up to {farthest:.1} m"
        );
        sheet.title(&title)?;
        let axis = |label| Axis::new(0.0, 10.0, label);
        let time = Axis::new(0.0, place.t_s[1], "time [s]");
        let measured = Axes::new(
            sheet,
            [140.0, 190.0, 780.0, 980.0],
            axis("round-trip distance [m]"),
            time.clone(),
        );
        measured.image(decibels.view(), [place.range_m, place.t_s], scale)?;
        measured.finish("(a) measured intensity")?;
        measured.colour_bar(scale, "level [dB]")?;
        let theory = Axes::new(
            sheet,
            [1100.0, 190.0, 1740.0, 980.0],
            axis("round-trip distance [m]"),
            time,
        );
        theory.grid()?;
        let row = (theory.frame[3] - theory.frame[1]) / image.nrows().max(1) as f64;
        let half = 0.5 * row.max(4.0) + 0.5;
        for (kind, shade, _) in kinds {
            let rows = rays.only("kind", kind)?;
            for (range_m, t_s) in rows
                .numbers("round_trip_m")?
                .into_iter()
                .zip(rows.numbers("t_s")?)
            {
                if range_m <= theory.x.high && t_s <= theory.y.high {
                    let [x, y] = theory.pixel(range_m, t_s);
                    sheet.rectangle([x - 2.5, y - half, x + 2.5, y + half], shade, 1.0);
                }
            }
        }
        theory.finish("(b) ray theory")?;
        let entries = kinds.map(|(_, shade, text)| Entry {
            stroke: None,
            marker: Some((Marker::Square, shade)),
            text: text.to_string(),
        });
        legend(sheet, [830.0, 80.0], 960.0, &entries)?;
        Ok(())
    })
}
