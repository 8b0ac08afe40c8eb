//! What shows a localization: a picture, and a page with a replay.

use std::path::{Path, PathBuf};

use anyhow::Result;
use localizer::filter::motion_model::advance;
use localizer::io::recording_source::RecordingSource;
use localizer::odometry::mean_over_time;
use localizer::{Parameters, Pose, Trajectory};

use super::estimates::Scored;
use crate::data::atomic;
use crate::data::frames::Frames;
use crate::data::place::Place;
use crate::figures::drawing::png;
use crate::figures::localization::{self, Localization};
use crate::report;
use crate::report::localization::{ESTIMATE, Words};
use crate::trust::Warnings;

/// What shows a localization.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct ShownArguments {
    /// Picture of path, truth and wheels over the map, error and fit over time (PNG).
    #[arg(long, value_name = "PNG")]
    pub(super) figure: Option<PathBuf>,
    /// Page with a replay: the robot on the map, its echoes, possible poses, error over time (HTML).
    #[arg(long, value_name = "HTML")]
    pub(super) report: Option<PathBuf>,
}

impl ShownArguments {
    /// Checks the places of picture and page; `place` makes one from a path.
    pub(super) fn check(&self, place: &dyn Fn(&Path) -> Place) -> Result<()> {
        if let Some(picture) = &self.figure {
            place(picture).file(png::is_ours)?;
        }
        if let Some(page) = &self.report {
            let mut place = place(page);
            place.inputs.extend(self.figure.clone());
            place.file(report::is_ours)?;
        }
        Ok(())
    }

    /// Frames to be filled where a page was asked for.
    pub(super) fn frames(&self, parameters: &Parameters, duration_s: f64) -> Option<Frames> {
        (self.report.is_some()).then(|| Frames::new(ESTIMATE, parameters, duration_s))
    }

    /// Draws the picture and writes the page.
    pub(super) fn show(
        &self,
        shown: &Localization<'_>,
        frames: Option<Frames>,
        words: Words<'_>,
    ) -> Result<()> {
        if let Some(picture) = &self.figure {
            localization::draw(shown, picture)?;
            eprintln!("wrote {}", picture.display());
        }
        self.write_page(shown, frames, words)
    }

    /// Writes the page alone.
    pub(super) fn write_page(
        &self,
        shown: &Localization<'_>,
        frames: Option<Frames>,
        words: Words<'_>,
    ) -> Result<()> {
        if let (Some(page), Some(frames)) = (&self.report, frames) {
            let text = report::localization::page(shown, frames, words);
            atomic::write(page, text.as_bytes())?;
            eprintln!("wrote {}", page.display());
        }
        Ok(())
    }
}

/// The words of a page on a drive: `told` is the line on how far to trust it.
pub(super) fn words<'a>(
    [recording, method]: [&str; 2],
    scored: &Scored,
    told: &str,
    warnings: &Warnings,
    status: Vec<&'a str>,
) -> Words<'a> {
    let mut rows = scored.rows();
    rows.push(["trust".into(), told.trim().into()]);
    rows.extend(
        warnings
            .so_far()
            .iter()
            .map(|line| ["warning".into(), line.clone()]),
    );
    Words {
        title: format!("Localization of {recording}"),
        about: format!("Method: {method}."),
        rows,
        status,
    }
}

/// The path by wheels alone from a start, period by period.
pub(super) fn wheels(source: &RecordingSource, parameters: &Parameters, start: Pose) -> Trajectory {
    let period_s = parameters.period_s();
    let mut wheels = Trajectory {
        t_s: vec![0.0],
        poses: vec![start],
    };
    let mut pose = start;
    for number in 0..(source.duration_s() / period_s) as usize {
        let [from_s, to_s] = [number, number + 1].map(|n| n as f64 * period_s);
        let mean = mean_over_time(&source.odometry, from_s, to_s);
        pose = advance(&pose, mean, period_s, parameters.filter.integration);
        wheels.t_s.push(to_s);
        wheels.poses.push(pose);
    }
    wheels
}
