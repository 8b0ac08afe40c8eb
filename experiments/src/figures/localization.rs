//! A picture of a localization: path, truth and wheels over the map, error and fit over time.

use std::path::Path;

use anyhow::Result;
use localizer::landmarks::LandmarkMap;
use localizer::{MapImage, Trajectory};
use plotters::style::RGBColor;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas;
use super::drawing::colour;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::{Marker, Stroke};

/// Space around the paths, in metres.
const MARGIN_M: f64 = 1.5;

/// Parts in which a wall is drawn.
const PARTS: u32 = 200;

/// The map under the paths.
pub enum Background<'a> {
    /// Echo images.
    Image(&'a MapImage),
    /// Walls as far as they were seen, and points.
    Landmarks(&'a LandmarkMap),
}

/// What is drawn; times are those of the sound.
pub struct Localization<'a> {
    /// The map.
    pub map: Background<'a>,
    /// Estimated poses.
    pub path: &'a Trajectory,
    /// True poses, if known.
    pub truth: Option<&'a Trajectory>,
    /// The path by wheels alone.
    pub wheels: &'a Trajectory,
    /// How well the echoes fit, one per estimated pose.
    pub fit: &'a [f64],
    /// Label of its axis, and title of its panel.
    pub fit_label: [&'a str; 2],
}

/// Draws the picture.
///
/// # Errors
/// When it cannot be written.
pub fn draw(shown: &Localization<'_>, picture: &Path) -> Result<()> {
    let estimate = Stroke::solid(colour::BLUE, 4.0);
    let truth = Stroke::solid(colour::BLACK, 3.0).dashed(&[14.0, 8.0]);
    let wheels = Stroke::solid(colour::VERMILLION, 3.5).dashed(&[20.0, 10.0]);
    let places = |path: &Trajectory| -> Vec<(f64, f64)> {
        path.poses.iter().map(|pose| (pose.x_m, pose.y_m)).collect()
    };
    let mut curves = vec![(places(shown.wheels), wheels, "wheels alone")];
    // The truth while the robot was heard.
    let heard = shown
        .truth
        .map(|path| path.poses_at(shown.path.t_s.iter().copied()));
    if let Some(poses) = &heard {
        let points = poses.iter().map(|pose| (pose.x_m, pose.y_m)).collect();
        curves.push((points, truth, "truth"));
    }
    curves.push((places(shown.path), estimate, "estimate"));
    let all = || curves.iter().flat_map(|(points, ..)| points.iter());
    let span = |of: fn(&(f64, f64)) -> f64, label: &str| {
        let mut axis = Axis::around(all().map(of), 0.0, label);
        (axis.low, axis.high) = (axis.low - MARGIN_M, axis.high + MARGIN_M);
        axis
    };
    let errors: Vec<(f64, f64)> = heard
        .iter()
        .flat_map(|poses| poses.iter().zip(&shown.path.poses).zip(&shown.path.t_s))
        .map(|((truth, pose), &t_s)| (t_s, pose.distance_m(truth)))
        .collect();
    let end = shown.path.t_s.last().copied().unwrap_or(1.0);
    canvas::draw(picture, 1900, 1100, |sheet| {
        sheet.title("The robot's path by its echoes")?;
        let frame = [150.0, 130.0, 1010.0, 990.0];
        let axes = Axes::equal(sheet, frame, span(|p| p.0, "x [m]"), span(|p| p.1, "y [m]"));
        match shown.map {
            Background::Image(map) => image(&axes, map)?,
            Background::Landmarks(map) => landmarks(&axes, map)?,
        }
        for (points, stroke, _) in &curves {
            axes.curve(points, *stroke)?;
        }
        axes.finish("(a) paths over the map")?;
        let fit: Vec<(f64, f64)> = shown
            .path
            .t_s
            .iter()
            .copied()
            .zip(shown.fit.iter().copied())
            .collect();
        for (row, points, label, name) in [
            (0, &errors, "error [m]", "(b) distance from the truth"),
            (1, &fit, shown.fit_label[0], shown.fit_label[1]),
        ] {
            let top = 130.0 + 450.0 * f64::from(row);
            let frame = [1190.0, top, 1850.0, top + 330.0];
            let high = points
                .iter()
                .fold(1e-3, |high: f64, point| high.max(point.1));
            let axes = Axes::new(
                sheet,
                frame,
                Axis::new(0.0, end, "time [s]"),
                Axis::new(0.0, 1.1 * high, label),
            );
            axes.grid()?;
            axes.curve(points, estimate)?;
            axes.finish(name)?;
        }
        let entries: Vec<Entry> = curves
            .iter()
            .map(|(_, stroke, name)| Entry::line(*stroke, name))
            .collect();
        legend(sheet, [150.0, 1050.0], 900.0, &entries)?;
        Ok(())
    })
}

/// The map's image, dark where echoes come from.
fn image(axes: &Axes<'_>, map: &MapImage) -> Result<()> {
    let layer = &map.intensity;
    let largest = f64::from(layer.iter().copied().fold(0.0_f32, f32::max)).max(1e-12);
    let [x_m, y_m] = map.origin_m();
    let half = 0.5 * map.cell_m;
    let (rows, columns) = layer.dim();
    let reach = |first: f64, cells: usize| [first - half, first - half + cells as f64 * map.cell_m];
    axes.shaded(
        layer.view(),
        [reach(x_m, columns), reach(y_m, rows)],
        &|value| {
            let light = 255.0 - 190.0 * (value / largest).sqrt();
            RGBColor(light as u8, light as u8, light as u8)
        },
    )
}

/// Walls and points within the axes, without mirror images.
fn landmarks(axes: &Axes<'_>, map: &LandmarkMap) -> Result<()> {
    // Of a wall that leaves the frame its inner part is drawn.
    let parts = |[from, to]: [[f64; 2]; 2]| -> Vec<(f64, f64)> {
        let at = |axis: usize, k: u32| {
            from[axis] + f64::from(k) / f64::from(PARTS) * (to[axis] - from[axis])
        };
        (0..=PARTS).map(|k| (at(0, k), at(1, k))).collect()
    };
    let mut points = Vec::new();
    for landmark in map.landmarks.iter().filter(|own| !map.is_image(own)) {
        match landmark.ends_m() {
            Some(ends) => axes.curve(&parts(ends), Stroke::solid(colour::GREY, 7.0))?,
            None => points.extend(landmark.middle_m().map(|[x, y]| (x, y))),
        }
    }
    axes.markers(&points, Marker::Disc, 17.0, colour::GREY)
}
