//! A measure over a name that varies, a line for every method and every other cell.

use std::path::Path;

use anyhow::{Result, bail};

use super::{Line, MOST_LINES, lines, number};
use crate::figures::drawing::axes::Axes;
use crate::figures::drawing::axis::Axis;
use crate::figures::drawing::canvas;
use crate::figures::drawing::legend::{Entry, legend};
use crate::study::cells::{all_in_words, in_words, words};
use crate::study::file::MethodName;
use crate::study::scores::Measure;
use crate::study::{CellScores, StudySummary};

/// Least ratio of largest to least mean from which on the upright axis is logarithmic.
const WIDE: f64 = 20.0;

/// Points of a line: place, mean, interval.
type Points = Vec<(f64, f64, [f64; 2])>;

/// Name of a cell without what is on the axis.
fn rest(cell: &CellScores, over: &str) -> String {
    all_in_words(cell.labels.iter().filter(|(name, _)| *name != over))
}

/// The lines of a figure.
fn series(
    summary: &StudySummary,
    over: &str,
    measure: Measure,
) -> Vec<((MethodName, String), Points)> {
    let mut found: Vec<((MethodName, String), Points)> = Vec::new();
    for cell in &summary.cells {
        let place = cell.labels.get(over).and_then(|text| text.parse().ok());
        let mean = cell.mean.get(measure.name());
        let (Some(place), Some(mean)) = (place, mean) else {
            continue;
        };
        let interval = cell
            .interval
            .get(measure.name())
            .copied()
            .unwrap_or([*mean; 2]);
        let name = (cell.method, rest(cell, over));
        let point = (place, *mean, interval);
        match found.iter_mut().find(|(known, _)| *known == name) {
            Some((_, points)) => points.push(point),
            None => found.push((name, vec![point])),
        }
    }
    for (_, points) in &mut found {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    found
}

/// The title: the least value and where it is.
fn title(
    lines: &[Line],
    series: &[((MethodName, String), Points)],
    over: &str,
    measure: Measure,
) -> String {
    let best = lines
        .iter()
        .zip(series)
        .flat_map(|(line, (_, points))| points.iter().map(move |point| (line, point)))
        .min_by(|a, b| a.1.1.total_cmp(&b.1.1));
    let Some((line, (place, mean, _))) = best else {
        return "No trial has this measure".to_string();
    };
    let whose = if lines.len() > 1 {
        format!(": {}", line.name)
    } else {
        String::new()
    };
    let place = in_words(over, &place.to_string());
    format!(
        "Least at {place}: {}{}{whose}",
        number(*mean),
        measure.unit()
    )
}

/// Draws the figure.
///
/// # Errors
/// When no trial has the measure, or the picture cannot be written.
pub(super) fn draw(
    summary: &StudySummary,
    over: &str,
    measure: Measure,
    picture: &Path,
) -> Result<()> {
    let mut series = series(summary, over, measure);
    if series.is_empty() {
        bail!(
            "figure over {over}: no trial has {}; leave it out",
            measure.name()
        );
    }
    let left_out = series.len().saturating_sub(MOST_LINES);
    series.truncate(MOST_LINES);
    let names: Vec<_> = series.iter().map(|(name, _)| name.clone()).collect();
    let lines = lines(&names);
    let all = || series.iter().flat_map(|(_, points)| points);
    let high = all().map(|point| point.2[1]).fold(0.0, f64::max);
    let low = all().map(|point| point.2[0]).fold(f64::INFINITY, f64::min);
    let wide = low > 0.0 && high / low > WIDE;
    let y = match wide {
        true => Axis::logarithmic(0.8 * low, 1.25 * high, measure.title()),
        false => Axis::new(0.0, 1.06 * high.max(1e-9), measure.title()),
    };
    let upright = |value: f64| if wide { value.log10() } else { value };
    let (name, unit) = words(over);
    let label = match unit.is_empty() {
        true => name,
        false => format!("{name} [{unit}]"),
    };
    let x = Axis::around(all().map(|point| point.0), 0.06, &label);
    canvas::draw(picture, 1600, 1100, |sheet| {
        sheet.title(&title(&lines, &series, over, measure))?;
        let entries: Vec<Entry> = lines
            .iter()
            .map(|line| Entry {
                stroke: Some(line.stroke),
                marker: Some((line.marker, line.stroke.colour)),
                text: line.name.clone(),
            })
            .collect();
        let height = legend(sheet, [190.0, 80.0], 1380.0, &entries)?;
        let axes = Axes::new(sheet, [190.0, 160.0 + height, 1550.0, 980.0], x, y);
        axes.grid()?;
        for (line, (_, points)) in lines.iter().zip(&series) {
            let curve: Vec<(f64, f64)> = points.iter().map(|p| (p.0, upright(p.1))).collect();
            let bars: Vec<(f64, f64, f64)> = points
                .iter()
                .filter(|p| p.2[1] > p.2[0])
                .map(|p| (p.0, upright(p.2[0]), upright(p.2[1])))
                .collect();
            axes.curve(&curve, line.stroke)?;
            axes.whiskers(&bars, line.stroke.colour)?;
            axes.markers(&curve, line.marker, 18.0, line.stroke.colour)?;
        }
        let over = summary
            .cells
            .first()
            .map_or(String::new(), CellScores::over);
        let note = if left_out > 0 {
            format!("; {left_out} lines left out")
        } else {
            String::new()
        };
        axes.finish(&format!("mean and 95 % interval over {over}{note}"))
    })
}
