//! The sheet a figure is drawn on: smooth lines, markers, areas and text in pixels, saved as PNG or SVG.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Once;

use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, FontTransform, register_font};

use super::png::write_png;
use super::stroke::{Marker, Stroke};
use super::svg::Svg;
use crate::data::atomic;

static REGULAR: &[u8] = include_bytes!("../../../assets/DejaVuSans.ttf");
static BOLD: &[u8] = include_bytes!("../../../assets/DejaVuSans-Bold.ttf");

/// Size of tick labels in pixels.
pub const TICK: f64 = 28.0;
/// Size of axis labels and legends in pixels.
pub const LABEL: f64 = 31.0;
/// Size of titles in pixels.
pub const TITLE: f64 = 37.0;

/// Least distance of a title from the picture's edges in pixels.
const MARGIN: f64 = 20.0;

/// Place of a text relative to its point: -1 left of / above it, 0 centred, 1 right of / below it.
pub type Anchor = (i8, i8);

/// A drawing surface of `width` x `height` pixels, origin at the upper left.
pub struct Canvas {
    pixels: RefCell<Vec<u8>>,
    coverage: RefCell<HashMap<(i32, i32), f32>>,
    /// The elements of a drawing, where it becomes one.
    vector: Option<RefCell<Svg>>,
    /// Width in pixels.
    pub width: f64,
    /// Height in pixels.
    pub height: f64,
}

/// Draws a figure of `width` x `height` pixels into `path`, which is replaced only when all went well: as SVG where the
/// name ends so, else as PNG.
///
/// # Errors
/// The error of `paint`, or when the file cannot be written.
pub fn draw(
    path: &Path,
    width: u32,
    height: u32,
    paint: impl FnOnce(&Canvas) -> Result<()>,
) -> Result<()> {
    static FONTS: Once = Once::new();
    FONTS.call_once(|| {
        for (style, bytes) in [(FontStyle::Normal, REGULAR), (FontStyle::Bold, BOLD)] {
            // A font that does not load shows as an error of the first text.
            _ = register_font("sans-serif", style, bytes);
        }
    });
    let is_svg = path.extension().is_some_and(|ending| ending == "svg");
    let pixels = if is_svg { 0 } else { width * height * 3 };
    let canvas = Canvas {
        pixels: RefCell::new(vec![255_u8; pixels as usize]),
        coverage: RefCell::default(),
        vector: is_svg.then(RefCell::default),
        width: f64::from(width),
        height: f64::from(height),
    };
    paint(&canvas)?;
    if let Some(vector) = &canvas.vector {
        let text = vector.borrow().document(width, height);
        return atomic::write(path, text.as_bytes());
    }
    write_png(path, width, height, &canvas.pixels.borrow())
}

impl Canvas {
    /// Lets the backend draw into the picture.
    fn with_backend<E: std::fmt::Display>(
        &self,
        act: impl FnOnce(&DrawingArea<BitMapBackend<'_>, Shift>) -> Result<(), E>,
    ) -> Result<()> {
        let mut pixels = self.pixels.borrow_mut();
        let size = (self.width as u32, self.height as u32);
        let area = BitMapBackend::with_buffer(pixels.as_mut_slice(), size).into_drawing_area();
        act(&area).map_err(|error| anyhow!("{error}"))
    }

    /// Mixes a colour into one pixel; outside the picture nothing happens.
    fn mix(&self, (x, y): (i32, i32), colour: RGBColor, opacity: f64) {
        if x < 0 || y < 0 || f64::from(x) >= self.width || f64::from(y) >= self.height {
            return;
        }
        let at = 3 * (y as usize * self.width as usize + x as usize);
        let RGBColor(r, g, b) = colour;
        let mut pixels = self.pixels.borrow_mut();
        for (byte, wanted) in pixels[at..at + 3].iter_mut().zip([r, g, b]) {
            let mixed = f64::from(*byte) + opacity * (f64::from(wanted) - f64::from(*byte));
            *byte = mixed.round() as u8;
        }
    }

    /// Mixes the collected coverage into the picture, each pixel once, so that a see-through line does not darken
    /// itself.
    fn flush(&self, colour: RGBColor, opacity: f64) {
        for (pixel, share) in self.coverage.borrow_mut().drain() {
            self.mix(pixel, colour, f64::from(share) * opacity);
        }
    }

    /// Covers the pixels within `radius` of the segment `from`-`to`, the border pixels in part.
    fn cover_segment(&self, from: [f64; 2], to: [f64; 2], radius: f64) {
        let mut coverage = self.coverage.borrow_mut();
        let reach = radius + 1.0;
        let range = |a: f64, b: f64, end: f64| {
            let low = (a.min(b) - reach).floor().clamp(0.0, end);
            let high = (a.max(b) + reach).ceil().clamp(-1.0, end);
            (low as i32, high as i32)
        };
        let (x0, x1) = range(from[0], to[0], self.width - 1.0);
        let (y0, y1) = range(from[1], to[1], self.height - 1.0);
        let along = [to[0] - from[0], to[1] - from[1]];
        let length2 = along[0] * along[0] + along[1] * along[1];
        for y in y0..=y1 {
            for x in x0..=x1 {
                let point = [f64::from(x) + 0.5 - from[0], f64::from(y) + 0.5 - from[1]];
                let share = if length2 > 0.0 {
                    ((point[0] * along[0] + point[1] * along[1]) / length2).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let distance = (point[0] - share * along[0]).hypot(point[1] - share * along[1]);
                let covered = (radius + 0.5 - distance).clamp(0.0, 1.0) as f32;
                if covered > 0.0 {
                    let cell = coverage.entry((x, y)).or_insert(0.0);
                    *cell = cell.max(covered);
                }
            }
        }
    }

    /// Draws a line through `points`.
    ///
    /// # Errors
    /// None at present; a backend that draws lines itself may refuse.
    pub fn line(&self, points: &[[f64; 2]], stroke: Stroke) -> Result<()> {
        if let Some(vector) = &self.vector {
            vector.borrow_mut().line(points, stroke);
            return Ok(());
        }
        let radius = 0.5 * stroke.width;
        let mut dash = 0;
        let mut left = stroke.dashes.first().copied().unwrap_or(f64::INFINITY);
        for pair in points.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            if !length.is_finite() {
                continue;
            }
            let at = |share: f64| {
                [
                    from[0] + share * (to[0] - from[0]),
                    from[1] + share * (to[1] - from[1]),
                ]
            };
            let mut done = 0.0;
            while done < length {
                let piece = left.min(length - done);
                if dash % 2 == 0 {
                    self.cover_segment(at(done / length), at((done + piece) / length), radius);
                }
                done += piece;
                left -= piece;
                if left <= 0.0 {
                    dash += 1;
                    left = stroke.dashes[dash % stroke.dashes.len()].max(0.5);
                }
            }
        }
        self.flush(stroke.colour, stroke.opacity);
        Ok(())
    }

    /// Draws a marker `size` pixels across: filled ones with a thin white rim, open ones as a line.
    ///
    /// # Errors
    /// When the backend refuses.
    pub fn marker(&self, at: [f64; 2], marker: Marker, size: f64, colour: RGBColor) -> Result<()> {
        let radius = 0.5 * size;
        let corner = |angle_deg: f64, reach: f64| {
            let angle = angle_deg.to_radians();
            [at[0] + reach * angle.cos(), at[1] - reach * angle.sin()]
        };
        if let (Marker::Disc, Some(vector)) = (marker, &self.vector) {
            vector.borrow_mut().disc(at, radius, colour);
            return Ok(());
        }
        let corners: Vec<[f64; 2]> = match marker {
            Marker::Disc => {
                self.cover_segment(at, at, radius + 1.5);
                self.flush(WHITE, 1.0);
                self.cover_segment(at, at, radius);
                self.flush(colour, 1.0);
                return Ok(());
            }
            Marker::Square | Marker::OpenSquare => [45.0, 135.0, 225.0, 315.0]
                .map(|a| corner(a, 1.25 * radius))
                .to_vec(),
            Marker::Triangle | Marker::OpenTriangle => [90.0, 210.0, 330.0]
                .map(|a| corner(a, 1.35 * radius))
                .to_vec(),
            Marker::Diamond | Marker::OpenDiamond => [0.0, 90.0, 180.0, 270.0]
                .map(|a| corner(a, 1.3 * radius))
                .to_vec(),
        };
        let mut outline = corners.clone();
        outline.push(corners[0]);
        if matches!(
            marker,
            Marker::OpenSquare | Marker::OpenTriangle | Marker::OpenDiamond
        ) {
            return self.line(&outline, Stroke::solid(colour, 3.5));
        }
        self.line(&outline, Stroke::solid(WHITE, 4.0))?;
        self.area_between(&corners, colour, 1.0)?;
        self.line(&outline, Stroke::solid(colour, 1.5))
    }

    /// Fills a polygon.
    ///
    /// # Errors
    /// When the backend refuses.
    pub fn area_between(&self, corners: &[[f64; 2]], colour: RGBColor, opacity: f64) -> Result<()> {
        if let Some(vector) = &self.vector {
            vector.borrow_mut().area(corners, colour, opacity);
            return Ok(());
        }
        let points: Vec<(i32, i32)> = corners
            .iter()
            .map(|point| (point[0].round() as i32, point[1].round() as i32))
            .collect();
        self.with_backend(|area| area.draw(&Polygon::new(points, colour.mix(opacity).filled())))
    }

    /// Fills a rectangle given by its left, top, right and bottom edge.
    pub fn rectangle(&self, edges: [f64; 4], colour: RGBColor, opacity: f64) {
        if let Some(vector) = &self.vector {
            let [left, top, right, bottom] = edges;
            let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
            vector.borrow_mut().area(&corners, colour, opacity);
            return;
        }
        let [left, top, right, bottom] = edges.map(|edge| edge.round() as i32);
        for y in top..bottom {
            for x in left..right {
                self.mix((x, y), colour, opacity);
            }
        }
    }

    /// Width and height in pixels that `text` takes at `size`.
    pub fn text_size(&self, text: &str, size: f64, bold: bool) -> [f64; 2] {
        let style = style(size, bold);
        let width = style
            .font
            .layout_box(text)
            .map_or(0, |((left, _), (right, _))| right - left);
        [f64::from(width), size]
    }

    /// Writes the picture's title.
    ///
    /// # Errors
    /// When the backend refuses.
    pub fn title(&self, text: &str) -> Result<()> {
        let size = self.size_within(text, TITLE, true, self.width - 2.0 * MARGIN);
        self.text(text, [0.5 * self.width, 20.0], (0, 1), size, true, false)
    }

    /// The size, at most `size`, in which a text is at most so wide.
    fn size_within(&self, text: &str, size: f64, bold: bool, width: f64) -> f64 {
        let [own, _] = self.text_size(text, size, bold);
        size * (width / own.max(1.0)).min(1.0)
    }

    /// Writes `text` at a point; `upward` turns it to read from bottom to top.
    ///
    /// # Errors
    /// When the backend refuses.
    pub fn text(
        &self,
        text: &str,
        at: [f64; 2],
        anchor: Anchor,
        size: f64,
        bold: bool,
        upward: bool,
    ) -> Result<()> {
        let mut font = style(size, bold);
        let [width, height] = self.text_size(text, size, bold);
        if let Some(vector) = &self.vector {
            vector
                .borrow_mut()
                .text(text, at, anchor, [width, size], bold, upward);
            return Ok(());
        }
        let [along, across] = if upward {
            [height, width]
        } else {
            [width, height]
        };
        let shift = |extent: f64, anchor: i8| extent * 0.5 * (f64::from(anchor) - 1.0);
        let (mut left, mut top) = (
            at[0] + shift(along, anchor.0),
            at[1] + shift(across, anchor.1),
        );
        // The ink of letters and digits lies in the upper part of the line box.
        if upward && anchor.0 == 0 {
            left += 0.18 * size;
        } else if !upward && anchor.1 == 0 {
            top += 0.18 * size;
        }
        let place = if upward {
            font.font = font.font.transform(FontTransform::Rotate270);
            (left, top + across)
        } else {
            (left, top)
        };
        let place = (place.0.round() as i32, place.1.round() as i32);
        self.with_backend(|area| area.draw(&Text::new(text.to_string(), place, font)))
    }
}

/// Text style of the figures.
fn style(size: f64, bold: bool) -> TextStyle<'static> {
    let weight = if bold {
        FontStyle::Bold
    } else {
        FontStyle::Normal
    };
    ("sans-serif", size, weight).into_font().color(&BLACK)
}
