//! Figure 6 (b): cumulative distribution of the position errors over all trials.

use std::path::Path;

use anyhow::Result;

use super::axes::Axes;
use super::axis::Axis;
use super::canvas;
use super::legend::{Entry, legend};
use super::style::method_style;
use crate::metrics::{cumulative_distribution, mean, quantile};
use crate::table::Table;

/// Draws the figure.
///
/// # Errors
/// When the data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let estimates = Table::read(&data.join("drift_paths.csv"))?;
    let methods = ["doppler", "toa-only", "odometry"];
    let errors = methods
        .iter()
        .map(|method| estimates.only("method", method)?.numbers("error_m"))
        .collect::<Result<Vec<_>>>()?;
    // A few strayed trials of one method must not press all curves against the axis.
    let end = errors[..2]
        .iter()
        .filter(|errors| !errors.is_empty())
        .map(|errors| 1.15 * quantile(errors, 0.98))
        .fold(0.02, f64::max);
    canvas::draw(picture, 1600, 1100, |sheet| {
        let title =
            "Position errors are smaller with Doppler bearings than with arrival times alone";
        sheet.title(title)?;
        let axes = Axes::new(
            sheet,
            [190.0, 290.0, 1550.0, 980.0],
            Axis::new(0.0, end, "position error [m]"),
            Axis::new(0.0, 1.0, "share of errors below"),
        );
        axes.grid()?;
        let mut entries = Vec::new();
        for (method, errors) in methods.iter().zip(&errors) {
            let (stroke, name) = method_style(method);
            let curve = cumulative_distribution(errors, 401);
            axes.curve(&curve, stroke)?;
            entries.push(Entry {
                stroke: Some(stroke),
                marker: None,
                text: format!(
                    "{name}: mean {:.3} m, 90 % below {:.3} m",
                    mean(errors),
                    quantile(errors, 0.9)
                ),
            });
        }
        axes.finish("(b) cumulative distribution, all trials")?;
        legend(sheet, [190.0, 78.0], 1400.0, &entries)?;
        Ok(())
    })
}
