//! The maps of a cell over the true walls: the echo image, and the landmarks.

use std::path::{Path, PathBuf};

use anyhow::Result;
use localizer::landmarks::LandmarkMap;

use crate::data::json;
use crate::data::layout::Layout;
use crate::data::map_place::MapPlace;
use crate::figures::drawing::canvas;
use crate::figures::{landmarks, map_image};

/// Draws the `number`-th maps, and returns their pictures: none of a cell that was not run, or in which nothing was
/// learnt.
///
/// # Errors
/// When a data file is damaged, or a picture cannot be written.
pub(super) fn draw(
    data: &Path,
    number: usize,
    figures: &Path,
    ending: &str,
) -> Result<Vec<PathBuf>> {
    let layout = data.join(format!("map_{number}_layout.json"));
    let mut pictures = Vec::new();
    if !layout.exists() {
        return Ok(pictures);
    }
    let layout: Layout = json::read(&layout)?;
    if data.join(format!("map_{number}.npy")).exists() {
        let (map, place) = MapPlace::read(data, &format!("map_{number}"))?;
        // Pixels, in pages too: a rectangle for each would take megabytes.
        let picture = figures.join(format!("map_{number}.png"));
        canvas::draw(&picture, 1100, 1020, |sheet| {
            sheet.title(&format!("The echo image of {}", layout.name))?;
            let frame = ([120.0, 130.0, 880.0, 860.0], [1050.0, 985.0]);
            map_image::draw((&map, &place), &layout, sheet, frame, "dashed: true walls")
        })?;
        pictures.push(picture);
    }
    let known = data.join(format!("map_{number}_landmarks"));
    if known.exists() {
        let map = LandmarkMap::read(&known)?;
        let picture = figures.join(format!("landmarks_{number}.{ending}"));
        let title = format!("Landmarks of {}", layout.name);
        landmarks::draw(&map, Some(&layout), &[], &title, &picture)?;
        pictures.push(picture);
    }
    Ok(pictures)
}
