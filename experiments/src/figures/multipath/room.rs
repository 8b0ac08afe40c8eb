//! Multipath arrival times (2021, Fig. 3): paths and errors of the three models in a room.

use std::path::Path;

use anyhow::Result;

use super::models::{column, mean_errors_of, one_trial, points, short, style};
use crate::data::table::Table;
use crate::figures::drawing::axes::Axes;
use crate::figures::drawing::axis::Axis;
use crate::figures::drawing::canvas;
use crate::figures::drawing::colour;
use crate::figures::drawing::layout::path;
use crate::figures::drawing::legend::{Entry, legend};
use crate::figures::drawing::stroke::Stroke;
use crate::figures::drawing::style::method_style;
use crate::figures::means::means_by;
use crate::metrics::mean;

/// Mean error of model (c) in the paper's experiment, metres.
const PAPER_M: f64 = 0.085;

/// Mean errors of a model over the gate: its name, and gate, mean and interval in metres.
type OverGates<'a> = (&'a str, Vec<(f64, f64, [f64; 2])>);

/// The title: up to which gate each model stays below the paper's error.
fn gates_title(cells: &[OverGates<'_>]) -> String {
    let parts: Vec<String> = cells
        .iter()
        .map(|(method, means)| {
            let below = means.iter().take_while(|cell| cell.1 < PAPER_M).last();
            match below {
                Some(cell) => format!("{} to {:.2} m", short(method), cell.0),
                None => format!("{} never", short(method)),
            }
        })
        .collect();
    format!(
        "Gates that keep below the paper's {PAPER_M} m: {}",
        parts.join(", ")
    )
}

/// The gate at which the means over the gates are nearest to the `means` of the same methods.
fn nearest_gate(cells: &[OverGates<'_>], means: &[(&str, f64)]) -> Option<f64> {
    let gates = cells.first()?.1.iter().map(|cell| cell.0);
    let away = |gate: f64| -> f64 {
        let pairs = cells.iter().filter_map(|(method, row)| {
            let (_, wanted) = means.iter().find(|(name, _)| name == method)?;
            let cell = row.iter().find(|cell| cell.0 == gate)?;
            Some((cell.1 - wanted).abs())
        });
        pairs.sum()
    };
    gates.min_by(|a, b| away(*a).total_cmp(&away(*b)))
}

/// The trial whose mean error by model (b) is the median one of all trials.
fn median_trial(table: &Table) -> Result<String> {
    let rows = table.only("method", "planar")?;
    let mut trials = Vec::new();
    for trial in rows.distinct("trial")? {
        let errors = rows.only("trial", &trial)?.numbers("error_m")?;
        trials.push((mean(&errors), trial));
    }
    trials.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = trials.len() / 2;
    Ok(trials.into_iter().nth(middle).unwrap_or_default().1)
}

/// Draws the paths in the room.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn paths(data: &Path, picture: &Path) -> Result<()> {
    let table = Table::read(&data.join("multipath.csv"))?;
    let truth = points(
        &Table::read(&data.join("multipath_drive.csv"))?,
        "x_m",
        "y_m",
    )?;
    let mut room = points(
        &Table::read(&data.join("multipath_room.csv"))?,
        "x_m",
        "y_m",
    )?;
    room.extend(room.first().copied());
    canvas::draw(picture, 1660, 1040, |sheet| {
        let models = mean_errors_of(&table, &["single", "planar", "spatial"])?;
        sheet.title(&format!("Mean error of all trials: {models}"))?;
        let around = |pick: fn(&(f64, f64)) -> f64, label: &str| {
            Axis::around(room.iter().map(pick), 0.05, label)
        };
        let axes = Axes::equal(
            sheet,
            [120.0, 130.0, 1010.0, 930.0],
            around(|point| point.0, "x [m]"),
            around(|point| point.1, "y [m]"),
        );
        axes.grid()?;
        axes.curve(&room, Stroke::solid(colour::GREY, 8.0))?;
        let (black, name) = method_style("truth");
        let mut entries = vec![Entry::line(black, name)];
        path(&axes, &truth, black)?;
        let trial = median_trial(&table)?;
        let methods = ["odometry", "single", "planar", "spatial"];
        entries.extend(one_trial(&axes, &table, &trial, &methods)?);
        axes.finish("estimated positions, one trial")?;
        let mut cut = Vec::new();
        for method in methods {
            let rows = table.only("method", method)?.only("trial", &trial)?;
            if points(&rows, "x_m", "y_m")?
                .iter()
                .any(|(x, y)| !axes.holds(*x, *y))
            {
                cut.push(short(method));
            }
        }
        let mut notes = vec!["The trial with the median error of (b)."];
        let leaves = format!("Cut at the frame: {}.", cut.join(", "));
        if !cut.is_empty() {
            notes.push(&leaves);
        }
        notes.push("\u{25cf} start   \u{25a0} end   grey: walls");
        column(sheet, entries, &notes)
    })
}

/// Mean over the trials of the error at each time.
fn mean_errors(rows: &Table) -> Result<Vec<(f64, f64)>> {
    let mut times: Vec<(f64, Vec<f64>)> = Vec::new();
    for trial in rows.distinct("trial")? {
        let curve = points(&rows.only("trial", &trial)?, "t_s", "error_m")?;
        for (index, (t_s, error)) in curve.into_iter().enumerate() {
            match times.get_mut(index) {
                Some((_, errors)) => errors.push(error),
                None => times.push((t_s, vec![error])),
            }
        }
    }
    Ok(times
        .into_iter()
        .map(|(t_s, errors)| (t_s, mean(&errors)))
        .collect())
}

/// Draws the errors in the room over time and over the gate.
///
/// # Errors
/// When a data file is missing or damaged, or the picture cannot be written.
pub(crate) fn errors(data: &Path, picture: &Path) -> Result<()> {
    let table = Table::read(&data.join("multipath.csv"))?;
    let mut curves = Vec::new();
    for method in ["odometry", "single", "planar", "spatial"] {
        let rows = table.only("method", method)?;
        if !rows.is_empty() {
            curves.push((method, mean_errors(&rows)?, mean(&rows.numbers("error_m")?)));
        }
    }
    let all = || curves.iter().flat_map(|(_, curve, _)| curve);
    let highest = all().map(|point| point.1).fold(0.1, f64::max);
    let longest = all().map(|point| point.0).fold(0.0, f64::max);
    let gates = Table::read(&data.join("multipath_gates.csv"))?;
    canvas::draw(picture, 1800, 1040, |sheet| {
        let cells = ["single", "planar", "spatial"]
            .iter()
            .map(|method| {
                let rows = gates.only("method", method)?;
                Ok((*method, means_by(&rows, "gate_m", "mae_m")?))
            })
            .collect::<Result<Vec<OverGates<'_>>>>()?;
        sheet.title(&gates_title(&cells))?;
        let left = Axes::new(
            sheet,
            [150.0, 270.0, 900.0, 925.0],
            Axis::new(0.0, longest, "time [s]"),
            Axis::new(0.0, 1.05 * highest, "position error [m]"),
        );
        left.grid()?;
        let paper = Stroke::solid(colour::GREY, 3.5);
        left.curve(&[(0.0, PAPER_M), (longest, PAPER_M)], paper)?;
        let mut entries = Vec::new();
        for (method, curve, error) in &curves {
            let (stroke, name) = style(method);
            left.curve(curve, stroke)?;
            entries.push(Entry::line(stroke, &format!("{name}: {error:.3} m")));
        }
        entries.push(Entry::line(paper, &format!("paper, (c): {PAPER_M} m")));
        let means: Vec<(&str, f64)> = curves.iter().map(|curve| (curve.0, curve.2)).collect();
        let gate = nearest_gate(&cells, &means);
        let gate = gate.map_or(String::new(), |gate_m| format!(", gate {gate_m:.2} m"));
        left.finish(&format!("error over time, mean of all trials{gate}"))?;
        let all = || cells.iter().flat_map(|(_, means)| means);
        let highest = all().map(|cell| cell.2[1]).fold(0.1, f64::max);
        let widest = all().map(|cell| cell.0).fold(0.1, f64::max);
        let right = Axes::new(
            sheet,
            [1060.0, 270.0, 1750.0, 925.0],
            Axis::new(0.0, 1.05 * widest, "gate of the association [m]"),
            Axis::new(0.0, 1.05 * highest, "MAE of position [m]"),
        );
        right.grid()?;
        right.curve(&[(0.0, PAPER_M), (1.05 * widest, PAPER_M)], paper)?;
        for (method, means) in &cells {
            let (stroke, _) = style(method);
            let curve: Vec<(f64, f64)> = means.iter().map(|cell| (cell.0, cell.1)).collect();
            let bars: Vec<_> = means
                .iter()
                .map(|cell| (cell.0, cell.2[0], cell.2[1]))
                .collect();
            right.curve(&curve, stroke)?;
            right.whiskers(&bars, stroke.colour)?;
        }
        right.finish("mean error over the gate, bars: 95 % interval")?;
        legend(sheet, [150.0, 78.0], 1620.0, &entries)?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn title_and_gate_follow_from_the_means() {
        let row = |means: [f64; 3]| {
            let gates = [0.2, 0.25, 0.3];
            let cells = gates.iter().zip(means);
            cells.map(|(gate, mean)| (*gate, mean, [mean; 2])).collect()
        };
        let cells: Vec<OverGates<'_>> = vec![
            ("single", row([0.1, 1.1, 0.9])),
            ("planar", row([0.03, 0.13, 0.05])),
            ("spatial", row([0.01, 0.02, 0.08])),
        ];
        assert_eq!(
            gates_title(&cells),
            "Gates that keep below the paper's 0.085 m: (a) never, (b) to 0.20 m, (c) to 0.30 m"
        );
        let means = [("single", 1.1), ("spatial", 0.021), ("odometry", 0.6)];
        assert_eq!(nearest_gate(&cells, &means), Some(0.25));
    }
}
