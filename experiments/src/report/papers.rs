//! The page of the papers' studies.

use std::path::Path;

use anyhow::Result;
use maud::{Markup, html};

use super::{Content, picture, provenance, replay};
use crate::check::report::{count, ours};
use crate::check::targets::Targets;
use crate::check::verdicts::{Judged, Verdict, judge};
use crate::figures;
use crate::summary::{Summary, rows};

/// What the page of a folder of results says; links lead to `link`, where the folder is seen from the page.
///
/// # Errors
/// When summary or data are missing or damaged.
pub(super) fn content(results: &Path, link: &Path) -> Result<Content> {
    let summary = Summary::read(&results.join("summary.json"))?;
    // The report is there when the results have been compared with the claims.
    let judged = match results.join("report.md").exists() {
        true => Some(judge(&Targets::load()?, &summary)?),
        false => None,
    };
    let pictures = pictures(results)?;
    let replay = replay::of_papers(&results.join("data"))?;
    let at = |name: &str| link.join(name).display().to_string();
    let about = summary.study.as_ref().map(|file| file.about.clone());
    let body = html! {
        @if let Some(judged) = &judged {
            h2 { "Claims" }
            p { (count(judged)) ". How each is measured: " a href=(at("report.md")) { "report" } "." }
            (claims(judged))
        }
        h2 { "Figures" }
        @for picture in &pictures {
            figure { (picture) }
        }
        @if let Some(replay) = &replay {
            h2 { "Replay" }
            (replay.markup())
        }
        h2 { "Accuracies" }
        (accuracies(&summary, at))
        h2 { "Provenance" }
        (provenance(&summary.provenance))
        p {
            "Data: " a href=(at("data")) { "folder" } ", " a href=(at("summary.json")) { "summary" } "."
        }
        @if let Some(file) = &summary.study {
            details {
                summary { "The studies' file" }
                pre class="scroll" { (serde_json::to_string_pretty(file)?) }
            }
        }
    };
    Ok(Content {
        title: summary.name,
        about: about.unwrap_or_else(|| "Studies of the papers.".to_string()),
        body,
    })
}

/// The figures: drawings, and pictures where they show images.
fn pictures(results: &Path) -> Result<Vec<Markup>> {
    let temporary = tempfile::tempdir()?;
    let drawn = figures::draw_for_page(results, temporary.path())?;
    drawn.iter().map(|path| picture(path)).collect()
}

/// Claims, our numbers, and verdicts.
fn claims(judged: &[Judged]) -> Markup {
    html! {
        div class="scroll" {
            table {
                tr { th { "claim" } th { "source" } th { "claimed" } th { "ours" } th { "verdict" } }
                @for judged in judged {
                    tr {
                        td { (judged.target.claim) }
                        td { (judged.target.paper) ", " (judged.target.source) }
                        td { (judged.target.claimed) }
                        td { (ours(judged)) }
                        @match judged.verdict {
                            Verdict::Reproduced => td class="holds" { "reproduced" },
                            Verdict::NotReproduced => td class="fails" { "not reproduced" },
                            other => td { (other.name()) },
                        }
                    }
                }
            }
        }
    }
}

/// The accuracies, each linked to the file of its trials.
fn accuracies(summary: &Summary, at: impl Fn(&str) -> String) -> Markup {
    let rows = rows(summary);
    let (header, rows) = rows
        .split_first()
        .map_or((&[][..], &[][..]), |(h, r)| (h, r));
    html! {
        div class="scroll" {
            table {
                tr {
                    @for (column, name) in header.iter().enumerate() {
                        th class=[(column > 1).then_some("number")] { (name) }
                    }
                }
                @for row in rows {
                    tr {
                        @for (column, text) in row.iter().enumerate() {
                            @match column {
                                0 | 1 => td { (text) },
                                2 => td class="number" { a href=(at(data_of(&row[0]))) { (text) } },
                                _ => td class="number" { (text) },
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The file with the trials of a study, or the folder of its files.
fn data_of(study: &str) -> &'static str {
    match study {
        "odometry-drift" => "data/drift_paths.csv",
        "window-size" => "data/window_size.csv",
        "periods" => "data/periods.csv",
        "snr" => "data/snr.csv",
        "schemes" => "data/schemes.csv",
        "multipath" => "data/multipath.csv",
        "site" => "site/data",
        _ => "data",
    }
}
