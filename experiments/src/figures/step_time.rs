//! Figure 17: compute time of one step, Doppler bank and particle filter.

use std::path::Path;

use anyhow::Result;

use super::drawing::axes::Axes;
use super::drawing::axis::Axis;
use super::drawing::canvas;
use super::drawing::colour;
use super::drawing::legend::{Entry, legend};
use super::drawing::stroke::{Marker, Stroke};
use crate::data::table::Table;
use crate::metrics::{cumulative_distribution, quantile};

/// The title: the slowest bank and the slowest filter together, beside the time between two steps if it is
/// known, all in milliseconds.
fn title(slowest_bank: f64, slowest_filter: f64, period: Option<f64>) -> String {
    let slowest = slowest_bank + slowest_filter;
    let allowed = period.map_or(String::new(), |period| {
        format!("; real time allows {period:.1} ms")
    });
    format!("Slowest bank and slowest filter take {slowest:.2} ms together{allowed}")
}

/// Time between two estimates in milliseconds, from `drift_paths.csv` where that study was run.
fn period_ms(data: &Path) -> Result<Option<f64>> {
    let path = data.join("drift_paths.csv");
    if !path.exists() {
        return Ok(None);
    }
    let times = Table::read(&path)?
        .only("method", "odometry")?
        .numbers("t_s")?;
    let steps = times.windows(2).map(|pair| 1e3 * (pair[1] - pair[0]));
    Ok(steps
        .filter(|step| *step > 0.0)
        .min_by(|a, b| a.total_cmp(b)))
}

/// Draws the figure.
///
/// # Errors
/// When the data file is missing or damaged, or the picture cannot be written.
pub(crate) fn draw(data: &Path, picture: &Path) -> Result<()> {
    let table = Table::read(&data.join("step_time.csv"))?;
    let bank = table.only("stage", "doppler_bank")?.numbers("time_ms")?;
    let filter = table.only("stage", "filter")?;
    let mut cells = Vec::new();
    for width in filter.distinct("half_width_m")? {
        let rows = filter.only("half_width_m", &width)?;
        let times = rows.numbers("time_ms")?;
        let half_width_m = rows
            .numbers("half_width_m")?
            .first()
            .copied()
            .unwrap_or(0.0);
        cells.push((
            half_width_m,
            [0.05, 0.5, 0.95, 1.0].map(|share| quantile(&times, share)),
        ));
    }
    let median = quantile(&bank, 0.5);
    let blue = Stroke::solid(colour::BLUE, 5.0);
    let green = Stroke::solid(colour::GREEN, 5.0).dashed(&[22.0, 10.0]);
    canvas::draw(picture, 1800, 960, |sheet| {
        let slowest_filter = cells.iter().map(|cell| cell.1[3]).fold(0.0, f64::max);
        let slowest_bank = quantile(&bank, 1.0);
        sheet.title(&title(slowest_bank, slowest_filter, period_ms(data)?))?;
        let left = Axes::new(
            sheet,
            [170.0, 210.0, 870.0, 830.0],
            Axis::new(
                0.0,
                1.1 * slowest_bank.max(1e-3),
                "time of the Doppler bank [ms]",
            ),
            Axis::new(0.0, 1.0, "share of steps below"),
        );
        left.grid()?;
        left.curve(&cumulative_distribution(&bank, 301), blue)?;
        left.finish("(a) Doppler bank")?;
        let right = Axes::new(
            sheet,
            [1050.0, 210.0, 1750.0, 830.0],
            Axis::around(
                cells.iter().map(|cell| cell.0),
                0.06,
                "half-width of the window [m]",
            ),
            Axis::new(
                0.0,
                1.1 * slowest_filter.max(1e-3),
                "time of the filter [ms]",
            ),
        );
        right.grid()?;
        let curve: Vec<(f64, f64)> = cells.iter().map(|cell| (cell.0, cell.1[1])).collect();
        let bars: Vec<(f64, f64, f64)> = cells
            .iter()
            .map(|cell| (cell.0, cell.1[0], cell.1[2]))
            .collect();
        right.curve(&curve, green)?;
        right.whiskers(&bars, green.colour)?;
        right.markers(&curve, Marker::Triangle, 18.0, green.colour)?;
        let slowest: Vec<(f64, f64)> = cells.iter().map(|cell| (cell.0, cell.1[3])).collect();
        right.markers(&slowest, Marker::OpenTriangle, 13.0, green.colour)?;
        right.finish("(b) particle filter; open: slowest step")?;
        let entries = [
            Entry {
                stroke: Some(blue),
                marker: None,
                text: format!("bank: median {median:.1} ms (paper 32 ms)"),
            },
            Entry {
                stroke: Some(green),
                marker: Some((Marker::Triangle, green.colour)),
                text: "filter: median, bars 5\u{2013}95 % (paper 57 ms at 3 m)".to_string(),
            },
        ];
        legend(sheet, [170.0, 85.0], 1620.0, &entries)?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::title;

    #[test]
    fn the_title_holds_for_the_slowest_step() {
        assert_eq!(
            title(0.8618, 0.7393, Some(102.3)),
            "Slowest bank and slowest filter take 1.60 ms together; real time allows 102.3 ms"
        );
        assert_eq!(
            title(1.0, 0.5, None),
            "Slowest bank and slowest filter take 1.50 ms together"
        );
    }
}
