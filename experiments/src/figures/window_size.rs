//! Figure 7: mean position error over the half-width of the matched window, whole and enlarged.

use std::path::Path;

use anyhow::Result;

use super::axes::Axes;
use super::axis::Axis;
use super::canvas::{self, Marker};
use super::legend::{Entry, legend};
use super::means::means_by;
use super::style::method_style;
use crate::table::Table;

/// A window whose error exceeds the least by no more than this part does about as well.
const ABOUT_AS_WELL: f64 = 0.25;

/// What one sees: the range of windows that do about as well as the best, and the best.
fn title(curve: &[(f64, f64)], best_m: f64, best_mae: f64) -> String {
    let bound = (1.0 + ABOUT_AS_WELL) * best_mae;
    let mut well = curve.iter().filter(|point| point.1 <= bound);
    let from = well.next().map_or(best_m, |point| point.0);
    let to = well.next_back().map_or(from, |point| point.0);
    let which = match from < to {
        true => format!("Windows of {from:.1} to {to:.1} m do best"),
        false => "One size of window does best".to_owned(),
    };
    format!("{which}: {best_mae:.3} m at {best_m:.1} m")
}

/// Draws the figure.
///
/// # Errors
/// When the data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let table = Table::read(&data.join("window_size.csv"))?;
    let cells = means_by(&table, "half_width_m", "mae_m")?;
    let best = cells.iter().min_by(|a, b| a.1.total_cmp(&b.1)).copied();
    let (best_m, best_mae, _) = best.unwrap_or((0.0, 0.0, [0.0; 2]));
    let (stroke, _) = method_style("doppler");
    let curve: Vec<(f64, f64)> = cells.iter().map(|cell| (cell.0, cell.1)).collect();
    let whiskers: Vec<(f64, f64, f64)> = cells
        .iter()
        .map(|cell| (cell.0, cell.2[0], cell.2[1]))
        .collect();
    let x = Axis::around(
        curve.iter().map(|point| point.0),
        0.06,
        "half-width of the window [m]",
    );
    let highest = whiskers.iter().map(|bar| bar.2).fold(0.0, f64::max);
    let lowest = whiskers
        .iter()
        .map(|bar| bar.1)
        .fold(f64::INFINITY, f64::min);
    let close: Vec<f64> = whiskers
        .iter()
        .filter(|bar| bar.1 < 2.2 * best_mae)
        .map(|bar| bar.2.min(2.4 * best_mae))
        .chain([lowest])
        .collect();
    canvas::draw(picture, 1800, 960, |sheet| {
        let title = title(&curve, best_m, best_mae);
        sheet.title(&title)?;
        let panels = [
            (
                "(a) whole",
                Axis::new(0.0, 1.06 * highest, "MAE of position [m]"),
            ),
            (
                "(b) enlarged",
                Axis::around(close, 0.1, "MAE of position [m]"),
            ),
        ];
        for (index, (name, y)) in panels.into_iter().enumerate() {
            let left = 170.0 + 880.0 * index as f64;
            let axes = Axes::new(sheet, [left, 210.0, left + 700.0, 830.0], x.clone(), y);
            axes.grid()?;
            axes.curve(&curve, stroke)?;
            axes.whiskers(&whiskers, stroke.colour)?;
            axes.markers(&curve, Marker::Disc, 18.0, stroke.colour)?;
            axes.finish(name)?;
        }
        let trials = table.distinct("trial")?.len();
        let entry = Entry {
            stroke: Some(stroke),
            marker: Some((Marker::Disc, stroke.colour)),
            text: format!("Doppler, mean of {trials} trials; bars: 95 % interval of the mean"),
        };
        legend(sheet, [170.0, 85.0], 1500.0, &[entry])?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::title;

    #[test]
    fn the_title_says_how_wide_the_minimum_is() {
        let flat = [
            (3.0, 0.4),
            (4.0, 0.035),
            (4.5, 0.03),
            (5.0, 0.06),
            (6.0, 0.036),
        ];
        assert_eq!(
            title(&flat, 4.5, 0.03),
            "Windows of 4.0 to 6.0 m do best: 0.030 m at 4.5 m"
        );
        let sharp = [(3.0, 0.4), (4.0, 0.02), (5.0, 0.04)];
        assert_eq!(
            title(&sharp, 4.0, 0.02),
            "One size of window does best: 0.020 m at 4.0 m"
        );
    }
}
