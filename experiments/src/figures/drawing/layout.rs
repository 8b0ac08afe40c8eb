//! The plan of a scene in a figure: axes, absorbing layer, walls and drive paths.

use anyhow::Result;

use super::axes::Axes;
use super::axis::Axis;
use super::canvas::Canvas;
use super::colour;
use super::stroke::{Marker, Stroke};
use crate::data::layout::Layout;
use crate::data::table::Table;

/// Axes over the whole domain within `frame`.
pub fn axes<'a>(layout: &Layout, canvas: &'a Canvas, frame: [f64; 4]) -> Axes<'a> {
    let [width, height] = layout.size_m;
    Axes::equal(
        canvas,
        frame,
        Axis::new(0.0, width, "x [m]"),
        Axis::new(0.0, height, "y [m]"),
    )
}

/// Draws the walls.
///
/// # Errors
/// When the canvas refuses.
pub fn walls(layout: &Layout, axes: &Axes<'_>, stroke: Stroke) -> Result<()> {
    let metre = (axes.pixel(1.0, 0.0)[0] - axes.pixel(0.0, 0.0)[0]).abs();
    for wall in &layout.walls {
        let points: Vec<(f64, f64)> = wall
            .points_m
            .iter()
            .map(|point| (point[0], point[1]))
            .collect();
        let width = stroke.width.max(metre * wall.thickness_m);
        axes.curve(&points, Stroke { width, ..stroke })?;
    }
    Ok(())
}

/// Shades the absorbing layer.
///
/// # Errors
/// When the canvas refuses.
pub fn layer(layout: &Layout, axes: &Axes<'_>) -> Result<()> {
    let ([width, height], layer) = (layout.size_m, layout.layer_m);
    let bands = [
        [0.0, 0.0, width, layer],
        [0.0, height - layer, width, height],
        [0.0, layer, layer, height - layer],
        [width - layer, layer, width, height - layer],
    ];
    for [x0, y0, x1, y1] in bands {
        axes.area(&[(x0, y0), (x1, y0), (x1, y1), (x0, y1)], colour::SKY, 0.35)?;
    }
    Ok(())
}

/// The points of a drive path in `drive.csv`.
///
/// # Errors
/// When the table lacks the path or its columns.
pub fn drive_points(drive: &Table, path: &str) -> Result<Vec<(f64, f64)>> {
    let rows = drive.only("path", path)?;
    Ok(rows
        .numbers("x_m")?
        .into_iter()
        .zip(rows.numbers("y_m")?)
        .collect())
}

/// Draws a path with a disc at its start and a square at its end.
///
/// # Errors
/// When the canvas refuses.
pub fn path(axes: &Axes<'_>, points: &[(f64, f64)], stroke: Stroke) -> Result<()> {
    axes.curve(points, stroke)?;
    if let (Some(first), Some(last)) = (points.first(), points.last()) {
        axes.markers(&[*first], Marker::Disc, 20.0, stroke.colour)?;
        axes.markers(&[*last], Marker::Square, 17.0, stroke.colour)?;
    }
    Ok(())
}
