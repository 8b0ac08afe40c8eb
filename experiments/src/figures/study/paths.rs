//! The paths of the first trial of a cell over the walls.

use std::path::Path;

use anyhow::Result;

use crate::data::json;
use crate::data::layout::Layout;
use crate::data::table::Table;
use crate::figures::drawing::canvas;
use crate::figures::drawing::colour;
use crate::figures::drawing::layout;
use crate::figures::drawing::legend::{Entry, legend};
use crate::figures::drawing::stroke::Stroke;
use crate::figures::drawing::style::method_style;

/// Draws the figure of the `number`-th paths.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(super) fn draw(data: &Path, number: usize, picture: &Path) -> Result<()> {
    let plan: Layout = json::read(&data.join(format!("layout_{number}.json")))?;
    let table = Table::read(&data.join(format!("paths_{number}.csv")))?;
    let methods = table.distinct("method")?;
    canvas::draw(picture, 1500, 1100, |sheet| {
        sheet.title(&format!(
            "Paths in {}: the first trial of each method",
            plan.name
        ))?;
        let axes = layout::axes(&plan, sheet, [130.0, 130.0, 1010.0, 1000.0]);
        axes.grid()?;
        layout::walls(&plan, &axes, Stroke::solid(colour::GREY, 6.0))?;
        let mut y = 150.0;
        // Truth last and thin, above the estimates that hide it.
        let (truth, estimates): (Vec<&String>, Vec<&String>) =
            methods.iter().partition(|method| *method == "truth");
        for method in estimates.into_iter().chain(truth) {
            let rows = table.only("method", method)?;
            let points: Vec<(f64, f64)> = rows
                .numbers("x_m")?
                .into_iter()
                .zip(rows.numbers("y_m")?)
                .collect();
            let (stroke, name) = method_style(method);
            match method == "truth" {
                true => layout::path(&axes, &points, stroke)?,
                false => axes.curve(&points, stroke)?,
            }
            y += legend(sheet, [1070.0, y], 400.0, &[Entry::line(stroke, name)])? + 12.0;
        }
        axes.finish("")
    })
}
