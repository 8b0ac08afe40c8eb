//! The page of a study of cells.

use std::path::Path;

use anyhow::{Context, Result};
use maud::{Markup, html};

use super::{Content, picture, provenance, replay};
use crate::figures;
use crate::study::claims::{Kind, Verdict};
use crate::study::file::FigureChoice;
use crate::study::{CellScores, Study, StudySummary, cells};

/// What the page of a folder of results says; links lead to `link`, where the folder is seen from the page.
///
/// # Errors
/// When summary or data are missing or damaged.
pub(super) fn content(results: &Path, link: &Path) -> Result<Content> {
    let summary = StudySummary::read(&results.join("summary.json"))?;
    let study = Study::of_results(&summary.study).with_context(|| results.display().to_string())?;
    let data = |name: &str| link.join("data").join(name).display().to_string();
    let drawings = drawings(&study, &summary, results)?;
    let replay = replay::of_study(&results.join("data"))?;
    let body = html! {
        @if !summary.claims.is_empty() {
            h2 { "Claims" }
            (claims(&summary))
        }
        h2 { "Figures" }
        @for drawing in &drawings {
            figure { (drawing) }
        }
        @if let Some(replay) = &replay {
            h2 { "Replay" }
            (replay.markup())
        }
        h2 { "Scores" }
        (scores(&summary, &data("trials.csv")))
        h2 { "Provenance" }
        (provenance(&summary.provenance))
        p {
            "Data: " a href=(data("trials.csv")) { "every trial" } ", "
            a href=(data("distribution.csv")) { "distributions of the errors" } ", "
            a href=(link.join("summary.json").display().to_string()) { "summary" } "."
        }
        details {
            summary { "The study's file" }
            pre class="scroll" { (serde_json::to_string_pretty(&summary.study)?) }
        }
    };
    Ok(Content {
        title: summary.study.name,
        about: summary.study.about,
        body,
    })
}

/// The study's figures: drawings, pictures where they show images, and tables.
fn drawings(study: &Study, summary: &StudySummary, results: &Path) -> Result<Vec<Markup>> {
    let temporary = tempfile::tempdir()?;
    let drawn = figures::study::draw_into(study, results, temporary.path(), "svg")?;
    let mut tables = study
        .figures()
        .into_iter()
        .filter_map(|figure| match figure {
            FigureChoice::Table { measures } => {
                Some(figures::study::table::rows(summary, &measures))
            }
            _ => None,
        });
    let is_table = |path: &Path| path.extension().is_some_and(|ending| ending == "md");
    (drawn.iter())
        .map(
            |path| match is_table(path).then(|| tables.next()).flatten() {
                Some(rows) => Ok(table(&rows)),
                None => picture(path),
            },
        )
        .collect()
}

/// Rows as a table, their head first.
fn table(rows: &[Vec<String>]) -> Markup {
    let (head, rest) = rows.split_at(1.min(rows.len()));
    html! {
        div class="scroll" {
            table {
                @for row in head { tr { @for cell in row { th { (cell) } } } }
                @for row in rest { tr { @for cell in row { td { (cell) } } } }
            }
        }
    }
}

/// Claims, what came out, and verdicts.
fn claims(summary: &StudySummary) -> Markup {
    html! {
        div class="scroll" {
            table {
                tr { th { "claim" } th { "source" } th { "claimed" } th { "ours" } th { "verdict" } }
                @for (claim, judged) in summary.study.claims.iter().zip(&summary.claims) {
                    tr {
                        td { (claim.claim) }
                        td { (claim.source.as_deref().unwrap_or("")) }
                        td { (claim.claimed.as_deref().unwrap_or("")) }
                        td {
                            (judged.ours)
                            @if let Some([low, high]) = judged.interval {
                                (format!(" [{low:.3}, {high:.3}]"))
                            }
                        }
                        @match (judged.verdict, claim.kind) {
                            (Verdict::Holds, Kind::Reproducible) => td class="holds" { "holds" },
                            (Verdict::Holds, Kind::ByConstruction) => td { "holds by construction" },
                            (Verdict::Fails, _) => td class="fails" { "does not hold" },
                            (Verdict::NotTestable, _) => td { "cannot be tested" },
                        }
                    }
                }
            }
        }
    }
}

/// The scores of all cells and methods.
fn scores(summary: &StudySummary, trials: &str) -> Markup {
    let number = |cell: &CellScores, name: &str| {
        let mean = cell.mean.get(name);
        mean.map_or("\u{2013}".to_string(), |mean| format!("{mean:.4}"))
    };
    html! {
        div class="scroll" {
            table {
                tr {
                    th { "cell" } th { "method" }
                    th class="number" { "MAE [m]" } th class="number" { "95 % interval [m]" }
                    th class="number" { "90 % below [m]" } th class="number" { "heading [rad]" }
                    th { "interval over" }
                }
                @for cell in &summary.cells {
                    tr {
                        td { @if cell.labels.is_empty() { "all" } @else { (cells::all_in_words(&cell.labels)) } }
                        td { (cell.method.name()) }
                        td class="number" { a href=(trials) { (number(cell, "mae_m")) } }
                        td class="number" {
                            @if let Some([low, high]) = cell.interval.get("mae_m") {
                                (format!("{low:.4} to {high:.4}"))
                            }
                        }
                        td class="number" { (number(cell, "p90_m")) }
                        td class="number" { (number(cell, "heading_mae_rad")) }
                        td {
                            (cell.over())
                            @if cell.failed > 0 { (format!("; {} of {} failed", cell.failed, cell.trials)) }
                        }
                    }
                }
            }
        }
    }
}
