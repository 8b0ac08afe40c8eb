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

/// Draws a legend in rows from `at` (upper left), at most `width` pixels wide; returns its height.
///
/// # Errors
/// When the canvas refuses.
pub fn legend(canvas: &Canvas, at: [f64; 2], width: f64, entries: &[Entry]) -> Result<f64> {
    const SAMPLE: f64 = 78.0;
    let row = LABEL + 13.0;
    let (mut x, mut y) = (at[0], at[1]);
    for entry in entries {
        let extent = SAMPLE + 14.0 + canvas.text_size(&entry.text, LABEL, false)[0];
        if x > at[0] && x + extent > at[0] + width {
            (x, y) = (at[0], y + row);
        }
        let middle = y + 0.5 * row;
        if let Some(stroke) = entry.stroke {
            // A wide line's round ends stay within the sample.
            let inset = 0.5 * stroke.width;
            canvas.line(&[[x + inset, middle], [x + SAMPLE - inset, middle]], stroke)?;
        }
        if let Some((marker, colour)) = entry.marker {
            canvas.marker([x + 0.5 * SAMPLE, middle], marker, 17.0, colour)?;
        }
        canvas.text(
            &entry.text,
            [x + SAMPLE + 14.0, middle],
            (1, 0),
            LABEL,
            false,
            false,
        )?;
        x += extent + 46.0;
    }
    Ok(y + row - at[1])
}
