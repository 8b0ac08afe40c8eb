//! `echolot map` and `echolot localize` by landmarks.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use localizer::echo::EchoBlock;
use localizer::io::recording_source::RecordingSource;
use localizer::landmarks::{Estimate, LandmarkMap, Start, Status};
use localizer::{Parameters, Pose, Trajectory};

use super::estimates::{HEADER_AMONG_LANDMARKS, Scored};
use super::output::{print, print_json};
use super::shown::{self, ShownArguments};
use crate::data::{atomic, estimate, manifest};
use crate::drive::Drive;
use crate::figures::localization::{Background, Localization};
use crate::localization::{self, status_name};
use crate::metrics::{mean, rounded};
use crate::run::progress::Board;
use crate::scores::Scores;
use crate::trust::{self, Warnings};

/// Writes a map of landmarks into its folder.
pub(super) fn write_map(map: &LandmarkMap, output: &Path, json: bool) -> Result<()> {
    manifest::put_into(output, |folder| Ok(map.write(folder)?))?;
    let walls = map
        .landmarks
        .iter()
        .filter(|landmark| landmark.ends_m().is_some());
    let (walls, all) = (walls.count(), map.landmarks.len());
    if json {
        return print_json(&serde_json::json!({
            "map": output,
            "landmarks": all,
            "walls": walls,
            "points": all - walls,
            "explained": rounded(map.explained),
        }));
    }
    eprintln!(
        "wrote {} ({walls} walls, {} points; they explain {:.0} % of all peaks)",
        output.display(),
        all - walls,
        100.0 * map.explained
    );
    Ok(())
}

/// What a localization among landmarks writes.
pub(super) struct Wanted<'a> {
    /// The trajectory; the table lies beside it.
    pub(super) output: &'a Path,
    /// Picture and page.
    pub(super) shown: &'a ShownArguments,
    /// What the clock of the estimates' times shows at the first period.
    pub(super) reading_s: f64,
    /// Whether the report is JSON.
    pub(super) json: bool,
}

/// Follows the robot of a recording among the landmarks of a map: writes the trajectory, and beside it a table with
/// covariance and status.
pub(super) fn localize(
    folder: &Path,
    source: &RecordingSource,
    map: &LandmarkMap,
    parameters: &Parameters,
    start: &Start,
    wanted: &Wanted<'_>,
) -> Result<()> {
    let (output, json) = (wanted.output, wanted.json);
    let task = Board::new().task("localize", 1);
    let mut warnings = Warnings::default();
    warnings.extend(trust::changed(folder));
    let drive = Drive::of_folder(source, folder);
    let mut frames = wanted.shown.frames(parameters, source.duration_s());
    let mut look_on = |block: &EchoBlock, poses: &[Pose]| {
        if let Some(frames) = &mut frames {
            frames.add(block, poses);
        }
    };
    let estimates =
        localization::among_landmarks(&drive, map, parameters, start, &mut warnings, &mut look_on)?;
    task.finish();
    let last = estimates.last().context("no estimate")?;
    let table = write(output, &estimates, wanted.reading_s)?;
    let (scored, latest) = scored(source.truth.as_ref(), &estimates);
    scored.warn(&mut warnings);
    let shares =
        [Status::Sure, Status::Converging, Status::Lost].map(|status| share(&estimates, status));
    let fit: Vec<f64> = estimates.iter().map(|estimate| estimate.fit).collect();
    let told = format!(
        "sure {:.0} %, converging {:.0} %, lost {:.0} % of the drive; found {:.0} % of the expected echoes\n",
        100.0 * shares[0],
        100.0 * shares[1],
        100.0 * shares[2],
        100.0 * mean(&fit),
    );
    if last.status == Status::Lost {
        warnings.add("lost at the end: the echoes do not fit the map there");
    }
    let begin = match *start {
        Start::Known { pose, .. } => pose,
        Start::Unknown => source.start_pose(),
    };
    let shown = Localization {
        map: Background::Landmarks(map),
        path: &trajectory(&estimates),
        truth: source.truth.as_ref(),
        wheels: &shown::wheels(source, parameters, begin),
        fit: &fit,
        fit_label: ["share", "(c) expected echoes that were found"],
    };
    let name = folder.display().to_string();
    let words = shown::words(
        [&name, "landmarks"],
        &scored,
        &told,
        &warnings,
        statuses(&estimates),
    );
    wanted.shown.show(&shown, frames, words)?;
    if json {
        let report = serde_json::json!({
            "estimate": output,
            "table": table,
            "poses": estimates.len(),
            "latest_mae_m": latest.map(|scores| scores.mae_m),
            "warnings": warnings.tell(),
            "status": {"sure": rounded(shares[0]), "converging": rounded(shares[1]), "lost": rounded(shares[2])},
            "fit": rounded(mean(&fit)),
            "speed_of_sound_mps": rounded(last.speed_of_sound_mps),
            "turn_rate_error_radps": rounded(last.turn_rate_error_radps),
            "speed_error": rounded(last.speed_error),
        });
        return print_json(&scored.put_into(report));
    }
    eprintln!(
        "wrote {} and {} ({} poses)",
        output.display(),
        table.display(),
        estimates.len()
    );
    print(&told)?;
    scored.tell()?;
    warnings.tell();
    Ok(())
}

/// Writes the trajectory, and a table with covariance and status beside it, on a clock that shows `reading_s` at the
/// first period; the table's name comes back.
pub(super) fn write(output: &Path, estimates: &[Estimate], reading_s: f64) -> Result<PathBuf> {
    let trajectory = Trajectory {
        t_s: estimates.iter().map(|e| e.t_s + reading_s).collect(),
        poses: estimates.iter().map(|e| e.pose).collect(),
    };
    estimate::write(output, &trajectory)?;
    let table = output.with_extension("csv");
    atomic::write(&table, csv(estimates, reading_s).as_bytes())?;
    Ok(table)
}

/// The poses over the time of the sound.
pub(super) fn trajectory(estimates: &[Estimate]) -> Trajectory {
    Trajectory {
        t_s: estimates.iter().map(|e| e.t_s).collect(),
        poses: estimates.iter().map(|e| e.pose).collect(),
    }
}

/// What every estimate says of itself.
pub(super) fn statuses(estimates: &[Estimate]) -> Vec<&'static str> {
    estimates.iter().map(|e| status_name(e.status)).collect()
}

/// Share of the estimates that have a status.
pub(super) fn share(estimates: &[Estimate], status: Status) -> f64 {
    let with = estimates.iter().filter(|e| e.status == status).count();
    with as f64 / estimates.len().max(1) as f64
}

/// Scores of the poses at the blocks' instants, and of those at the newest sample.
pub(super) fn scored(
    truth: Option<&Trajectory>,
    estimates: &[Estimate],
) -> (Scored, Option<Scores>) {
    let Some(truth) = truth else {
        let none = Scored {
            scores: None,
            coverage: 0.0,
            has_truth: false,
        };
        return (none, None);
    };
    let of = |pose: &dyn Fn(&Estimate) -> (f64, Pose)| {
        let poses: Vec<(f64, Pose)> = estimates.iter().map(pose).collect();
        Scores::of(&poses, truth)
    };
    let (scores, coverage) = of(&|e| (e.t_s, e.pose));
    let (latest, _) = of(&|e| (e.latest_s, e.latest));
    let scored = Scored {
        scores,
        coverage,
        has_truth: true,
    };
    (scored, latest)
}

/// The estimates as a table, on a clock that shows `reading_s` at the first period.
fn csv(estimates: &[Estimate], reading_s: f64) -> String {
    let mut text = String::from(HEADER_AMONG_LANDMARKS);
    for e in estimates {
        let [[xx, xy, xh], [_, yy, yh], [.., hh]] = e.covariance;
        let status = status_name(e.status);
        text += &format!(
            "{:.6},{:.6},{:.6},{:.6},{xx:.3e},{xy:.3e},{yy:.3e},{xh:.3e},{yh:.3e},{hh:.3e},{status},{:.3},{},{:.6},\
             {:.6},{:.6},{:.6},{:.5},{:.5},{:.3}\n",
            e.t_s + reading_s,
            e.pose.x_m,
            e.pose.y_m,
            e.pose.heading_rad,
            e.fit,
            e.hypotheses,
            e.latest_s + reading_s,
            e.latest.x_m,
            e.latest.y_m,
            e.latest.heading_rad,
            e.turn_rate_error_radps,
            e.speed_error,
            e.speed_of_sound_mps,
        );
    }
    text
}
