//! Figures 5 and 12: speeds of the localization drive, true and from the wheels.

use std::path::Path;

use anyhow::Result;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas;
use super::drawing::colour;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::Stroke;
use crate::data::table::Table;
use crate::metrics::mean;

/// The title, from bias and spread of the error of the turn rate in rad/s, counter-clockwise positive.
fn title(bias: f64, spread: f64) -> String {
    let way = if bias < 0.0 {
        "clockwise"
    } else {
        "counter-clockwise"
    };
    let bias = bias.abs();
    if spread < 1e-3 {
        format!("Wheel odometry turns {bias:.3} rad/s too far {way} during the whole drive")
    } else {
        format!("The wheels slip: they turn {bias:.3} \u{b1} {spread:.3} rad/s too far {way}")
    }
}

/// Draws the figure.
///
/// # Errors
/// When the data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let drive = Table::read(&data.join("drive.csv"))?.only("path", "localization")?;
    let time = drive.numbers("t_s")?;
    let end = time.last().copied().unwrap_or(1.0);
    let errors: Vec<f64> = drive
        .numbers("omega_odometry_radps")?
        .iter()
        .zip(drive.numbers("omega_radps")?)
        .map(|(measured, truth)| measured - truth)
        .collect();
    let bias = mean(&errors);
    let squares: Vec<f64> = errors.iter().map(|error| (error - bias).powi(2)).collect();
    let spread = mean(&squares).sqrt();
    let measured = Stroke::solid(colour::VERMILLION, 5.0).dashed(&[20.0, 10.0]);
    let truth = Stroke::solid(colour::BLACK, 3.0);
    canvas::draw(picture, 1600, 1100, |sheet| {
        sheet.title(&title(bias, spread))?;
        let panels = [
            (
                "(a) linear speed",
                "speed v [m/s]",
                "v_mps",
                "v_odometry_mps",
            ),
            (
                "(b) angular speed, counter-clockwise positive",
                "turn rate \u{3c9} [rad/s]",
                "omega_radps",
                "omega_odometry_radps",
            ),
        ];
        for (index, (name, label, true_column, odometry_column)) in panels.into_iter().enumerate() {
            let top = 185.0 + 450.0 * index as f64;
            let values = [drive.numbers(true_column)?, drive.numbers(odometry_column)?];
            let y = Axis::around(values.iter().flatten().copied(), 0.08, label);
            let frame = [190.0, top, 1550.0, top + 300.0];
            let axes = Axes::new(sheet, frame, Axis::new(0.0, end, "time [s]"), y);
            axes.grid()?;
            for (numbers, stroke) in values.iter().zip([truth, measured]) {
                let points: Vec<(f64, f64)> =
                    time.iter().copied().zip(numbers.iter().copied()).collect();
                axes.curve(&points, stroke)?;
            }
            axes.finish(name)?;
        }
        let entries =
            [(truth, "truth"), (measured, "wheel odometry")].map(|(stroke, text)| Entry {
                stroke: Some(stroke),
                marker: None,
                text: text.to_string(),
            });
        legend(sheet, [190.0, 82.0], 1300.0, &entries)?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::title;

    #[test]
    fn the_title_names_the_direction_of_the_error() {
        assert_eq!(
            title(0.01, 0.0),
            "Wheel odometry turns 0.010 rad/s too far counter-clockwise during the whole drive"
        );
        assert_eq!(
            title(-0.012, 0.027),
            "The wheels slip: they turn 0.012 \u{b1} 0.027 rad/s too far clockwise"
        );
    }
}
