//! Figure 7: mean position error over the half-width of the matched window, whole and enlarged.

use std::path::Path;

use anyhow::Result;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::Marker;
use super::drawing::style::method_style;
use super::means::means_by;
use crate::data::table::Table;

/// Greatest excess over the least error, as a share of it, of a window that counts as equally good.
const ABOUT_AS_WELL: f64 = 0.25;

/// The title: the least error, and every range of neighbouring windows that are equally good.
fn title(curve: &[(f64, f64)]) -> String {
    let Some(best) = curve.iter().min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return "No window was tried".to_string();
    };
    let well = |point: &(f64, f64)| point.1 <= (1.0 + ABOUT_AS_WELL) * best.1;
    let ranges: Vec<String> = curve
        .chunk_by(|a, b| well(a) == well(b))
        .filter(|run| well(&run[0]))
        .map(|run| match run {
            [only] => format!("{:.1}", only.0),
            _ => format!("{:.1} to {:.1}", run[0].0, run[run.len() - 1].0),
        })
        .collect();
    format!(
        "Least error {:.3} m at {:.1} m; within {:.0} % of it: {} m",
        best.1,
        best.0,
        100.0 * ABOUT_AS_WELL,
        ranges.join(" and ")
    )
}

/// Draws the figure.
///
/// # Errors
/// When the data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let table = Table::read(&data.join("window_size.csv"))?;
    let cells = means_by(&table, "half_width_m", "mae_m")?;
    let best = cells.iter().min_by(|a, b| a.1.total_cmp(&b.1)).copied();
    let best_mae = best.map_or(0.0, |cell| cell.1);
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
        sheet.title(&title(&curve))?;
        let near = Axis::around(close, 0.1, "MAE of position [m]");
        let enlarged = match highest > near.high {
            true => "(b) enlarged: larger errors lie above",
            false => "(b) enlarged",
        };
        let panels = [
            (
                "(a) whole",
                Axis::new(0.0, 1.06 * highest, "MAE of position [m]"),
            ),
            (enlarged, near),
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
    fn the_title_names_the_windows_that_are_equally_good() {
        let flat = [(3.0, 0.4), (4.0, 0.035), (4.5, 0.03), (6.0, 0.036)];
        assert_eq!(
            title(&flat),
            "Least error 0.030 m at 4.5 m; within 25 % of it: 4.0 to 6.0 m"
        );
        let gap = [
            (3.0, 0.4),
            (4.0, 0.035),
            (4.5, 0.03),
            (5.0, 0.06),
            (6.0, 0.036),
        ];
        assert_eq!(
            title(&gap),
            "Least error 0.030 m at 4.5 m; within 25 % of it: 4.0 to 4.5 and 6.0 m"
        );
        let sharp = [(3.0, 0.4), (4.0, 0.02), (5.0, 0.04)];
        assert_eq!(
            title(&sharp),
            "Least error 0.020 m at 4.0 m; within 25 % of it: 4.0 m"
        );
    }
}
