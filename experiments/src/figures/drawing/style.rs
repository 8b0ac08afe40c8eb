//! Styles of localization methods and numbers of periods, the same in every figure.

use plotters::style::RGBColor;

use super::colour;
use super::stroke::{Marker, Stroke};

/// Style of a localization method: line, marker colour and name.
pub(crate) fn method_style(method: &str) -> (Stroke, &'static str) {
    let line = |colour: RGBColor, width| Stroke::solid(colour, width);
    match method {
        "doppler" => (line(colour::BLUE, 5.0), "Doppler"),
        "toa-only" => (
            line(colour::ORANGE, 5.0).dashed(&[22.0, 9.0, 5.0, 9.0]),
            "ToA only",
        ),
        "odometry" => (
            line(colour::VERMILLION, 5.0).dashed(&[6.0, 9.0]),
            "odometry",
        ),
        "landmarks" => (line(colour::GREEN, 5.0), "landmarks"),
        "slam" => (line(colour::PURPLE, 5.0).dashed(&[22.0, 9.0]), "SLAM"),
        "multipath" => (line(colour::SKY, 5.0).dashed(&[6.0, 9.0]), "multipath"),
        _ => (line(colour::BLACK, 3.0), "truth"),
    }
}

/// Style of a number of periods; only those of the paper's Fig. 2 have lines.
pub(crate) fn periods_style(periods: &str) -> Option<(Stroke, Marker)> {
    let dashes = |colour, pattern| Stroke::solid(colour, 4.5).dashed(pattern);
    match periods {
        "2" => Some((
            dashes(colour::ORANGE, &[22.0, 9.0, 5.0, 9.0]),
            Marker::Triangle,
        )),
        "4" => Some((dashes(colour::GREEN, &[22.0, 9.0]), Marker::Square)),
        "6" => Some((Stroke::solid(colour::BLUE, 4.5), Marker::Disc)),
        _ => None,
    }
}
