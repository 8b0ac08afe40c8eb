//! The page of a localization: how well it went, and its replay.

use maud::html;

use super::replay::{Replay, Track};
use super::{Content, document, provenance};
use crate::data::frames::Frames;
use crate::figures::drawing::colour;
use crate::figures::localization::{Background, Localization};
use crate::run::provenance::Provenance;

/// Name of the estimated path.
pub(crate) const ESTIMATE: &str = "estimate";

/// Space around the paths, in metres.
const MARGIN_M: f64 = 2.0;

/// What a page says beside paths and map.
pub(crate) struct Words<'a> {
    /// Title and the sentence under it.
    pub(crate) title: String,
    pub(crate) about: String,
    /// Names and numbers of the table.
    pub(crate) rows: Vec<[String; 2]>,
    /// What each estimate says of itself.
    pub(crate) status: Vec<&'a str>,
}

/// The page of a localization, where no results are beside it.
pub(crate) fn page(shown: &Localization<'_>, mut frames: Frames, words: Words<'_>) -> String {
    let truth = shown
        .truth
        .filter(|_| !shown.path.t_s.is_empty())
        .map(|truth| localizer::Trajectory {
            t_s: shown.path.t_s.clone(),
            poses: truth.poses_at(shown.path.t_s.iter().copied()),
        });
    let truth = truth.as_ref();
    let mut tracks = Vec::new();
    tracks.extend(truth.map(|truth| Track::of("truth", "var(--ink)".into(), truth, None)));
    let mut estimate = Track::of(ESTIMATE, colour::css(colour::BLUE), shown.path, truth);
    estimate.status = words.status.iter().map(ToString::to_string).collect();
    tracks.push(estimate);
    let wheels = colour::css(colour::VERMILLION);
    tracks.push(Track::of("wheels alone", wheels, shown.wheels, truth));
    match shown.map {
        Background::Image(map) => frames.put_map(map),
        // Without a map they became known in the course of the drive.
        Background::Landmarks(map) if frames.knows_nothing() => frames.know(0.0, map),
        Background::Landmarks(_) => {}
    }
    let replay = Replay::around("This drive".into(), tracks, MARGIN_M, frames.finish());
    let body = html! {
        div class="scroll" {
            table {
                @for [name, value] in &words.rows {
                    tr { th { (name) } td { (value) } }
                }
            }
        }
        h2 { "Replay" }
        (replay.markup())
        h2 { "Provenance" }
        (provenance(&Provenance::here()))
    };
    document(Content {
        title: words.title,
        about: words.about,
        body,
    })
}
