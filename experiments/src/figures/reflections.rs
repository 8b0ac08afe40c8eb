//! Figure 8: reflected intensity over time and round-trip distance beside the distances that ray theory gives.

use std::path::Path;

use anyhow::{Context, Result};
use ndarray::{Array2, ArrayView1, s};
use serde::{Deserialize, Serialize};

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas::{self, LABEL};
use super::drawing::colour;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::Marker;
use crate::data::json;
use crate::data::table::Table;
use crate::metrics::quantile;

/// Times and distances of the cells of `reflections.npy` (rows: time, columns: round-trip distance), as written to
/// `reflections.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct IntensityPlace {
    /// Times of the first and last row's outer edges, seconds.
    pub(crate) t_s: [f64; 2],
    /// Round-trip distances of the first and last column's outer edges, metres.
    pub(crate) range_m: [f64; 2],
}

/// Quantile of the cells that is the figure's 0 dB.
const REFERENCE: f64 = 0.9995;

/// Number of first columns without any intensity: echoes so near were not measured.
fn gated(image: &Array2<f32>) -> usize {
    let silent = |column: &ArrayView1<'_, f32>| column.iter().all(|value| *value == 0.0);
    image.columns().into_iter().take_while(silent).count()
}

/// Notes below the picture: the blank gate, and the level of 0 dB with the share of cells above it, in dB.
fn notes(gate_m: f64, levels: &[f64]) -> [String; 2] {
    let above = levels.iter().filter(|level| **level > 0.0).count();
    let greatest = levels.iter().copied().fold(0.0, f64::max);
    let share = 100.0 * above as f64 / levels.len().max(1) as f64;
    [
        format!("grey: gate, nothing measured below {gate_m:.2} m"),
        format!("0 dB: exceeded by {share:.2} % of the cells, by {greatest:.1} dB at most"),
    ]
}

/// Draws the figure.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let image_path = data.join("reflections.npy");
    let image: Array2<f32> =
        ndarray_npy::read_npy(&image_path).with_context(|| image_path.display().to_string())?;
    let place_path = data.join("reflections.json");
    let place: IntensityPlace = json::read(&place_path)?;
    let rays = Table::read(&data.join("rays.csv"))?;
    let [near_m, far_m] = place.range_m;
    let gate = gated(&image);
    let gate_m = near_m + (far_m - near_m) * gate as f64 / image.ncols().max(1) as f64;
    let values: Vec<f64> = image.iter().map(|value| f64::from(*value)).collect();
    let reference = quantile(&values, REFERENCE).max(f64::MIN_POSITIVE);
    let decibels =
        image.mapv(|value| (20.0 * (f64::from(value) / reference).max(1e-6).log10()) as f32);
    let decibels = decibels.slice(s![.., gate..]);
    let levels: Vec<f64> = decibels.iter().map(|level| f64::from(*level)).collect();
    let scale = [-30.0, 0.0];
    let beyond = [
        levels.iter().any(|level| *level < scale[0]),
        levels.iter().any(|level| *level > scale[1]),
    ];
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
    canvas::draw(picture, 1800, 1150, |sheet| {
        let title = format!(
            "Echoes measured and by ray theory: single ones and the corner's up to {farthest:.1} m"
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
        let [from, to] = place.t_s;
        let corners = [(near_m, from), (gate_m, from), (gate_m, to), (near_m, to)];
        measured.area(&corners, colour::LIGHT, 1.0)?;
        measured.image(decibels, [[gate_m, far_m], place.t_s], scale)?;
        measured.finish("(a) measured intensity")?;
        measured.colour_bar(scale, beyond, "level [dB]")?;
        for (note, y) in notes(gate_m, &levels).iter().zip([1085.0, 1120.0]) {
            sheet.text(note, [140.0, y], (1, 0), LABEL - 4.0, false, false)?;
        }
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

#[cfg(test)]
mod tests {
    use super::{gated, notes};

    #[test]
    fn the_notes_follow_from_the_image() {
        let image = ndarray::arr2(&[[0.0_f32, 0.0, 0.0, 1.0], [0.0, 0.0, 2.0, 0.0]]);
        assert_eq!(gated(&image), 2);
        let [gate, level] = notes(0.476, &[-3.0, 0.0, 4.25, -20.0]);
        assert_eq!(gate, "grey: gate, nothing measured below 0.48 m");
        assert_eq!(
            level,
            "0 dB: exceeded by 25.00 % of the cells, by 4.2 dB at most"
        );
    }
}
