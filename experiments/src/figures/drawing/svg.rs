//! A figure as a drawing (SVG): text stays text, and black and white follow the page's colours.

use std::fmt::Write;

use plotters::style::{RGBColor, WHITE};

use super::canvas::{Anchor, TITLE};
use super::colour;
use super::stroke::Stroke;

/// Height of DejaVu's capitals above the base line, as a share of the size, by which texts are centred.
const CAPITALS: f64 = 0.73;

/// The elements of a drawing.
#[derive(Debug, Default)]
pub(super) struct Svg {
    elements: String,
    title: String,
}

/// A colour: that of the page's ink, paper or grid where it means these.
fn paint(colour: RGBColor) -> String {
    let RGBColor(r, g, b) = colour;
    let plain = format!("#{r:02x}{g:02x}{b:02x}");
    let page = [
        (colour::BLACK, "ink"),
        (WHITE, "paper"),
        (colour::LIGHT, "grid"),
    ];
    match page.into_iter().find(|(known, _)| *known == colour) {
        Some((_, name)) => format!("var(--{name},{plain})"),
        None => plain,
    }
}

/// Text without letters that mean something else in XML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// Points as an attribute.
fn points(points: &[[f64; 2]]) -> String {
    let places: Vec<String> = points
        .iter()
        .filter(|point| point.iter().all(|place| place.is_finite()))
        .map(|[x, y]| format!("{x:.1},{y:.1}"))
        .collect();
    places.join(" ")
}

impl Svg {
    /// Adds an element. Writing into a text does not fail.
    fn add(&mut self, element: std::fmt::Arguments<'_>) {
        _ = writeln!(self.elements, "{element}");
    }

    /// A line through points.
    pub(super) fn line(&mut self, path: &[[f64; 2]], stroke: Stroke) {
        let dashes: Vec<String> = stroke.dashes.iter().map(f64::to_string).collect();
        let dashes = match dashes.is_empty() {
            true => String::new(),
            false => format!(";stroke-dasharray:{}", dashes.join(" ")),
        };
        self.add(format_args!(
            "<polyline points=\"{}\" style=\"fill:none;stroke:{};stroke-width:{};stroke-opacity:{}{dashes}\"/>",
            points(path),
            paint(stroke.colour),
            stroke.width,
            stroke.opacity,
        ));
    }

    /// A disc with a thin rim.
    pub(super) fn disc(&mut self, [x, y]: [f64; 2], radius: f64, colour: RGBColor) {
        self.add(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" style=\"fill:{};stroke:{};stroke-width:1.5\"/>",
            paint(colour),
            paint(WHITE),
        ));
    }

    /// A filled polygon.
    pub(super) fn area(&mut self, corners: &[[f64; 2]], colour: RGBColor, opacity: f64) {
        self.add(format_args!(
            "<polygon points=\"{}\" style=\"fill:{};fill-opacity:{opacity}\"/>",
            points(corners),
            paint(colour),
        ));
    }

    /// A text of a width and a size at a point; other fonts are set as wide.
    pub(super) fn text(
        &mut self,
        text: &str,
        [x, y]: [f64; 2],
        anchor: Anchor,
        [width, size]: [f64; 2],
        bold: bool,
        upward: bool,
    ) {
        if bold && size >= TITLE && self.title.is_empty() {
            self.title = text.to_string();
        }
        // Along the text and across it, before it is turned.
        let (along, across) = match upward {
            true => (-anchor.1, anchor.0),
            false => anchor,
        };
        let place = ["end", "middle", "start"][usize::from((along + 1) as u8).min(2)];
        let down = match across {
            -1 => -0.2 * size,
            0 => 0.5 * CAPITALS * size,
            _ => size,
        };
        let weight = if bold { ";font-weight:bold" } else { "" };
        let turn = if upward { " rotate(-90)" } else { "" };
        self.add(format_args!(
            "<text transform=\"translate({x:.1} {y:.1}){turn}\" y=\"{down:.1}\" text-anchor=\"{place}\" \
            textLength=\"{width:.0}\" lengthAdjust=\"spacingAndGlyphs\" style=\"fill:{};font-family:'DejaVu Sans',\
            sans-serif;font-size:{size}px{weight}\">{}</text>",
            paint(colour::BLACK),
            escaped(text),
        ));
    }

    /// The whole drawing.
    pub(super) fn document(&self, width: u32, height: u32) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
            aria-label=\"{}\">\n<!-- drawn by echolot -->\n{}</svg>\n",
            escaped(&self.title),
            self.elements
        )
    }
}
