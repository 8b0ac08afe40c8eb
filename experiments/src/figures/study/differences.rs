//! Differences between two results of a study, cell by cell, with intervals.

use std::path::Path;

use anyhow::Result;

use super::rows::{self, Row};
use crate::figures::drawing::axis::Axis;
use crate::figures::drawing::colour;
use crate::study::compare::Difference;
use crate::study::scores::Measure;

/// The title: in how many cells the second is clearly better or worse.
fn title(differences: &[Difference]) -> String {
    let clear = |sign: f64| {
        let beyond = |d: &&Difference| {
            d.trials > 1 && sign * d.interval[0] > 0.0 && sign * d.interval[1] > 0.0
        };
        differences.iter().filter(beyond).count()
    };
    let (larger, smaller) = (clear(1.0), clear(-1.0));
    let rest = differences.len() - larger - smaller;
    format!(
        "B is smaller in {smaller}, larger in {larger}, neither clearly in {rest} of {} rows",
        differences.len()
    )
}

/// Draws the figure.
///
/// # Errors
/// When the picture cannot be written.
pub(crate) fn draw(differences: &[Difference], measure: Measure, picture: &Path) -> Result<()> {
    let shown = &differences[..differences.len().min(rows::MOST)];
    let reach = shown
        .iter()
        .flat_map(|d| d.interval)
        .fold(1e-9, |most: f64, end| most.max(end.abs()));
    let label = format!("B - A: {}", measure.title());
    let x = Axis::new(-1.1 * reach, 1.1 * reach, &label);
    let shown: Vec<Row> = shown
        .iter()
        .map(|d| Row {
            name: match d.cell.as_str() {
                "all" => d.method.clone(),
                cell => format!("{cell}: {}", d.method),
            },
            mean: d.difference,
            interval: d.interval,
            colour: match (d.interval[0] > 0.0, d.interval[1] < 0.0) {
                (true, _) => colour::VERMILLION,
                (_, true) => colour::BLUE,
                _ => colour::GREY,
            },
        })
        .collect();
    let note = "mean of the paired differences and 95 % interval";
    rows::draw(&shown, x, true, [&title(differences), note], picture)
}
