//! A map of landmarks: walls as far as they were seen, points, and paths among them; true walls where they are known.

use std::path::Path;

use anyhow::Result;
use localizer::landmarks::LandmarkMap;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas;
use super::drawing::colour;
use super::drawing::layout::{self, path};
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::{Marker, Stroke};
use crate::data::layout::Layout;

const TRUE_WALL: Stroke = Stroke::solid(colour::LIGHT, 16.0);
const WALL: Stroke = Stroke::solid(colour::BLACK, 5.0);
const IMAGE: Stroke = Stroke::solid(colour::GREY, 3.0).dashed(&[4.0, 7.0]);

/// Distance in metres around walls and paths that is drawn.
const MARGIN_M: f64 = 0.5;

/// A path with its name and style.
pub(crate) struct NamedPath<'a> {
    /// Its name in the legend.
    pub(crate) name: &'a str,
    /// Places `[x, y]` in metres.
    pub(crate) places_m: Vec<[f64; 2]>,
    /// Style.
    pub(crate) stroke: Stroke,
}

/// The estimated path.
pub(crate) const ESTIMATE: Stroke = Stroke::solid(colour::VERMILLION, 3.5);
/// The true path.
pub(crate) const TRUTH: Stroke = Stroke::solid(colour::BLUE, 7.0).faint(0.5);
/// The path by the wheels alone.
pub(crate) const WHEELS: Stroke = Stroke::solid(colour::ORANGE, 3.0).dashed(&[14.0, 7.0]);

/// Draws a map; mirror images are drawn as far as they lie near the rest.
///
/// # Errors
/// When the picture cannot be written.
pub(crate) fn draw(
    map: &LandmarkMap,
    truth: Option<&Layout>,
    paths: &[NamedPath<'_>],
    title: &str,
    picture: &Path,
) -> Result<()> {
    let (images, real): (Vec<_>, Vec<_>) =
        (map.landmarks.iter()).partition(|landmark| map.is_image(landmark));
    let mut places: Vec<[f64; 2]> = paths
        .iter()
        .flat_map(|path| path.places_m.clone())
        .collect();
    places.extend(
        real.iter()
            .filter_map(|landmark| landmark.ends_m())
            .flatten(),
    );
    places.extend(
        truth.iter().flat_map(|layout| {
            (layout.walls.iter()).flat_map(|wall| wall.points_m.iter().copied())
        }),
    );
    canvas::draw(picture, 1600, 1100, |sheet| {
        let axis = |index: usize, label: &str| {
            let of =
                |margin: f64| Axis::around(places.iter().map(|place| place[index]), margin, label);
            let span = (of(0.0).high - of(0.0).low).max(MARGIN_M);
            of(MARGIN_M / span)
        };
        let frame = [120.0, 80.0, 1090.0, 990.0];
        let axes = Axes::equal(sheet, frame, axis(0, "x [m]"), axis(1, "y [m]"));
        axes.grid()?;
        let mut entries = Vec::new();
        if let Some(truth) = truth {
            layout::walls(truth, &axes, TRUE_WALL)?;
            entries.push(Entry::line(TRUE_WALL, "true wall"));
        }
        for (landmarks, stroke, name) in [
            (&images, IMAGE, "mirror image of a wall"),
            (&real, WALL, "wall, as far as seen"),
        ] {
            let mut any = false;
            for ends in landmarks.iter().filter_map(|landmark| landmark.ends_m()) {
                let [from, to] = ends.map(|[x, y]| (x, y));
                if axes.holds(from.0, from.1) && axes.holds(to.0, to.1) {
                    axes.curve(&[from, to], stroke)?;
                    any = true;
                }
            }
            if any {
                entries.push(Entry::line(stroke, name));
            }
        }
        let points: Vec<(f64, f64)> = (map.landmarks.iter())
            .filter(|landmark| landmark.ends_m().is_none())
            .filter_map(|landmark| landmark.middle_m())
            .map(|[x, y]| (x, y))
            .filter(|&(x, y)| axes.holds(x, y))
            .collect();
        axes.markers(&points, Marker::Disc, 17.0, colour::PURPLE)?;
        if !points.is_empty() {
            entries.push(Entry {
                stroke: None,
                marker: Some((Marker::Disc, colour::PURPLE)),
                text: "corner or other point".to_string(),
            });
        }
        for named in paths {
            let points: Vec<(f64, f64)> = named.places_m.iter().map(|&[x, y]| (x, y)).collect();
            path(&axes, &points, named.stroke)?;
            entries.push(Entry::line(named.stroke, named.name));
        }
        axes.finish(title)?;
        let mut y = 110.0;
        for entry in entries {
            y += legend(sheet, [1130.0, y], 460.0, &[entry])? + 10.0;
        }
        if paths.is_empty() {
            return Ok(());
        }
        sheet.text(
            "\u{25cf} start   \u{25a0} end",
            [1130.0, y + 26.0],
            (1, 0),
            28.0,
            false,
            false,
        )
    })
}
