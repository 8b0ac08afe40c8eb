//! Figure 6 (a): true and estimated paths of odometry, Doppler method and ToA-only method.

use std::path::Path;

use anyhow::Result;

use super::drawing::canvas::{self, LABEL};
use super::drawing::colour;
use super::drawing::layout::{self, drive_points, path};
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::Stroke;
use super::drawing::style::method_style;
use crate::data::layout::Layout;
use crate::data::table::Table;
use crate::metrics::mean;

/// The title, from the mean errors in metres of odometry and of Doppler bearings.
fn title(odometry_m: f64, doppler_m: f64) -> String {
    if doppler_m <= 0.5 * odometry_m {
        "Echoes with Doppler bearings hold the path that odometry loses".to_string()
    } else {
        format!("Doppler bearings {doppler_m:.3} m, odometry {odometry_m:.3} m off the path")
    }
}

/// Draws the figure.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let layout = Layout::read(data)?;
    let estimates = Table::read(&data.join("drift_paths.csv"))?;
    let truth = drive_points(&Table::read(&data.join("drive.csv"))?, "localization")?;
    canvas::draw(picture, 1600, 1100, |sheet| {
        let error = |method: &str| -> Result<f64> {
            Ok(mean(&estimates.only("method", method)?.numbers("error_m")?))
        };
        sheet.title(&title(error("odometry")?, error("doppler")?))?;
        let axes = layout::axes(&layout, sheet, [120.0, 130.0, 980.0, 990.0]);
        axes.grid()?;
        layout::walls(&layout, &axes, Stroke::solid(colour::GREY, 6.0))?;
        let (black, name) = method_style("truth");
        path(&axes, &truth, black)?;
        let mut entries = vec![Entry {
            stroke: Some(black),
            marker: None,
            text: name.to_string(),
        }];
        for method in ["odometry", "toa-only", "doppler"] {
            let rows = estimates.only("method", method)?;
            let Some(first) = rows.distinct("trial")?.first().cloned() else {
                continue;
            };
            let trial = rows.only("trial", &first)?;
            let points: Vec<(f64, f64)> = trial
                .numbers("x_m")?
                .into_iter()
                .zip(trial.numbers("y_m")?)
                .collect();
            let (stroke, name) = method_style(method);
            axes.curve(&points, stroke)?;
            let error = mean(&rows.numbers("error_m")?);
            entries.push(Entry {
                stroke: Some(stroke),
                marker: None,
                text: format!("{name}: MAE {error:.3} m"),
            });
        }
        axes.finish("(a) estimated positions (first trial)")?;
        let mut y = 150.0;
        for entry in entries {
            y += legend(sheet, [1080.0, y], 480.0, &[entry])? + 14.0;
        }
        for note in [
            "MAE: mean over all trials.",
            "\u{25cf} start   \u{25a0} end   grey: walls",
        ] {
            sheet.text(note, [1080.0, y + 30.0], (1, 0), LABEL - 3.0, false, false)?;
            y += 46.0;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_half_of_the_error_holds_the_path() {
        let held = "Echoes with Doppler bearings hold the path that odometry loses";
        assert_eq!(title(0.226, 0.028), held);
        assert_eq!(
            title(0.026, 0.019),
            "Doppler bearings 0.019 m, odometry 0.026 m off the path"
        );
    }
}
