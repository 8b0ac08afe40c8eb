//! Figure 6 (b): cumulative distribution of the position errors over all trials.

use std::path::Path;

use anyhow::Result;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas;
use super::drawing::legend::{Entry, legend};
use super::drawing::style::method_style;
use crate::data::table::Table;
use crate::metrics::{cumulative_distribution, mean, quantile};

/// The title, from the mean errors in metres of Doppler bearings and of arrival times alone.
fn title(doppler_m: f64, toa_m: f64) -> String {
    let verb = if doppler_m < toa_m {
        "lower"
    } else {
        "do not lower"
    };
    format!(
        "Doppler bearings {verb} the mean error of arrival times: {toa_m:.3} to {doppler_m:.3} m"
    )
}

/// Note on the part of a curve beyond the axis, which ends at `end` metres; empty when there is none.
fn beyond(errors: &[f64], end: f64) -> String {
    let count = errors.iter().filter(|error| **error > end).count();
    if count == 0 {
        return String::new();
    }
    let (share, greatest) = (
        100.0 * count as f64 / errors.len() as f64,
        quantile(errors, 1.0),
    );
    format!("; {share:.1} % beyond the axis, up to {greatest:.3} m")
}

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
    // A few lost trials of one method must not squeeze all curves.
    let end = errors[..2]
        .iter()
        .filter(|errors| !errors.is_empty())
        .map(|errors| 1.15 * quantile(errors, 0.98))
        .fold(0.02, f64::max);
    canvas::draw(picture, 1600, 1100, |sheet| {
        sheet.title(&title(mean(&errors[0]), mean(&errors[1])))?;
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
            let beyond = beyond(errors, end);
            if !beyond.is_empty() {
                // An arrow outside the frame, where the curve leaves it.
                let below = errors.iter().filter(|error| **error <= end).count();
                let [x, y] = axes.pixel(end, below as f64 / errors.len() as f64);
                let arrow = [[x + 5.0, y - 14.0], [x + 5.0, y + 14.0], [x + 29.0, y]];
                sheet.area_between(&arrow, stroke.colour, 1.0)?;
            }
            entries.push(Entry {
                stroke: Some(stroke),
                marker: None,
                text: format!(
                    "{name}: mean {:.3} m, 90 % below {:.3} m{beyond}",
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

#[cfg(test)]
mod tests {
    use super::{beyond, title};

    #[test]
    fn the_title_follows_from_the_mean_errors() {
        assert_eq!(
            title(0.028, 0.105),
            "Doppler bearings lower the mean error of arrival times: 0.105 to 0.028 m"
        );
        assert!(title(0.03, 0.03).starts_with("Doppler bearings do not lower"));
    }

    #[test]
    fn the_note_names_curves_beyond_the_axis() {
        assert_eq!(beyond(&[0.1, 0.2], 0.2), "");
        assert_eq!(
            beyond(&[0.1, 0.2, 0.3, 0.4], 0.25),
            "; 50.0 % beyond the axis, up to 0.400 m"
        );
    }
}
