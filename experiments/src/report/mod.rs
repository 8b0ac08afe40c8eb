//! The results of a study as one page that can be handed on: no script, font or picture from elsewhere.

pub(crate) mod localization;
mod papers;
mod replay;
mod study;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use base64::prelude::{BASE64_STANDARD, Engine};
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::data::json;
use crate::run::provenance::Provenance;

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

/// What a page says.
struct Content {
    title: String,
    about: String,
    body: Markup,
}

/// The page of a folder of results, of a study or of the papers' studies, for a file at `page`.
///
/// # Errors
/// When summary or data are missing or damaged.
pub fn page(results: &Path, page: &Path) -> Result<String> {
    let link = way(page, results)?;
    let summary: serde_json::Value = json::read(&results.join("summary.json"))?;
    // A study of cells has them in its summary.
    let content = match summary.get("cells").is_some() {
        true => study::content(results, &link)?,
        false => papers::content(results, &link)?,
    };
    Ok(document(content))
}

/// A figure as the page holds it: a drawing itself, a picture in base64.
fn picture(path: &Path) -> Result<Markup> {
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    if path.extension().is_some_and(|ending| ending == "svg") {
        return Ok(PreEscaped(String::from_utf8(bytes)?));
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let data = BASE64_STANDARD.encode(bytes);
    Ok(html! { img alt=(name) src=(format!("data:image/png;base64,{data}")); })
}

/// The whole page.
fn document(content: Content) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                (PreEscaped(MARK))
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (content.title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (content.title) }
                p { (content.about) }
                (content.body)
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    page.into_string()
}

/// Where the numbers come from.
fn provenance(from: &Provenance) -> Markup {
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
