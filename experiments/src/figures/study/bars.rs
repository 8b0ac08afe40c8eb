//! A measure of every cell and method, with intervals: one row each.

use std::path::Path;

use anyhow::{Result, bail};

use super::number;
use super::rows::{self, Row};
use crate::figures::drawing::axis::Axis;
use crate::figures::drawing::style::method_style;
use crate::study::StudySummary;
use crate::study::cells::all_in_words;
use crate::study::scores::Measure;

/// Least ratio of largest to least mean from which on the axis is logarithmic.
const WIDE: f64 = 20.0;

/// Draws the figure.
///
/// # Errors
/// When no trial has the measure, or the picture cannot be written.
pub(super) fn draw(summary: &StudySummary, measure: Measure, picture: &Path) -> Result<()> {
    let single = summary.cells.iter().all(|cell| cell.cell == "all");
    let rows: Vec<(String, &str, f64, [f64; 2])> = summary
        .cells
        .iter()
        .filter_map(|cell| {
            let mean = *cell.mean.get(measure.name())?;
            let interval = cell
                .interval
                .get(measure.name())
                .copied()
                .unwrap_or([mean; 2]);
            let (_, method) = method_style(cell.method.name());
            let name = match single {
                true => method.to_string(),
                false => format!("{}: {method}", all_in_words(&cell.labels)),
            };
            Some((name, cell.method.name(), mean, interval))
        })
        .collect();
    let Some(best) = rows.iter().min_by(|a, b| a.2.total_cmp(&b.2)) else {
        bail!(
            "bars: no trial has {}; leave the figure out",
            measure.name()
        );
    };
    let title = format!("Least: {}{}: {}", number(best.2), measure.unit(), best.0);
    let left_out = rows.len().saturating_sub(rows::MOST);
    let shown = &rows[..rows.len().min(rows::MOST)];
    let high = shown.iter().map(|row| row.3[1]).fold(0.0, f64::max);
    let low = shown
        .iter()
        .map(|row| row.3[0])
        .fold(f64::INFINITY, f64::min);
    let wide = low > 0.0 && high / low > WIDE;
    let along = |value: f64| if wide { value.log10() } else { value };
    let x = match wide {
        true => Axis::logarithmic(0.8 * low, 1.25 * high, measure.title()),
        false => Axis::new(0.0, 1.06 * high.max(1e-9), measure.title()),
    };
    let over = summary
        .cells
        .first()
        .map_or(String::new(), |cell| cell.over());
    let note = match left_out {
        0 => format!("mean and 95 % interval over {over}"),
        _ => format!("mean and 95 % interval over {over}; {left_out} rows left out"),
    };
    let shown: Vec<Row> = shown
        .iter()
        .map(|(name, method, mean, interval)| Row {
            name: name.clone(),
            mean: along(*mean),
            interval: interval.map(along),
            colour: method_style(method).0.colour,
        })
        .collect();
    rows::draw(&shown, x, false, [&title, &note], picture)
}
