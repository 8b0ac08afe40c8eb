//! A map image under the true walls.

use anyhow::Result;
use ndarray::Array2;

use super::drawing::canvas::{Canvas, LABEL};
use super::drawing::layout;
use super::drawing::stroke::Stroke;
use crate::data::layout::Layout;
use crate::data::map_place::MapPlace;
use crate::metrics::quantile;

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

/// Draws a map image and the true walls into a frame, with its colour bar and a note below that ends at `note_at`.
///
/// # Errors
/// When the canvas refuses.
pub(super) fn draw(
    (map, place): (&Array2<f32>, &MapPlace),
    layout: &Layout,
    sheet: &Canvas,
    (frame, note_at): ([f64; 4], [f64; 2]),
    name: &str,
) -> Result<()> {
    let axes = layout::axes(layout, sheet, frame);
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
    axes.image(shown.view(), spans, scale)?;
    layout::walls(
        layout,
        &axes,
        Stroke::solid(plotters::style::WHITE, 3.0).dashed(&[10.0, 10.0]),
    )?;
    axes.finish(name)?;
    let lowest = quantile(&values, 0.0);
    let beyond = [lowest < scale[0], scale[1] < 1.0];
    axes.colour_bar(scale, beyond, "reflected intensity / maximum")?;
    let note = cut_note(&values, scale);
    sheet.text(&note, note_at, (-1, 0), LABEL - 4.0, false, false)
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
