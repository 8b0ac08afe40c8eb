//! Legends: samples of lines and markers with their names, in rows.

use anyhow::Result;
use plotters::style::RGBColor;

use super::canvas::{Canvas, LABEL};
use super::stroke::{Marker, Stroke};

/// An entry of a legend.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Style of the line; `None` for no line.
    pub stroke: Option<Stroke>,
    /// Its marker and colour.
    pub marker: Option<(Marker, RGBColor)>,
    /// Name of the curve.
    pub text: String,
}

impl Entry {
    /// An entry for a line.
    pub fn line(stroke: Stroke, text: &str) -> Self {
        Self {
            stroke: Some(stroke),
            marker: None,
            text: text.to_string(),
        }
    }
}

/// Length of a sample, and the distances to its text and to the next entry.
const SAMPLE: f64 = 78.0;
const GAP: f64 = 14.0;
const BETWEEN: f64 = 46.0;
const ROW: f64 = LABEL + 13.0;

/// Draws a legend in rows from `at` (upper left), at most `width` pixels wide; returns its height.
///
/// # Errors
/// When the canvas refuses.
pub fn legend(canvas: &Canvas, at: [f64; 2], width: f64, entries: &[Entry]) -> Result<f64> {
    let (mut x, mut y) = (at[0], at[1]);
    for entry in entries {
        let extent = extent(canvas, entry);
        if x > at[0] && x + extent > at[0] + width {
            (x, y) = (at[0], y + ROW);
        }
        draw(canvas, [x, y], entry)?;
        x += extent + BETWEEN;
    }
    Ok(y + ROW - at[1])
}

/// As [`legend`], in as many columns as fit: many entries are easier to find so.
///
/// # Errors
/// As [`legend`].
pub fn legend_in_columns(
    canvas: &Canvas,
    at: [f64; 2],
    width: f64,
    entries: &[Entry],
) -> Result<f64> {
    let extents = entries.iter().map(|entry| extent(canvas, entry));
    let column = extents.fold(0.0, f64::max) + BETWEEN;
    let columns = ((width + BETWEEN) / column).floor().max(1.0) as usize;
    for (number, entry) in entries.iter().enumerate() {
        let [x, y] = [number % columns, number / columns].map(|count| count as f64);
        draw(canvas, [at[0] + x * column, at[1] + y * ROW], entry)?;
    }
    Ok(entries.len().div_ceil(columns) as f64 * ROW)
}

/// Width of an entry in pixels.
fn extent(canvas: &Canvas, entry: &Entry) -> f64 {
    SAMPLE + GAP + canvas.text_size(&entry.text, LABEL, false)[0]
}

/// Draws one entry from its upper left.
fn draw(canvas: &Canvas, [x, y]: [f64; 2], entry: &Entry) -> Result<()> {
    let middle = y + 0.5 * ROW;
    if let Some(stroke) = entry.stroke {
        // A wide line's round ends stay within the sample.
        let inset = 0.5 * stroke.width;
        canvas.line(&[[x + inset, middle], [x + SAMPLE - inset, middle]], stroke)?;
    }
    if let Some((marker, colour)) = entry.marker {
        canvas.marker([x + 0.5 * SAMPLE, middle], marker, 17.0, colour)?;
    }
    let place = [x + SAMPLE + GAP, middle];
    canvas.text(&entry.text, place, (1, 0), LABEL, false, false)
}
