//! Nine test points inside four receivers: true, published and ours (Hsu et al., Sens. Mater. 2021, Fig. 14 and Tables
//! 1 and 2).

use std::path::Path;

use anyhow::Result;
use plotters::style::RGBColor;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas::{self, LABEL};
use super::drawing::colour;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::Marker;
use crate::data::table::Table;
use crate::metrics::mean;

/// Side of the square that the receivers stand at the corners of, metres.
const SITE_M: f64 = 4.0;

/// A test point in metres and its error in millimetres.
type Found = ([f64; 2], [f64; 2]);

/// Test points and errors of a method.
fn errors(table: &Table, method: &str) -> Result<Vec<Found>> {
    let rows = table.only("method", method)?;
    let column = |name: &str| rows.numbers(name);
    let truth = column("x_true_m")?.into_iter().zip(column("y_true_m")?);
    let found = column("x_m")?.into_iter().zip(column("y_m")?);
    Ok(truth
        .zip(found)
        .map(|((x, y), (found_x, found_y))| ([x, y], [1e3 * (found_x - x), 1e3 * (found_y - y)]))
        .collect())
}

/// Mean distance to the test points, millimetres.
fn mean_mm(errors: &[Found]) -> f64 {
    let lengths: Vec<f64> = errors.iter().map(|(_, [x, y])| x.hypot(*y)).collect();
    mean(&lengths)
}

/// The different values among `values`, ascending.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Draws the figure.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let published = Table::read(&data.join("dual_circle_published.csv"))?;
    let ours = Table::read(&data.join("dual_circle.csv"))?.only("trial", "0")?;
    let styles: [(&Table, &str, &str, Marker, RGBColor); 5] = [
        (
            &published,
            "dual-circle",
            "published, dual circle",
            Marker::OpenSquare,
            colour::VERMILLION,
        ),
        (
            &published,
            "triangulation",
            "published, triangulation",
            Marker::OpenTriangle,
            colour::ORANGE,
        ),
        (
            &ours,
            "dual-circle",
            "ours, dual circle",
            Marker::OpenSquare,
            colour::BLUE,
        ),
        (
            &ours,
            "triangulation",
            "ours, triangulation",
            Marker::OpenTriangle,
            colour::SKY,
        ),
        (
            &ours,
            "least-squares",
            "ours, least squares",
            Marker::OpenDiamond,
            colour::GREEN,
        ),
    ];
    let mut found = Vec::new();
    for (table, method, text, marker, shade) in styles {
        found.push((errors(table, method)?, text, marker, shade));
    }
    let points = errors(&published, "dual-circle")?;
    let columns = distinct(points.iter().map(|(truth, _)| truth[0]));
    let rows = distinct(points.iter().map(|(truth, _)| truth[1]));
    let all = found.iter().flat_map(|(errors, ..)| errors);
    let farthest = all.flat_map(|(_, error)| error.map(f64::abs));
    let reach = 1.15 * farthest.fold(1.0, f64::max);
    let (pitch, side, top) = ([480.0, 480.0], 370.0, 315.0);
    let size = [
        160.0 + pitch[0] * columns.len() as f64,
        top + 50.0 + pitch[1] * rows.len() as f64,
    ];
    canvas::draw(picture, size[0] as u32, size[1] as u32, |sheet| {
        let title = format!(
            "{} points inside four receivers: errors of position",
            points.len()
        );
        sheet.title(&title)?;
        let mut entries = vec![Entry {
            stroke: None,
            marker: Some((Marker::Disc, colour::BLACK)),
            text: "true point".to_string(),
        }];
        for (errors, text, marker, shade) in &found {
            entries.push(Entry {
                stroke: None,
                marker: Some((*marker, *shade)),
                text: format!("{text}: {:.1} mm", mean_mm(errors)),
            });
        }
        let below = legend(sheet, [100.0, 78.0], size[0] - 120.0, &entries)?;
        let note = format!(
            "Means over the points; ours: first trial. Receivers: corners of (0, 0) to ({SITE_M}, {SITE_M}) m."
        );
        sheet.text(
            &note,
            [100.0, 78.0 + below + 22.0],
            (1, 0),
            LABEL - 4.0,
            false,
            false,
        )?;
        for (column, x_m) in columns.iter().enumerate() {
            for (row, y_m) in rows.iter().rev().enumerate() {
                let left = 150.0 + pitch[0] * column as f64;
                let top = top + pitch[1] * row as f64;
                // Only the outer frames have labels.
                let [x_label, y_label] = [
                    (row + 1 == rows.len(), "error in x [mm]"),
                    (column == 0, "error in y [mm]"),
                ]
                .map(|(outer, label)| if outer { label } else { "" });
                let axes = Axes::new(
                    sheet,
                    [left, top, left + side, top + side],
                    Axis::new(-reach, reach, x_label),
                    Axis::new(-reach, reach, y_label),
                );
                axes.grid()?;
                axes.markers(&[(0.0, 0.0)], Marker::Disc, 9.0, colour::BLACK)?;
                for (errors, _, marker, shade) in &found {
                    let here = errors.iter().filter(|(truth, _)| *truth == [*x_m, *y_m]);
                    let here: Vec<(f64, f64)> = here.map(|(_, [x, y])| (*x, *y)).collect();
                    axes.markers(&here, *marker, 14.0, *shade)?;
                }
                axes.finish(&format!("({x_m}, {y_m}) m"))?;
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_means_of_distances_in_millimetres() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        let rows =
            "method,x_true_m,y_true_m,x_m,y_m\na,1,2,1.003,2.004\nb,1,2,1,2\na,3,2,3,2.007\n";
        crate::data::atomic::write(&path, rows.as_bytes()).unwrap();
        let found = errors(&Table::read(&path).unwrap(), "a").unwrap();
        assert_eq!(found[1].0, [3.0, 2.0]);
        assert!((mean_mm(&found) - 6.0).abs() < 1e-9);
        assert_eq!(distinct([3.0, 1.0, 3.0].into_iter()), [1.0, 3.0]);
    }
}
