//! Styles of lines and markers.

use plotters::style::RGBColor;

/// Style of a line.
#[derive(Debug, Clone, Copy)]
pub struct Stroke {
    /// Colour.
    pub colour: RGBColor,
    /// Width in pixels.
    pub width: f64,
    /// Lengths of dash, gap, dash, gap, ... in pixels; empty for a solid line.
    pub dashes: &'static [f64],
    /// 1 is opaque.
    pub opacity: f64,
}

impl Stroke {
    /// A solid, opaque line.
    pub const fn solid(colour: RGBColor, width: f64) -> Self {
        Self {
            colour,
            width,
            dashes: &[],
            opacity: 1.0,
        }
    }

    /// The same line dashed.
    pub const fn dashed(self, dashes: &'static [f64]) -> Self {
        Self { dashes, ..self }
    }

    /// The same line, see-through.
    pub const fn faint(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }
}

/// Shape of a data point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// A disc.
    Disc,
    /// A square.
    Square,
    /// A triangle, tip up.
    Triangle,
    /// A diamond.
    Diamond,
    /// The outline of a square, through which other points stay visible.
    OpenSquare,
    /// The outline of a triangle, tip up.
    OpenTriangle,
    /// The outline of a diamond.
    OpenDiamond,
}
