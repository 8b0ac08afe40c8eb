//! Share of the position errors below a distance, a line for every method and cell.

use std::path::Path;

use anyhow::{Result, bail};

use super::{MOST_LINES, lines, number};
use crate::data::table::Table;
use crate::figures::drawing::axes::Axes;
use crate::figures::drawing::axis::Axis;
use crate::figures::drawing::canvas;
use crate::figures::drawing::legend::{Entry, legend_in_columns};
use crate::metrics::quantile;
use crate::study::Study;
use crate::study::cells::all_in_words;

/// Draws the figure.
///
/// # Errors
/// When the data file is missing or damaged, or the picture cannot be written.
pub(super) fn draw(study: &Study, data: &Path, picture: &Path) -> Result<()> {
    let table = Table::read(&data.join("distribution.csv"))?;
    let cells = study.cells.len();
    let pooled = cells * study.methods().len() > MOST_LINES;
    let mut found = Vec::new();
    for method in study.methods() {
        let rows = table.only("method", method.name())?;
        let mut add = |label: String, own: &Table| -> Result<()> {
            let mut errors = own.numbers("error_m")?;
            errors.sort_by(f64::total_cmp);
            if !errors.is_empty() {
                let last = (errors.len() - 1).max(1) as f64;
                let shares = (0..errors.len())
                    .map(|k| k as f64 / last)
                    .collect::<Vec<_>>();
                found.push(((method, label), errors, shares));
            }
            Ok(())
        };
        if pooled {
            // Quantiles of equal shares: all cells count alike.
            add(String::new(), &rows)?;
            continue;
        }
        for cell in &study.cells {
            let label = all_in_words(cell.labels.iter().map(|(name, value)| (name, value)));
            add(label, &rows.only("cell", &cell.name().replace(',', " "))?)?;
        }
    }
    let ninety = |errors: &[f64]| quantile(errors, 0.9);
    let names: Vec<_> = found.iter().map(|(name, ..)| name.clone()).collect();
    let lines = lines(&names);
    let best = lines
        .iter()
        .zip(&found)
        .min_by(|a, b| ninety(&a.1.1).total_cmp(&ninety(&b.1.1)));
    let Some((best, (_, errors, _))) = best else {
        bail!("cdf: no trial has errors; leave the figure out");
    };
    let low = found
        .iter()
        .map(|(_, errors, _)| quantile(errors, 0.02))
        .fold(f64::INFINITY, f64::min)
        .max(1e-4);
    let high = found
        .iter()
        .map(|(_, errors, _)| quantile(errors, 1.0))
        .fold(low, f64::max);
    let title = format!(
        "90 % of the errors below {} m: {}",
        number(ninety(errors)),
        best.name
    );
    canvas::draw(picture, 1600, 1100, |sheet| {
        sheet.title(&title)?;
        let entries: Vec<Entry> = lines
            .iter()
            .zip(&found)
            .map(|(line, (_, errors, _))| {
                let text = format!("{}: {} m", line.name, number(ninety(errors)));
                Entry::line(line.stroke, &text)
            })
            .collect();
        let height = legend_in_columns(sheet, [190.0, 80.0], 1380.0, &entries)?;
        let axes = Axes::new(
            sheet,
            [190.0, 160.0 + height, 1550.0, 980.0],
            Axis::logarithmic(low, 1.1 * high.max(2.0 * low), "position error [m]"),
            Axis::new(0.0, 1.0, "share of errors below"),
        );
        axes.grid()?;
        for (line, (_, errors, shares)) in lines.iter().zip(&found) {
            let curve: Vec<(f64, f64)> = errors
                .iter()
                .zip(shares)
                .map(|(error, share)| (error.max(1e-6).log10(), *share))
                .collect();
            axes.curve(&curve, line.stroke)?;
        }
        let note = if pooled {
            format!(" of {cells} cells together")
        } else {
            String::new()
        };
        axes.finish(&format!(
            "all trials and times{note}; after each name the 90 % quantile"
        ))
    })
}
