//! Figure 4: walls and drive paths of the scene, and the map image that the mapping drive gave.

use std::path::Path;

use anyhow::Result;

use super::drawing::canvas::{self, LABEL};
use super::drawing::colour;
use super::drawing::layout::{self, drive_points, path};
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::Stroke;
use super::map_image;
use crate::data::layout::Layout;
use crate::data::map_place::MapPlace;
use crate::data::table::Table;

/// Draws the figure.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let layout = Layout::read(data)?;
    let drive = Table::read(&data.join("drive.csv"))?;
    let (map, place) = MapPlace::read(data, "map")?;
    let tracks = [
        (
            "mapping",
            Stroke::solid(colour::GREEN, 3.5).dashed(&[16.0, 8.0]),
        ),
        ("localization", Stroke::solid(colour::BLUE, 5.0)),
    ];
    canvas::draw(picture, 1800, 1020, |sheet| {
        let title =
            "The scene, and the image of its walls from echoes at the known poses of a drive";
        sheet.title(title)?;
        let left = layout::axes(&layout, sheet, [120.0, 130.0, 810.0, 820.0]);
        left.grid()?;
        layout::layer(&layout, &left)?;
        layout::walls(&layout, &left, Stroke::solid(colour::BLACK, 7.0))?;
        for (name, stroke) in tracks {
            path(&left, &drive_points(&drive, name)?, stroke)?;
        }
        left.finish("(a) rigid walls and drives")?;
        let mut entries = vec![Entry {
            stroke: Some(Stroke::solid(colour::BLACK, 8.0)),
            marker: None,
            text: "wall".to_string(),
        }];
        entries.extend(tracks.map(|(name, stroke)| Entry {
            stroke: Some(stroke),
            marker: None,
            text: format!("{name} drive"),
        }));
        legend(sheet, [60.0, 925.0], 900.0, &entries)?;
        sheet.text(
            "\u{25cf} start   \u{25a0} end   light blue: absorbing layer",
            [60.0, 990.0],
            (1, 0),
            LABEL - 4.0,
            false,
            false,
        )?;

        let frame = [935.0, 130.0, 1625.0, 820.0];
        let name = "(b) map image (dashed: true walls)";
        map_image::draw(
            (&map, &place),
            &layout,
            sheet,
            (frame, [1770.0, 947.0]),
            name,
        )
    })
}
