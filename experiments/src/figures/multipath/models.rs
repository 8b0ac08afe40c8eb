//! Styles, legends and mean errors of the models, shared by the figures of room and scene.

use anyhow::Result;

use crate::data::table::Table;
use crate::figures::drawing::axes::Axes;
use crate::figures::drawing::canvas::{Canvas, LABEL};
use crate::figures::drawing::colour;
use crate::figures::drawing::legend::{Entry, legend};
use crate::figures::drawing::stroke::Stroke;
use crate::figures::drawing::style::method_style;
use crate::metrics::mean;

/// Style of a model's line, and its name.
pub(super) fn style(method: &str) -> (Stroke, &'static str) {
    match method {
        "single" => (
            Stroke::solid(colour::PURPLE, 5.0).dashed(&[14.0, 8.0, 4.0, 8.0, 4.0, 8.0]),
            "(a) single echoes",
        ),
        "planar" => (
            Stroke::solid(colour::ORANGE, 5.0).dashed(&[22.0, 9.0, 5.0, 9.0]),
            "(b) single and double, in the plane",
        ),
        "spatial" => (
            Stroke::solid(colour::GREEN, 5.0).dashed(&[22.0, 9.0]),
            "(c) with ceiling and floor",
        ),
        other => method_style(other),
    }
}

/// Columns `x` and `y` as points.
pub(super) fn points(table: &Table, x: &str, y: &str) -> Result<Vec<(f64, f64)>> {
    Ok(table
        .numbers(x)?
        .into_iter()
        .zip(table.numbers(y)?)
        .collect())
}

/// The letter of a model with its brackets, or the method's name.
pub(super) fn short(method: &str) -> &'static str {
    let name = style(method).1;
    name.split_inclusive(')').next().unwrap_or(name)
}

/// Mean error of a method over all trials, if it has any.
pub(super) fn mean_error(table: &Table, method: &str) -> Result<Option<f64>> {
    let rows = table.only("method", method)?;
    Ok(match rows.is_empty() {
        true => None,
        false => Some(mean(&rows.numbers("error_m")?)),
    })
}

/// Lists the mean errors of the methods that the table has.
pub(super) fn mean_errors_of(table: &Table, methods: &[&str]) -> Result<String> {
    let mut parts = Vec::new();
    for method in methods {
        if let Some(error) = mean_error(table, method)? {
            parts.push(format!("{} {error:.3} m", short(method)));
        }
    }
    Ok(parts.join(", "))
}

/// Draws one trial of each method into a map; returns the legend's entries.
pub(super) fn one_trial(
    axes: &Axes<'_>,
    table: &Table,
    trial: &str,
    methods: &[&str],
) -> Result<Vec<Entry>> {
    let mut entries = Vec::new();
    for method in methods {
        let rows = table.only("method", method)?;
        if rows.is_empty() {
            continue;
        }
        let (stroke, name) = style(method);
        axes.curve(&points(&rows.only("trial", trial)?, "x_m", "y_m")?, stroke)?;
        entries.push(Entry::line(stroke, name));
    }
    Ok(entries)
}

/// Lists entries one below the other, then notes.
pub(super) fn column(sheet: &Canvas, entries: Vec<Entry>, notes: &[&str]) -> Result<()> {
    let mut y = 150.0;
    for entry in entries {
        y += legend(sheet, [1060.0, y], 520.0, &[entry])? + 14.0;
    }
    for note in notes {
        sheet.text(note, [1060.0, y + 30.0], (1, 0), LABEL - 3.0, false, false)?;
        y += 46.0;
    }
    Ok(())
}
