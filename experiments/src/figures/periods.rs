//! Number of periods M in one block: estimated paths and mean position error (2023 abstract, Fig. 2).

use std::path::Path;

use anyhow::Result;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas::{self, LABEL};
use super::drawing::colour;
use super::drawing::layout::{self, drive_points, path};
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::{Marker, Stroke};
use super::drawing::style::{method_style, periods_style};
use super::means::means_by;
use crate::data::layout::Layout;
use crate::data::table::Table;

/// The title: whether more periods do better, from numbers of periods and mean errors in metres.
fn title(cells: &[(f64, f64)]) -> String {
    let by_periods = |a: &&(f64, f64), b: &&(f64, f64)| a.0.total_cmp(&b.0);
    match (
        cells.iter().min_by(by_periods),
        cells.iter().max_by(by_periods),
    ) {
        (Some(few), Some(many)) if few.1 <= many.1 && few.0 < many.0 => format!(
            "M = {} does no worse than M = {} on this drive: {:.3} and {:.3} m",
            few.0, many.0, few.1, many.1
        ),
        (Some(few), Some(many)) if few.0 < many.0 => format!(
            "{} periods in a block in place of {} lower the mean error: {:.3} to {:.3} m",
            many.0, few.0, few.1, many.1
        ),
        (Some(only), _) => format!("Mean error {:.3} m with M = {}", only.1, only.0),
        _ => "No number of periods was tried".to_string(),
    }
}

/// Draws the figure.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let layout = Layout::read(data)?;
    let truth = drive_points(&Table::read(&data.join("drive.csv"))?, "localization")?;
    let paths = Table::read(&data.join("periods_paths.csv"))?;
    let table = Table::read(&data.join("periods.csv"))?;
    let cells = means_by(&table, "m", "mae_m")?;
    canvas::draw(picture, 1800, 1060, |sheet| {
        let means: Vec<(f64, f64)> = cells.iter().map(|cell| (cell.0, cell.1)).collect();
        sheet.title(&title(&means))?;
        let left = layout::axes(&layout, sheet, [120.0, 185.0, 860.0, 925.0]);
        left.grid()?;
        layout::walls(&layout, &left, Stroke::solid(colour::GREY, 6.0))?;
        let (black, name) = method_style("truth");
        path(&left, &truth, black)?;
        let mut entries = vec![Entry::line(black, name)];
        for which in ["odometry", "2", "4", "6"] {
            let rows = paths.only("m", which)?;
            if rows.is_empty() {
                continue;
            }
            let points: Vec<(f64, f64)> = rows
                .numbers("x_m")?
                .into_iter()
                .zip(rows.numbers("y_m")?)
                .collect();
            let entry = match periods_style(which) {
                Some((stroke, marker)) => Entry {
                    stroke: Some(stroke),
                    marker: Some((marker, stroke.colour)),
                    text: format!("M = {which}"),
                },
                None => {
                    let (stroke, name) = method_style(which);
                    Entry::line(stroke, name)
                }
            };
            if let Some(stroke) = entry.stroke {
                left.curve(&points, stroke)?;
            }
            entries.push(entry);
        }
        left.finish("(a) estimated positions (first trial)")?;
        sheet.text(
            "\u{25cf} start   \u{25a0} end   grey: walls",
            [120.0, 1030.0],
            (1, 0),
            LABEL - 3.0,
            false,
            false,
        )?;
        let highest = cells.iter().map(|cell| cell.2[1]).fold(1e-3, f64::max);
        let right = Axes::new(
            sheet,
            [1050.0, 185.0, 1750.0, 925.0],
            Axis::around(
                cells.iter().map(|cell| cell.0),
                0.08,
                "periods M in a block",
            ),
            Axis::new(0.0, 1.08 * highest, "MAE of position [m]"),
        );
        right.grid()?;
        let curve: Vec<(f64, f64)> = cells.iter().map(|cell| (cell.0, cell.1)).collect();
        right.curve(&curve, Stroke::solid(colour::GREY, 3.0))?;
        for cell in &cells {
            let style = periods_style(&cell.0.to_string());
            let (shade, marker) = style.map_or((colour::GREY, Marker::Disc), |(stroke, marker)| {
                (stroke.colour, marker)
            });
            right.whiskers(&[(cell.0, cell.2[0], cell.2[1])], shade)?;
            right.markers(&[(cell.0, cell.1)], marker, 24.0, shade)?;
        }
        right.finish("(b) mean error, bars: 95 % interval")?;
        if cells
            .iter()
            .any(|cell| periods_style(&cell.0.to_string()).is_none())
        {
            entries.push(Entry {
                stroke: None,
                marker: Some((Marker::Disc, colour::GREY)),
                text: "other M, without paths".to_string(),
            });
        }
        legend(sheet, [120.0, 80.0], 1620.0, &entries)?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_title_follows_from_the_numbers() {
        assert_eq!(
            title(&[(6.0, 0.028), (1.0, 0.083), (8.0, 0.03)]),
            "8 periods in a block in place of 1 lower the mean error: 0.083 to 0.030 m"
        );
        assert_eq!(
            title(&[(2.0, 0.015), (6.0, 0.019)]),
            "M = 2 does no worse than M = 6 on this drive: 0.015 and 0.019 m"
        );
        assert_eq!(title(&[(6.0, 0.019)]), "Mean error 0.019 m with M = 6");
    }
}
