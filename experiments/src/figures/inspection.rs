//! A picture of a recording: level, echoes, speeds and turns over time.

use std::path::Path;

use anyhow::Result;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas;
use super::drawing::colour;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::{Marker, Stroke};
use crate::inspection::{Inspection, decibels};

/// Draws the picture.
///
/// # Errors
/// When it cannot be written.
pub fn draw(inspection: &Inspection, picture: &Path) -> Result<()> {
    let end = inspection.level.last().map_or(1.0, |last| last.0);
    let wheels = Stroke::solid(colour::VERMILLION, 3.5);
    let truth = Stroke::solid(colour::BLACK, 3.0).dashed(&[14.0, 8.0]);
    canvas::draw(picture, 1600, 1500, |sheet| {
        sheet.title("Sound, echoes and motion of the recording")?;
        let frame = |row: usize| {
            let top = 110.0 + 340.0 * row as f64;
            [190.0, top, 1550.0, top + 215.0]
        };
        let time = || Axis::new(0.0, end, "time [s]");
        let level: Vec<(f64, f64)> = inspection
            .level
            .iter()
            .map(|&(t_s, rms)| (t_s, decibels(rms)))
            .collect();
        let y = Axis::around(level.iter().map(|point| point.1), 0.1, "level [dB]");
        let axes = Axes::new(sheet, frame(0), time(), y);
        axes.grid()?;
        axes.curve(&level, Stroke::solid(colour::BLUE, 3.0))?;
        axes.finish("(a) level of the sound, full scale is 0 dB")?;
        let farthest = inspection
            .echoes
            .iter()
            .map(|echo| echo.1)
            .fold(1.0, f64::max);
        let axes = Axes::new(
            sheet,
            frame(1),
            time(),
            Axis::new(0.0, farthest, "range [m]"),
        );
        axes.grid()?;
        axes.markers(&inspection.echoes, Marker::Disc, 2.5, colour::BLUE)?;
        axes.finish("(b) the four strongest echoes of every block")?;
        for (row, name, label, turn) in [
            (2, "(c) speed", "speed [m/s]", false),
            (3, "(d) turn rate", "turn rate [rad/s]", true),
        ] {
            let curves = [&inspection.wheels, &inspection.truth].map(|samples| {
                samples
                    .iter()
                    .map(|sample| {
                        (
                            sample.t_s,
                            if turn {
                                sample.omega_radps
                            } else {
                                sample.v_mps
                            },
                        )
                    })
                    .collect::<Vec<(f64, f64)>>()
            });
            let y = Axis::around(curves.iter().flatten().map(|point| point.1), 0.08, label);
            let axes = Axes::new(sheet, frame(row), time(), y);
            axes.grid()?;
            for (points, stroke) in curves.iter().zip([wheels, truth]) {
                axes.curve(points, stroke)?;
            }
            axes.finish(name)?;
        }
        let entries = [Entry::line(wheels, "wheels"), Entry::line(truth, "truth")];
        legend(sheet, [1100.0, 748.0], 450.0, &entries)?;
        Ok(())
    })
}
