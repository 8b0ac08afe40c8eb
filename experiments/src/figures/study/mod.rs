//! Figures of a study file, from its summary and data alone.

mod bars;
mod curve;
mod differences;
mod distribution;
mod map;
mod paths;
mod rows;
pub(crate) mod table;

use std::path::{Path, PathBuf};

use anyhow::Result;
use plotters::style::RGBColor;

use super::drawing::colour;
use super::drawing::stroke::{Marker, Stroke};
use super::drawing::style::method_style;
use crate::data::atomic;
use crate::data::table::markdown;
use crate::study::cells::short;
use crate::study::file::{FigureChoice, MethodName};
use crate::study::{Study, StudySummary};

pub(crate) use self::differences::draw as draw_differences;

/// Most lines of one figure; more cannot be told apart.
const MOST_LINES: usize = 12;

/// A line of a figure.
struct Line {
    name: String,
    stroke: Stroke,
    marker: Marker,
}

/// Styles of lines: those of the methods where each line is a method; the methods' colours, a dash for each cell, where
/// there are several methods in a few cells; else colours and dashes in turn.
fn lines(names: &[(MethodName, String)]) -> Vec<Line> {
    const COLOURS: [RGBColor; 7] = [
        colour::BLUE,
        colour::ORANGE,
        colour::GREEN,
        colour::VERMILLION,
        colour::SKY,
        colour::PURPLE,
        colour::GREY,
    ];
    const DASHES: [&[f64]; 3] = [&[], &[22.0, 9.0], &[6.0, 9.0]];
    const MARKERS: [Marker; 4] = [
        Marker::Disc,
        Marker::Triangle,
        Marker::Square,
        Marker::Diamond,
    ];
    let methods_only = names.iter().all(|(_, cell)| cell.is_empty());
    let several = names.iter().any(|(method, _)| *method != names[0].0);
    let mut cells: Vec<&String> = Vec::new();
    for (_, cell) in names {
        if !cells.contains(&cell) {
            cells.push(cell);
        }
    }
    let few = several && cells.len() <= DASHES.len();
    names
        .iter()
        .enumerate()
        .map(|(index, (method, cell))| {
            let (style, word) = method_style(method.name());
            let number = cells.iter().position(|known| *known == cell).unwrap_or(0);
            let stroke = match (methods_only, few) {
                (true, _) => style,
                (false, true) => Stroke::solid(style.colour, 4.5).dashed(DASHES[number]),
                (false, false) => Stroke::solid(COLOURS[index % COLOURS.len()], 4.5)
                    .dashed(DASHES[index / COLOURS.len() % DASHES.len()]),
            };
            let name = match (cell.is_empty(), several) {
                (true, _) => word.to_string(),
                (false, false) => cell.clone(),
                (false, true) => format!("{word}, {cell}"),
            };
            Line {
                name,
                stroke,
                marker: MARKERS[index % MARKERS.len()],
            }
        })
        .collect()
}

/// A number with as many digits as it needs.
fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_string(),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 1.0 => format!("{value:.2}"),
        size if size >= 0.02 => format!("{value:.3}"),
        _ => format!("{value:.4}"),
    }
}

/// Draws the figures of a study from its folder of results.
///
/// # Errors
/// When a data file is missing or damaged, or a picture cannot be written.
pub fn draw(study: &Study, results: &Path) -> Result<Vec<PathBuf>> {
    draw_into(study, results, &results.join("figures"), "png")
}

/// As [`draw`], into a folder, as PNG or SVG.
///
/// # Errors
/// As [`draw`].
pub(crate) fn draw_into(
    study: &Study,
    results: &Path,
    figures: &Path,
    ending: &str,
) -> Result<Vec<PathBuf>> {
    let summary = StudySummary::read(&results.join("summary.json"))?;
    let data = results.join("data");
    let mut drawn = Vec::new();
    let (mut paths, mut maps, mut tables) = (0, 0, 0);
    for figure in study.figures() {
        let picture = |name: &str| figures.join(format!("{name}.{ending}"));
        match &figure {
            FigureChoice::Curve { over, measure } => {
                let picture = picture(&format!("{}_over_{}", measure.name(), short(over)));
                curve::draw(&summary, over, *measure, &picture)?;
                drawn.push(picture);
            }
            FigureChoice::Bars { measure } => {
                let picture = picture(&format!("{}_bars", measure.name()));
                bars::draw(&summary, *measure, &picture)?;
                drawn.push(picture);
            }
            FigureChoice::Cdf {} => {
                let picture = picture("error_cdf");
                distribution::draw(study, &data, &picture)?;
                drawn.push(picture);
            }
            FigureChoice::Paths { .. } => {
                // A cell that was not run has none.
                if data.join(format!("paths_{paths}.csv")).exists() {
                    let picture = picture(&format!("paths_{paths}"));
                    paths::draw(&data, paths, &picture)?;
                    drawn.push(picture);
                }
                paths += 1;
            }
            FigureChoice::Map { .. } => {
                drawn.extend(map::draw(&data, maps, figures, ending)?);
                maps += 1;
            }
            FigureChoice::Table { measures } => {
                let file = figures.join(format!("table_{tables}.md"));
                let text = markdown(&table::rows(&summary, measures));
                atomic::write(&file, text.as_bytes())?;
                tables += 1;
                drawn.push(file);
            }
        }
    }
    Ok(drawn)
}
