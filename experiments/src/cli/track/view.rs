//! What `track --view` shows on a terminal: pose, fit, and the newest echoes around the robot.

use std::fmt::Write as _;
use std::io::Write as _;

use localizer::parameters::SignalParameters;
use ndarray::Array2;

use crate::localization::{Stream, Told};

/// Rows of the picture; a letter is twice as high as wide. The robot is in the middle and looks up.
const ROWS: usize = 21;
const COLUMNS: usize = 2 * ROWS;

/// Distance from the middle to an edge, in metres.
const REACH_M: f64 = 5.0;

/// Width of the ranges of which the largest echo counts, in metres.
const BIN_M: f64 = 0.1;

/// Letters from nothing to the loudest.
const LETTERS: &[u8] = b" .:-=+*#%@";

/// Cells of the bar of the fit.
const BAR: usize = 20;

/// An echo: left and right sound the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Echo {
    pub(super) range_m: f64,
    /// Cosine of the angle from the heading.
    pub(super) cosine: f64,
    pub(super) height: f64,
}

/// The newest echoes: the largest of every direction and tenth of a metre, or the peaks.
pub(super) fn picture_of(stream: &Stream, signal: &SignalParameters) -> Vec<Echo> {
    match stream {
        Stream::Images(images) => of_block(&images.0.echoes().intensity, signal),
        Stream::Landmarks(localizer) => (localizer.tracker().peaks().iter())
            .map(|peak| Echo {
                range_m: peak.range_m,
                cosine: peak.cosine,
                height: peak.amplitude,
            })
            .collect(),
    }
}

/// The largest echo of every direction and range in a block `[direction, delay]`.
fn of_block(intensity: &Array2<f32>, signal: &SignalParameters) -> Vec<Echo> {
    let last = intensity.nrows().saturating_sub(1).max(1) as f64;
    let width = signal.delay_of_range(BIN_M).max(1);
    let mut echoes = Vec::new();
    for (direction, row) in intensity.rows().into_iter().enumerate() {
        let cosine = (std::f64::consts::PI * direction as f64 / last).cos();
        for (number, part) in row.axis_chunks_iter(ndarray::Axis(0), width).enumerate() {
            echoes.push(Echo {
                range_m: signal.range_of_delay_m((number as f64 + 0.5) * width as f64),
                cosine,
                height: f64::from(part.iter().copied().fold(0.0, f32::max)),
            });
        }
    }
    echoes
}

/// The picture, a line a row.
fn picture(echoes: &[Echo]) -> String {
    let mut heights = [[0.0_f64; COLUMNS]; ROWS];
    let half = 0.5 * ROWS as f64;
    for echo in echoes {
        let ahead = echo.range_m * echo.cosine;
        let aside = echo.range_m * (1.0 - echo.cosine * echo.cosine).max(0.0).sqrt();
        for aside in [aside, -aside] {
            let row = half * (1.0 - ahead / REACH_M);
            let column = 2.0 * half * (1.0 + aside / REACH_M);
            if (0.0..ROWS as f64).contains(&row) && (0.0..COLUMNS as f64).contains(&column) {
                let cell = &mut heights[row as usize][column as usize];
                *cell = cell.max(echo.height);
            }
        }
    }
    let loudest = heights.iter().flatten().copied().fold(1e-12, f64::max);
    let mut text = String::new();
    for (row, heights) in heights.iter().enumerate() {
        for (column, height) in heights.iter().enumerate() {
            let level = (height / loudest * (LETTERS.len() - 1) as f64).round() as usize;
            let is_robot = row == ROWS / 2 && column == COLUMNS / 2;
            text.push(if is_robot {
                '^'
            } else {
                char::from(LETTERS[level])
            });
        }
        text.push('\n');
    }
    text
}

/// The view as text.
fn text(told: &Told, status: &str, echoes: &[Echo]) -> String {
    let pose = &told.pose;
    let sigma_m = (told.covariance[0][0] + told.covariance[1][1])
        .max(0.0)
        .sqrt();
    let full = (told.fit.clamp(0.0, 1.0) * BAR as f64).round() as usize;
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{:9.2} s   x {:8.3} m   y {:8.3} m   heading {:7.1} deg   {status}",
        told.t_s,
        pose.x_m,
        pose.y_m,
        pose.heading_rad.to_degrees()
    );
    let _ = writeln!(
        text,
        "fit [{}{}] {:.2}   +-{sigma_m:.3} m   echoes up to {REACH_M} m, ahead is up:",
        "#".repeat(full),
        ".".repeat(BAR - full),
        told.fit
    );
    text + &picture(echoes)
}

/// The place on the terminal.
#[derive(Debug, Default)]
pub(super) struct View {
    shown: bool,
}

impl View {
    /// Replaces what was shown last.
    pub(super) fn show(&mut self, told: &Told, status: &str, echoes: &[Echo]) {
        let begin = if self.shown {
            "\x1b[H"
        } else {
            "\x1b[2J\x1b[H"
        };
        self.shown = true;
        let lines = text(told, status, echoes).replace('\n', "\x1b[K\r\n");
        // A view that nobody sees any more is no reason to end.
        let _ = std::io::stderr().write_all(format!("{begin}{lines}\x1b[J").as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use localizer::Pose;

    use super::*;

    #[test]
    fn echoes_are_drawn_where_they_come_from() {
        let echo = |range_m, cosine, height| Echo {
            range_m,
            cosine,
            height,
        };
        let told = Told {
            t_s: 1.5,
            pose: Pose::default(),
            covariance: [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0; 3]],
            latest_s: 1.6,
            latest: Pose::default(),
            status: "echoes",
            fit: 0.5,
        };
        let shown = text(
            &told,
            "echoes",
            &[
                echo(2.5, 1.0, 1.0),
                echo(2.5, 0.0, 0.5),
                echo(9.0, 1.0, 3.0),
            ],
        );
        let lines: Vec<&str> = shown.lines().collect();
        assert_eq!(lines.len(), 2 + ROWS);
        assert!(
            lines[1].contains("[##########..........] 0.50"),
            "{}",
            lines[1]
        );
        let at = |row: usize, column: usize| char::from(lines[2 + row].as_bytes()[column]);
        assert_eq!(at(5, 21), '@', "{shown}");
        assert_eq!(
            (at(10, 10), at(10, 31), at(10, 21)),
            ('+', '+', '^'),
            "{shown}"
        );
        assert_eq!(
            shown.matches('@').count(),
            1,
            "what is too far is not drawn: {shown}"
        );
    }
}
