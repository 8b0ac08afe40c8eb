//! Model (b) of the multipath paper beside the Doppler method on the scene.

use std::path::Path;

use anyhow::Result;

use super::models::{column, mean_errors_of, one_trial};
use crate::data::layout::Layout;
use crate::data::table::Table;
use crate::figures::drawing::canvas;
use crate::figures::drawing::colour;
use crate::figures::drawing::layout::{self, drive_points, path};
use crate::figures::drawing::legend::Entry;
use crate::figures::drawing::stroke::Stroke;
use crate::figures::drawing::style::method_style;

/// Draws model (b) and the Doppler method on the scene.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let layout = Layout::read(data)?;
    let truth = drive_points(&Table::read(&data.join("drive.csv"))?, "localization")?;
    let table = Table::read(&data.join("multipath_scene.csv"))?;
    canvas::draw(picture, 1660, 1100, |sheet| {
        let errors = mean_errors_of(&table, &["planar", "doppler", "odometry"])?;
        sheet.title(&format!("Mean error of the first trial: {errors}"))?;
        let axes = layout::axes(&layout, sheet, [120.0, 130.0, 980.0, 990.0]);
        axes.grid()?;
        layout::walls(&layout, &axes, Stroke::solid(colour::GREY, 6.0))?;
        let (black, name) = method_style("truth");
        let mut entries = vec![Entry::line(black, name)];
        path(&axes, &truth, black)?;
        let methods = ["odometry", "doppler", "planar"];
        entries.extend(one_trial(&axes, &table, "0", &methods)?);
        axes.finish("estimated positions (first trial)")?;
        let notes = [
            "(b) was given the walls of the scene as planes;",
            "Doppler has only the map image from echoes.",
            "\u{25cf} start   \u{25a0} end   grey: walls",
        ];
        column(sheet, entries, &notes)
    })
}
