//! The replay of a drive: paths as data of the page's slider.

use std::path::Path;

use anyhow::Result;
use localizer::Trajectory;
use localizer::pose::wrap_angle;
use maud::{Markup, PreEscaped, html};
use serde::Serialize;

use crate::data::frames::{FRAMES, Frames};
use crate::data::json;
use crate::data::layout::{Layout, LayoutWall};
use crate::data::table::Table;
use crate::figures::drawing::colour;
use crate::figures::drawing::style::method_style;
use crate::metrics::rounded;

/// A drive: the truth first, then estimates.
#[derive(Debug, Serialize)]
pub(super) struct Replay {
    #[serde(skip)]
    name: String,
    /// Least x and y, and size of what is shown.
    low_m: [f64; 2],
    size_m: [f64; 2],
    walls: Vec<LayoutWall>,
    tracks: Vec<Track>,
    /// What was heard and believed, and the number of the track that believed it.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<Frames>,
    watched: usize,
}

/// A path over time.
#[derive(Debug, Default, Serialize)]
pub(super) struct Track {
    name: &'static str,
    colour: String,
    t_s: Vec<f64>,
    x_m: Vec<f64>,
    y_m: Vec<f64>,
    heading_rad: Vec<f64>,
    /// Distances from the truth; none of the truth itself, or where it is not known.
    error_m: Vec<f64>,
    /// What each pose says of itself, where it says something.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) status: Vec<String>,
}

impl Track {
    /// A path whose errors are distances from `truth`, a path over the same time.
    pub(super) fn of(
        name: &'static str,
        colour: String,
        path: &Trajectory,
        truth: Option<&Trajectory>,
    ) -> Self {
        let numbers = |of: fn(&localizer::Pose) -> f64| path.poses.iter().map(of).map(rounded);
        let true_poses = truth.map(|truth| truth.poses_at(path.t_s.iter().copied()));
        let pairs = true_poses.iter().flatten().zip(&path.poses);
        Self {
            name,
            colour,
            t_s: path.t_s.iter().copied().map(rounded).collect(),
            x_m: numbers(|pose| pose.x_m).collect(),
            y_m: numbers(|pose| pose.y_m).collect(),
            heading_rad: numbers(|pose| pose.heading_rad).collect(),
            error_m: pairs
                .map(|(truth, pose)| rounded(pose.distance_m(truth)))
                .collect(),
            status: Vec::new(),
        }
    }
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
    let frames = frames(&data.join(FRAMES))?;
    let table = Table::read(&file)?;
    let tracks = table
        .distinct("method")?
        .iter()
        .map(|method| track(&table, method))
        .collect::<Result<Vec<_>>>()?;
    Ok((tracks.len() > 1).then_some(Replay {
        name: format!("The first trial of each method in {}", layout.name),
        low_m: [0.0; 2],
        size_m: layout.size_m,
        walls: layout.walls,
        watched: watched(&frames, &tracks),
        tracks,
        frames,
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
    let frames = frames(&data.join(FRAMES))?;
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
        name: format!("The first trial of each method in {}", layout.name),
        low_m: [0.0; 2],
        size_m: layout.size_m,
        walls: layout.walls,
        watched: watched(&frames, &tracks),
        tracks,
        frames,
    }))
}

/// The number of the track that heard and believed what the frames show.
fn watched(frames: &Option<Frames>, tracks: &[Track]) -> usize {
    let of = |frames: &Frames| {
        let name = method_style(&frames.method).1;
        tracks.iter().position(|track| track.name == name)
    };
    frames.as_ref().and_then(of).unwrap_or(0)
}

/// What was heard and believed; `None` where it was not written.
fn frames(file: &Path) -> Result<Option<Frames>> {
    match file.exists() {
        true => json::read(file).map(Some),
        false => Ok(None),
    }
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
        ..Track::default()
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
    let numbers = |column: &str| -> Result<Vec<f64>> {
        Ok(rows.numbers(column)?.into_iter().map(rounded).collect())
    };
    Ok(Track {
        name,
        colour: match method {
            "truth" => "var(--ink)".to_string(),
            _ => colour::css(stroke.colour),
        },
        t_s: numbers("t_s")?,
        x_m: numbers("x_m")?,
        y_m: numbers("y_m")?,
        heading_rad: numbers("heading_rad")?,
        error_m: match method {
            "truth" => Vec::new(),
            _ => numbers("error_m")?,
        },
        status: Vec::new(),
    })
}

impl Replay {
    /// A drive without known walls, with so much space around its paths.
    pub(super) fn around(name: String, tracks: Vec<Track>, margin_m: f64, frames: Frames) -> Self {
        let reach = |of: fn(&Track) -> &Vec<f64>| {
            let all = || tracks.iter().flat_map(of).copied();
            let low = all().fold(f64::INFINITY, f64::min) - margin_m;
            let high = all().fold(f64::NEG_INFINITY, f64::max) + margin_m;
            match low.is_finite() && high.is_finite() {
                true => [rounded(low), rounded(high - low)],
                false => [0.0, 1.0],
            }
        };
        let [x, y] = [reach(|track| &track.x_m), reach(|track| &track.y_m)];
        Self {
            watched: (tracks.iter())
                .position(|track| track.name == frames.method)
                .unwrap_or(0),
            name,
            low_m: [x[0], y[0]],
            size_m: [x[1], y[1]],
            walls: Vec::new(),
            tracks,
            frames: Some(frames),
        }
    }

    /// Map, errors and slider.
    pub(super) fn markup(&self) -> Markup {
        let steps = self.tracks[0].t_s.len().saturating_sub(1);
        // A text in a script must not end it.
        let data = serde_json::to_string(self)
            .unwrap_or_default()
            .replace('<', "\\u003c");
        let has_errors = self.tracks.iter().any(|track| !track.error_m.is_empty());
        html! {
            div class="replay" {
                p {
                    (self.name) ". Move the slider, or press the arrow keys on it; a link may end in #t= and seconds."
                }
                p class="keys" {
                    @for track in &self.tracks {
                        span style=(format!("--colour:{}", track.colour)) { (track.name) }
                    }
                }
                div class="places" {
                    svg class="map" role="img" aria-label="Walls, paths and robot" {}
                    @if let Some(frames) = &self.frames {
                        figure {
                            canvas width="300" height="300" role="img" aria-label="Echoes around the robot" {}
                            figcaption {
                                "Echoes around the robot, up to " (frames.reach_m) " m and 30 dB, as the map lies. "
                                "Left and right of the heading look alike until the robot turns."
                            }
                        }
                    }
                }
                input type="range" min="0" max=(steps) value="0" aria-label="Time in the drive";
                output {}
                @if has_errors {
                    p { "Error over time, up to " span class="most" {} }
                    svg class="errors" role="img" aria-label="Error over time" {}
                }
                script type="application/json" { (PreEscaped(data)) }
            }
        }
    }
}
