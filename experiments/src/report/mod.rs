//! The results of a study as one page that can be handed on: no script, font or picture from elsewhere.

mod replay;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::figures;
use crate::study::claims::{Kind, Verdict};
use crate::study::{CellScores, Study, StudySummary, cells};

const STYLE: &str = include_str!("../../assets/report.css");
const SCRIPT: &str = include_str!("../../assets/report.js");

/// First letters of every report, after the type of the document.
pub const MARK: &str = "<meta name=\"generator\" content=\"echolot\">";

/// Whether bytes are a report of this program.
pub fn is_ours(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(400)];
    String::from_utf8_lossy(head).contains(MARK)
}

/// The way from the folder of a page to another folder, for links.
fn way(page: &Path, folder: &Path) -> Result<PathBuf> {
    let from = std::path::absolute(page)?;
    let to = std::path::absolute(folder)?;
    let from: Vec<_> = from
        .parent()
        .unwrap_or(Path::new("/"))
        .components()
        .collect();
    let to: Vec<_> = to.components().collect();
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n("..", from.len() - shared);
    Ok(up
        .map(PathBuf::from)
        .chain(to[shared..].iter().map(PathBuf::from))
        .collect())
}

/// The page of a study's folder of results, for a file at `page`.
///
/// # Errors
/// When summary or data are missing or damaged.
pub fn page(results: &Path, page: &Path) -> Result<String> {
    let summary = StudySummary::read(&results.join("summary.json"))?;
    let study = Study::of_results(&summary.study).with_context(|| results.display().to_string())?;
    let link = way(page, results)?;
    let data = |name: &str| link.join("data").join(name).display().to_string();
    let drawings = drawings(&study, results)?;
    let replay = replay::read(&results.join("data"))?;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                (PreEscaped(MARK))
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (summary.study.name) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (summary.study.name) }
                p { (summary.study.about) }
                @if !summary.claims.is_empty() {
                    h2 { "Claims" }
                    (claims(&summary))
                }
                h2 { "Figures" }
                @for drawing in &drawings {
                    figure { (PreEscaped(drawing)) }
                }
                @if let Some(replay) = &replay {
                    h2 { "Replay" }
                    (replay.markup())
                }
                h2 { "Scores" }
                (scores(&summary, &data("trials.csv")))
                h2 { "Provenance" }
                (provenance(&summary))
                p {
                    "Data: " a href=(data("trials.csv")) { "every trial" } ", "
                    a href=(data("distribution.csv")) { "distributions of the errors" } ", "
                    a href=(link.join("summary.json").display().to_string()) { "summary" } "."
                }
                details {
                    summary { "The study's file" }
                    pre class="scroll" { (serde_json::to_string_pretty(&summary.study)?) }
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    Ok(page.into_string())
}

/// The study's figures as SVG.
fn drawings(study: &Study, results: &Path) -> Result<Vec<String>> {
    let temporary = tempfile::tempdir()?;
    figures::study::draw_into(study, results, temporary.path(), "svg")?
        .iter()
        .map(|path| std::fs::read_to_string(path).with_context(|| path.display().to_string()))
        .collect()
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

/// Where the numbers come from.
fn provenance(summary: &StudySummary) -> Markup {
    let from = &summary.provenance;
    html! {
        div class="scroll" {
            table {
                tr { th { "revision" } td { (from.commit) @if from.dirty { " and changes" } } }
                tr { th { "program" } td { "echolot " (from.version) ", " (from.toolchain) } }
                tr { th { "machine" } td { (from.cpu) ", " (from.threads) " threads" } }
                @for (stage, seconds) in &from.seconds {
                    tr { th { (stage) } td { (format!("{seconds:.1} s")) } }
                }
                tr { th { "memory" } td { (format!("{:.0} MiB at most", from.peak_memory_mib)) } }
            }
        }
    }
}
