//! The replay of a drive: paths as data of the page's slider.

use std::path::Path;

use anyhow::Result;
use localizer::pose::wrap_angle;
use maud::{Markup, PreEscaped, html};
use serde::Serialize;

use crate::data::json;
use crate::data::layout::{Layout, LayoutWall};
use crate::data::table::Table;
use crate::figures::drawing::style::method_style;
use crate::metrics::rounded;

/// A drive: the truth first, then estimates.
#[derive(Debug, Serialize)]
pub(super) struct Replay {
    #[serde(skip)]
    name: String,
    size_m: [f64; 2],
    walls: Vec<LayoutWall>,
    tracks: Vec<Track>,
}

/// A path over time.
#[derive(Debug, Serialize)]
struct Track {
    name: &'static str,
    colour: String,
    t_s: Vec<f64>,
    x_m: Vec<f64>,
    y_m: Vec<f64>,
    heading_rad: Vec<f64>,
    error_m: Vec<f64>,
}

/// The first drive whose paths a study has written; `None` when it draws none.
///
/// # Errors
/// When a data file is damaged.
pub(super) fn of_study(data: &Path) -> Result<Option<Replay>> {
    let file = data.join("paths_0.csv");
    if !file.exists() {
        return Ok(None);
    }
    let layout: Layout = json::read(&data.join("layout_0.json"))?;
    let table = Table::read(&file)?;
    let tracks = table
        .distinct("method")?
        .iter()
        .map(|method| track(&table, method))
        .collect::<Result<Vec<_>>>()?;
    Ok((tracks.len() > 1).then_some(Replay {
        name: layout.name,
        size_m: layout.size_m,
        walls: layout.walls,
        tracks,
    }))
}

/// The localization drive of the papers' studies by all methods; `None` where it was not studied.
///
/// # Errors
/// When a data file is damaged.
pub(super) fn of_papers(data: &Path) -> Result<Option<Replay>> {
    let names = ["layout.json", "drive.csv", "drift_paths.csv"].map(|name| data.join(name));
    if !names.iter().all(|file| file.exists()) {
        return Ok(None);
    }
    let layout = Layout::read(data)?;
    let table = Table::read(&names[2])?.only("trial", "0")?;
    let mut tracks = Vec::new();
    for method in table.distinct("method")? {
        let found = track(&table, &method)?;
        if tracks.is_empty() {
            tracks.push(truth(&Table::read(&names[1])?, &found.t_s)?);
        }
        tracks.push(found);
    }
    Ok((tracks.len() > 1).then_some(Replay {
        name: layout.name,
        size_m: layout.size_m,
        walls: layout.walls,
        tracks,
    }))
}

/// The true path of the localization drive at some times, between the rows of `drive.csv`.
fn truth(drive: &Table, t_s: &[f64]) -> Result<Track> {
    let rows = drive.only("path", "localization")?;
    let times = rows.numbers("t_s")?;
    let heading = rows.numbers("heading_rad")?;
    let (x, y) = (rows.numbers("x_m")?, rows.numbers("y_m")?);
    let mut track = Track {
        name: method_style("truth").1,
        colour: "var(--ink)".to_string(),
        t_s: t_s.to_vec(),
        x_m: Vec::new(),
        y_m: Vec::new(),
        heading_rad: Vec::new(),
        error_m: vec![0.0; t_s.len()],
    };
    for &t in t_s {
        let next = times
            .partition_point(|&time| time <= t)
            .clamp(1, times.len().max(2) - 1);
        let (before, after) = (next - 1, next.min(times.len() - 1));
        let way = (times[after] - times[before]).max(1e-9);
        let share = ((t - times[before]) / way).clamp(0.0, 1.0);
        let between = |from: f64, to: f64| rounded(from + share * (to - from));
        track.x_m.push(between(x[before], x[after]));
        track.y_m.push(between(y[before], y[after]));
        let turn = wrap_angle(heading[after] - heading[before]);
        track
            .heading_rad
            .push(rounded(heading[before] + share * turn));
    }
    Ok(track)
}

/// The path of a method.
fn track(table: &Table, method: &str) -> Result<Track> {
    let rows = table.only("method", method)?;
    let (stroke, name) = method_style(method);
    let plotters::style::RGBColor(r, g, b) = stroke.colour;
    let numbers = |column: &str| -> Result<Vec<f64>> {
        Ok(rows.numbers(column)?.into_iter().map(rounded).collect())
    };
    Ok(Track {
        name,
        colour: match method {
            "truth" => "var(--ink)".to_string(),
            _ => format!("#{r:02x}{g:02x}{b:02x}"),
        },
        t_s: numbers("t_s")?,
        x_m: numbers("x_m")?,
        y_m: numbers("y_m")?,
        heading_rad: numbers("heading_rad")?,
        error_m: numbers("error_m")?,
    })
}

impl Replay {
    /// Map, errors and slider.
    pub(super) fn markup(&self) -> Markup {
        let steps = self.tracks[0].t_s.len().saturating_sub(1);
        // A text in a script must not end it.
        let data = serde_json::to_string(self)
            .unwrap_or_default()
            .replace('<', "\\u003c");
        html! {
            div class="replay" {
                p {
                    "The first trial of each method in " (self.name) ". Move the slider, or press the arrow keys on "
                    "it; a link may end in #t= and seconds."
                }
                p class="keys" {
                    @for track in &self.tracks {
                        span style=(format!("--colour:{}", track.colour)) { (track.name) }
                    }
                }
                svg class="map" role="img" aria-label="Walls, paths and robot" {}
                input type="range" min="0" max=(steps) value="0" aria-label="Time in the drive";
                output {}
                p { "Error over time, up to " span class="most" {} }
                svg class="errors" role="img" aria-label="Error over time" {}
                script type="application/json" { (PreEscaped(data)) }
            }
        }
    }
}
