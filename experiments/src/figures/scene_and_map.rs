//! Figure 4: walls and drive paths of the scene, and the map image that the mapping drive gave.

use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use super::drawing::canvas::{self, LABEL};
use super::drawing::colour;
use super::drawing::layout::{self, drive_points, path};
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::Stroke;
use crate::data::json;
use crate::data::layout::Layout;
use crate::data::table::Table;
use crate::metrics::quantile;

/// Positions of the pixels of `map.npy`, as written to `map.json` of the data folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct MapPlace {
    /// Centre of the pixel at row 0, column 0, metres.
    pub(crate) origin_m: [f64; 2],
    /// Width of a pixel, metres.
    pub(crate) cell_m: f64,
}

/// Quantiles of the pixels in the frame at which the colour scale begins and ends.
const CUT: [f64; 2] = [0.05, 0.995];

/// Shares of the `values` (of their maximum) below and above the ends of the colour scale.
fn cut_note(values: &[f64], scale: [f64; 2]) -> String {
    let share = |out: &dyn Fn(f64) -> bool| {
        let count = values.iter().filter(|value| out(**value)).count();
        100.0 * count as f64 / values.len().max(1) as f64
    };
    let (below, above) = (
        share(&|value| value < scale[0]),
        share(&|value| value > scale[1]),
    );
    let greatest = values.iter().copied().fold(0.0, f64::max);
    format!("colours end: {below:.1} % of pixels lower, {above:.1} % higher, to {greatest:.2}")
}

/// Draws the figure.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let layout = Layout::read(data)?;
    let drive = Table::read(&data.join("drive.csv"))?;
    let map_path = data.join("map.npy");
    let map: ndarray::Array2<f32> =
        ndarray_npy::read_npy(&map_path).with_context(|| map_path.display().to_string())?;
    let place_path = data.join("map.json");
    let place: MapPlace = json::read(&place_path)?;
    let tracks = [
        (
            "mapping",
            Stroke::solid(colour::GREEN, 3.5).dashed(&[16.0, 8.0]),
        ),
        ("localization", Stroke::solid(colour::BLUE, 5.0)),
    ];
    canvas::draw(picture, 1800, 1020, |sheet| {
        let title =
            "The scene, and the image of its walls from echoes at the known poses of a drive";
        sheet.title(title)?;
        let left = layout::axes(&layout, sheet, [120.0, 130.0, 810.0, 820.0]);
        left.grid()?;
        layout::layer(&layout, &left)?;
        layout::walls(&layout, &left, Stroke::solid(colour::BLACK, 7.0))?;
        for (name, stroke) in tracks {
            path(&left, &drive_points(&drive, name)?, stroke)?;
        }
        left.finish("(a) rigid walls and drives")?;
        let mut entries = vec![Entry {
            stroke: Some(Stroke::solid(colour::BLACK, 8.0)),
            marker: None,
            text: "wall".to_string(),
        }];
        entries.extend(tracks.map(|(name, stroke)| Entry {
            stroke: Some(stroke),
            marker: None,
            text: format!("{name} drive"),
        }));
        legend(sheet, [60.0, 925.0], 900.0, &entries)?;
        sheet.text(
            "\u{25cf} start   \u{25a0} end   light blue: absorbing layer",
            [60.0, 990.0],
            (1, 0),
            LABEL - 4.0,
            false,
            false,
        )?;

        let right = layout::axes(&layout, sheet, [935.0, 130.0, 1625.0, 820.0]);
        let (rows, columns) = map.dim();
        let low = place.origin_m.map(|origin| origin - 0.5 * place.cell_m);
        let spans = [
            [low[0], low[0] + columns as f64 * place.cell_m],
            [low[1], low[1] + rows as f64 * place.cell_m],
        ];
        // Only pixels within the frame count for the scale: the map reaches far beyond the room.
        let inside = |axis: usize, index: usize| {
            let centre = place.origin_m[axis] + index as f64 * place.cell_m;
            (0.0..=layout.size_m[axis]).contains(&centre)
        };
        let values: Vec<f64> = map
            .indexed_iter()
            .filter(|((iy, ix), _)| inside(0, *ix) && inside(1, *iy))
            .map(|(_, value)| f64::from(*value))
            .collect();
        let greatest = quantile(&values, 1.0).max(f64::MIN_POSITIVE);
        let values: Vec<f64> = values.iter().map(|value| value / greatest).collect();
        let shown = map.mapv(|value| (f64::from(value) / greatest) as f32);
        let scale = CUT.map(|share| quantile(&values, share));
        right.image(shown.view(), spans, scale)?;
        layout::walls(
            &layout,
            &right,
            Stroke::solid(plotters::style::WHITE, 3.0).dashed(&[10.0, 10.0]),
        )?;
        right.finish("(b) map image (dashed: true walls)")?;
        let lowest = quantile(&values, 0.0);
        let beyond = [lowest < scale[0], scale[1] < 1.0];
        right.colour_bar(scale, beyond, "reflected intensity / maximum")?;
        sheet.text(
            &cut_note(&values, scale),
            [1770.0, 947.0],
            (-1, 0),
            LABEL - 4.0,
            false,
            false,
        )
    })
}

#[cfg(test)]
mod tests {
    use super::cut_note;

    #[test]
    fn the_note_counts_the_pixels_beyond_the_scale() {
        assert_eq!(
            cut_note(&[0.0, 0.2, 0.3, 0.4, 1.0], [0.1, 0.4]),
            "colours end: 20.0 % of pixels lower, 20.0 % higher, to 1.00"
        );
    }
}
