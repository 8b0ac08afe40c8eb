//! A pair of axes: maps data to pixels, draws frame, ticks, labels, curves, and images with a colour bar.

use anyhow::Result;
use ndarray::ArrayView2;
use plotters::style::RGBColor;

use super::axis::Axis;
use super::canvas::{Canvas, LABEL, TICK};
use super::colour;
use super::stroke::{Marker, Stroke};

/// Axes in a rectangle of a canvas.
pub struct Axes<'a> {
    canvas: &'a Canvas,
    /// Left, top, right and bottom edge of the frame in pixels.
    pub frame: [f64; 4],
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
}

impl<'a> Axes<'a> {
    /// Axes whose frame fills `frame` (left, top, right, bottom).
    pub fn new(canvas: &'a Canvas, frame: [f64; 4], x: Axis, y: Axis) -> Self {
        Self {
            canvas,
            frame,
            x,
            y,
        }
    }

    /// Axes in `frame`, narrowed so that one unit is as long on both axes (maps).
    pub fn equal(canvas: &'a Canvas, frame: [f64; 4], x: Axis, y: Axis) -> Self {
        let [left, top, right, bottom] = frame;
        let scale = ((right - left) / (x.high - x.low)).min((bottom - top) / (y.high - y.low));
        let (width, height) = (scale * (x.high - x.low), scale * (y.high - y.low));
        let left = left + 0.5 * (right - left - width);
        let top = top + 0.5 * (bottom - top - height);
        Self::new(canvas, [left, top, left + width, top + height], x, y)
    }

    /// Pixel of a data point.
    pub fn pixel(&self, x: f64, y: f64) -> [f64; 2] {
        let [left, top, right, bottom] = self.frame;
        [
            left + (x - self.x.low) / (self.x.high - self.x.low) * (right - left),
            bottom - (y - self.y.low) / (self.y.high - self.y.low) * (bottom - top),
        ]
    }

    /// Whether a data point lies within both axes.
    pub fn holds(&self, x: f64, y: f64) -> bool {
        (self.x.low..=self.x.high).contains(&x) && (self.y.low..=self.y.high).contains(&y)
    }

    /// Draws light grid lines at the ticks; call before the data.
    ///
    /// # Errors
    /// When the canvas refuses.
    pub fn grid(&self) -> Result<()> {
        let [left, top, right, bottom] = self.frame;
        let stroke = Stroke::solid(colour::LIGHT, 1.5);
        for (value, _) in self.x.ticks(6) {
            let [x, _] = self.pixel(value, self.y.low);
            self.canvas.line(&[[x, top], [x, bottom]], stroke)?;
        }
        for (value, _) in self.y.ticks(6) {
            let [_, y] = self.pixel(self.x.low, value);
            self.canvas.line(&[[left, y], [right, y]], stroke)?;
        }
        Ok(())
    }

    /// As [`Axes::grid`], of the horizontal axis alone.
    ///
    /// # Errors
    /// When the canvas refuses.
    pub fn grid_upright(&self) -> Result<()> {
        let [_, top, _, bottom] = self.frame;
        for (value, _) in self.x.ticks(6) {
            let [x, _] = self.pixel(value, self.y.low);
            let stroke = Stroke::solid(colour::LIGHT, 1.5);
            self.canvas.line(&[[x, top], [x, bottom]], stroke)?;
        }
        Ok(())
    }

    /// Draws the frame's outline.
    fn outline(&self, stroke: Stroke) -> Result<()> {
        let [left, top, right, bottom] = self.frame;
        let corners = [
            [left, top],
            [right, top],
            [right, bottom],
            [left, bottom],
            [left, top],
        ];
        self.canvas.line(&corners, stroke)
    }

    /// Draws frame, ticks, axis labels and title; call after the data.
    ///
    /// # Errors
    /// When the canvas refuses.
    pub fn finish(&self, title: &str) -> Result<()> {
        self.finish_upright(title)?;
        let [left, top, _, bottom] = self.frame;
        let stroke = Stroke::solid(colour::BLACK, 2.5);
        let mut widest = 0.0_f64;
        for (value, text) in self.y.ticks(6) {
            let [_, y] = self.pixel(self.x.low, value);
            self.canvas.line(&[[left - 9.0, y], [left, y]], stroke)?;
            self.canvas
                .text(&text, [left - 15.0, y], (-1, 0), TICK, false, false)?;
            widest = widest.max(self.canvas.text_size(&text, TICK, false)[0]);
        }
        let beside = [left - 24.0 - widest, 0.5 * (top + bottom)];
        self.canvas
            .text(&self.y.label, beside, (-1, 0), LABEL, false, true)
    }

    /// As [`Axes::finish`], without what belongs to the upright axis: its rows have names of their own.
    ///
    /// # Errors
    /// When the canvas refuses.
    pub fn finish_upright(&self, title: &str) -> Result<()> {
        let [left, top, right, bottom] = self.frame;
        let stroke = Stroke::solid(colour::BLACK, 2.5);
        self.outline(stroke)?;
        for (value, text) in self.x.ticks(6) {
            let [x, _] = self.pixel(value, self.y.low);
            self.canvas
                .line(&[[x, bottom], [x, bottom + 9.0]], stroke)?;
            self.canvas
                .text(&text, [x, bottom + 14.0], (0, 1), TICK, false, false)?;
        }
        let middle = 0.5 * (left + right);
        let below = [middle, bottom + 20.0 + TICK];
        self.canvas
            .text(&self.x.label, below, (0, 1), LABEL, false, false)?;
        self.canvas
            .text(title, [middle, top - 14.0], (0, -1), LABEL, true, false)
    }

    /// Cuts a curve at the frame: its parts inside, in pixels.
    fn inside(&self, points: &[(f64, f64)]) -> Vec<Vec<[f64; 2]>> {
        let [left, top, right, bottom] = self.frame;
        let mut pieces: Vec<Vec<[f64; 2]>> = vec![Vec::new()];
        for pair in points.windows(2) {
            let from = self.pixel(pair[0].0, pair[0].1);
            let to = self.pixel(pair[1].0, pair[1].1);
            let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
            for (axis, low, high) in [(0, left, right), (1, top, bottom)] {
                let step = to[axis] - from[axis];
                if step.abs() < 1e-12 {
                    if from[axis] < low || from[axis] > high {
                        leave = -1.0;
                    }
                    continue;
                }
                let (a, b) = ((low - from[axis]) / step, (high - from[axis]) / step);
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            }
            let at = |share: f64| {
                [
                    from[0] + share * (to[0] - from[0]),
                    from[1] + share * (to[1] - from[1]),
                ]
            };
            let visible = enter <= leave && from.iter().chain(&to).all(|value| value.is_finite());
            match pieces.last_mut() {
                Some(piece) if visible => {
                    if piece.is_empty() {
                        piece.push(at(enter));
                    }
                    piece.push(at(leave));
                    if leave < 1.0 {
                        pieces.push(Vec::new());
                    }
                }
                _ => pieces.push(Vec::new()),
            }
        }
        pieces.retain(|piece| piece.len() > 1);
        pieces
    }

    /// Draws a curve, cut at the frame.
    ///
    /// # Errors
    /// When the canvas refuses.
    pub fn curve(&self, points: &[(f64, f64)], stroke: Stroke) -> Result<()> {
        self.inside(points)
            .iter()
            .try_for_each(|piece| self.canvas.line(piece, stroke))
    }

    /// Draws markers at the points inside the frame.
    ///
    /// # Errors
    /// When the canvas refuses.
    pub fn markers(
        &self,
        points: &[(f64, f64)],
        marker: Marker,
        size: f64,
        colour: RGBColor,
    ) -> Result<()> {
        let [left, top, right, bottom] = self.frame;
        for &(x, y) in points {
            let at = self.pixel(x, y);
            if at[0] >= left && at[0] <= right && at[1] >= top && at[1] <= bottom {
                self.canvas.marker(at, marker, size, colour)?;
            }
        }
        Ok(())
    }

    /// Draws upright bars from low to high at each x, cut at the frame.
    ///
    /// # Errors
    /// When the canvas refuses.
    pub fn whiskers(&self, intervals: &[(f64, f64, f64)], colour: RGBColor) -> Result<()> {
        let stroke = Stroke::solid(colour, 3.0);
        for &(x, low, high) in intervals {
            self.curve(&[(x, low), (x, high)], stroke)?;
            let cap = 0.006 * (self.x.high - self.x.low);
            for end in [low, high] {
                self.curve(&[(x - cap, end), (x + cap, end)], stroke)?;
            }
        }
        Ok(())
    }

    /// Fills the polygon of `corners` (data units), cut at the frame only by the caller's choice of corners.
    ///
    /// # Errors
    /// When the canvas refuses.
    pub fn area(&self, corners: &[(f64, f64)], colour: RGBColor, opacity: f64) -> Result<()> {
        let pixels: Vec<[f64; 2]> = corners.iter().map(|&(x, y)| self.pixel(x, y)).collect();
        self.canvas.area_between(&pixels, colour, opacity)
    }

    /// Draws an image `[iy, ix]` (y upward) that spans `x_range` by `y_range`, black-violet at `low` to yellow at
    /// `high`.
    ///
    /// # Errors
    /// When the canvas refuses.
    pub fn image(
        &self,
        image: ArrayView2<'_, f32>,
        spans: [[f64; 2]; 2],
        scale: [f64; 2],
    ) -> Result<()> {
        self.shaded(image, spans, &|value| {
            colour::ramp((value - scale[0]) / (scale[1] - scale[0]))
        })
    }

    /// Draws an image as [`Axes::image`] does, with any colours.
    ///
    /// # Errors
    /// When the canvas refuses.
    pub fn shaded(
        &self,
        image: ArrayView2<'_, f32>,
        spans: [[f64; 2]; 2],
        shade: &dyn Fn(f64) -> RGBColor,
    ) -> Result<()> {
        let (rows, columns) = image.dim();
        let [[x0, x1], [y0, y1]] = spans;
        let [left, top, right, bottom] = self.frame;
        for py in top.round() as i32..bottom.round() as i32 {
            for px in left.round() as i32..right.round() as i32 {
                let (fx, fy) = (f64::from(px) + 0.5, f64::from(py) + 0.5);
                let x = self.x.low + (fx - left) / (right - left) * (self.x.high - self.x.low);
                let y = self.y.high - (fy - top) / (bottom - top) * (self.y.high - self.y.low);
                let ix = (x - x0) / (x1 - x0) * columns as f64;
                let iy = (y - y0) / (y1 - y0) * rows as f64;
                if ix >= 0.0 && iy >= 0.0 && ix < columns as f64 && iy < rows as f64 {
                    let value = f64::from(image[[iy as usize, ix as usize]]);
                    let (px, py) = (f64::from(px), f64::from(py));
                    self.canvas
                        .rectangle([px, py, px + 1.0, py + 1.0], shade(value), 1.0);
                }
            }
        }
        Ok(())
    }

    /// Draws a colour bar right of the frame. A tip at its lower or upper end marks that the image has values `beyond`
    /// the scale there, drawn in the colour of that end.
    ///
    /// # Errors
    /// When the canvas refuses.
    pub fn colour_bar(&self, scale: [f64; 2], beyond: [bool; 2], label: &str) -> Result<()> {
        let [_, top, right, bottom] = self.frame;
        let bar = Axes::new(
            self.canvas,
            [right + 24.0, top, right + 54.0, bottom],
            Axis::new(0.0, 1.0, ""),
            Axis::new(scale[0], scale[1], ""),
        );
        let [left, _, right, _] = bar.frame;
        for row in top as i32..bottom as i32 {
            let share = (bottom - f64::from(row) - 0.5) / (bottom - top);
            let edges = [left, f64::from(row), right, f64::from(row + 1)];
            self.canvas.rectangle(edges, colour::ramp(share), 1.0);
        }
        let stroke = Stroke::solid(colour::BLACK, 2.0);
        bar.outline(stroke)?;
        for (beyond, share, base, tip) in [
            (beyond[0], 0.0, bottom, bottom + 26.0),
            (beyond[1], 1.0, top, top - 26.0),
        ] {
            if beyond {
                let corners = [[left, base], [right, base], [0.5 * (left + right), tip]];
                self.canvas
                    .area_between(&corners, colour::ramp(share), 1.0)?;
                let [from, to, tip] = corners;
                self.canvas.line(&[from, tip, to], stroke)?;
            }
        }
        let mut widest = 0.0_f64;
        for (value, text) in bar.y.ticks(5) {
            let [_, y] = bar.pixel(0.0, value);
            self.canvas.line(&[[right, y], [right + 8.0, y]], stroke)?;
            self.canvas
                .text(&text, [right + 13.0, y], (1, 0), TICK, false, false)?;
            widest = widest.max(self.canvas.text_size(&text, TICK, false)[0]);
        }
        let beside = [right + 28.0 + widest, 0.5 * (top + bottom)];
        self.canvas.text(label, beside, (1, 0), LABEL, false, true)
    }
}
