//! Reflected intensity over time beside the distances of ray theory (Fig. 8).

use anyhow::{Context, Result};
use fdtd::walls::Wall;
use localizer::echo;
use localizer::parameters::MeasurementParameters;
use localizer::{Parameters, ToaImage};
use ndarray::Array2;
use oracles::rays::{RayKind, Reflectors, TraceOptions, trace};

use super::PaperSession;
use crate::data::atomic;
use crate::data::table::{Table, cell};
use crate::metrics::{mean, rounded};
use crate::summary::{Reflections, Summary};

/// Greatest round-trip distance shown, metres.
const SHOWN_M: f64 = 10.0;

/// Delays that share one column of the image; the greatest value stands for them.
const POOL: usize = 4;

/// Reach of a corner's apex, metres: corners that are not quite square still send sound back.
const SLACK_M: f64 = 0.05;

/// Half width of a ray's trace in the intensity image, metres of round trip.
const TRACE_M: f64 = 0.08;

/// A ray at one time.
struct Ray {
    t_s: f64,
    round_trip_m: f64,
    kind: &'static str,
}

/// Rays with one or two reflections at the times `t_s`.
fn rays(session: &PaperSession, times_s: &[f64]) -> Result<Vec<Ray>> {
    let path = session.scene.path("localization")?;
    let reflectors = Reflectors::of(&session.scene.walls);
    let options = TraceOptions {
        max_order: 2,
        slack_m: SLACK_M,
    };
    let mut found = Vec::new();
    for &t_s in times_s {
        let source = path.point_at(t_s, session.scene.robot.loudspeaker_offset_m);
        let receiver = path.point_at(t_s, session.scene.robot.microphone_offset_m);
        for ray in trace(&reflectors, source, receiver, &options) {
            let kind = match ray.kind {
                RayKind::Double if meet(&session.scene.walls, &ray.walls) => RayKind::Corner,
                RayKind::Direct | RayKind::Multiple => continue,
                kind => kind,
            }
            .name();
            found.push(Ray {
                t_s,
                round_trip_m: ray.length_m,
                kind,
            });
        }
    }
    Ok(found)
}

/// Whether the two wall segments of a double reflection end so near each other that they form a closed corner.
fn meet(walls: &[Wall], pieces: &[(usize, usize)]) -> bool {
    let ends = |&(wall, piece): &(usize, usize)| {
        let wall = walls.get(wall)?;
        Some((wall.segments_m().nth(piece)?, wall.thickness_m))
    };
    let Some([Some((one, thickness_m)), Some((other, other_thickness_m))]) = pieces
        .first_chunk::<2>()
        .map(|pair| pair.each_ref().map(ends))
    else {
        return false;
    };
    let reach_m = thickness_m.max(other_thickness_m);
    one.iter().any(|a| {
        other
            .iter()
            .any(|b| (a[0] - b[0]).hypot(a[1] - b[1]) <= reach_m)
    })
}

/// Runs the study.
pub(super) fn run(session: &PaperSession, summary: &mut Summary) -> Result<()> {
    let recording = session
        .recordings
        .read(&session.recordings.spec("localization", None), false)?;
    // The figure shows the sum over the directions, also when the range-only method uses another intensity.
    let parameters = &Parameters {
        measurement: MeasurementParameters {
            toa_image: ToaImage::Mean,
            ..session.parameters.measurement
        },
        ..session.parameters.clone()
    };
    let sequence = echo::measure(&recording, parameters)?;
    let delays = parameters
        .signal
        .delay_of_range(0.5 * SHOWN_M)
        .min(parameters.delays());
    let columns = delays / POOL;
    let gate = parameters
        .signal
        .delay_of_range(parameters.measurement.min_range_m);
    let directions = (parameters.measurement.directions + 1) as f32;
    let image = Array2::from_shape_fn((sequence.blocks.len(), columns), |(row, column)| {
        let intensity = &sequence.blocks[row].toa_intensity;
        (column * POOL..(column + 1) * POOL)
            .filter(|delay| *delay >= gate)
            .filter_map(|delay| intensity.get(delay))
            .fold(0.0_f32, |greatest, value| greatest.max(*value))
            * directions
    });
    let times_s: Vec<f64> = sequence.blocks.iter().map(|block| block.t_s).collect();
    let first_s = times_s
        .first()
        .copied()
        .context("the recording has no block")?;
    let step_s = parameters.period_s();
    let column_m = 2.0 * parameters.signal.range_of_delay_m(POOL as f64);
    let place = serde_json::json!({
        "t_s": [first_s - 0.5 * step_s, first_s + (times_s.len() as f64 - 0.5) * step_s],
        "range_m": [0.0, column_m * columns as f64],
    });
    atomic::write_with(&session.data("reflections.npy"), |file| {
        Ok(ndarray_npy::write_npy(file, &image)?)
    })?;
    atomic::write(
        &session.data("reflections.json"),
        format!("{place:#}\n").as_bytes(),
    )?;

    let rays = rays(session, &times_s)?;
    let mut table = Table::new(["t_s", "round_trip_m", "kind"]);
    for ray in &rays {
        table.push([
            cell(ray.t_s, 4),
            cell(ray.round_trip_m, 4),
            ray.kind.to_string(),
        ]);
    }
    table.write(&session.data("rays.csv"))?;
    let usable: Vec<&Ray> = rays.iter().filter(|ray| ray.kind != "double").collect();
    summary.reflections = Some(Reflections {
        farthest_usable_m: rounded(
            usable
                .iter()
                .map(|ray| ray.round_trip_m)
                .fold(0.0, f64::max),
        ),
        ray_contrast_db: rounded(contrast_db(
            &image,
            &usable,
            &rays,
            [first_s, step_s],
            column_m,
        )),
    });
    Ok(())
}

/// Mean intensity on the usable rays over the mean away from all rays, decibels of amplitude.
fn contrast_db(
    image: &Array2<f32>,
    usable: &[&Ray],
    rays: &[Ray],
    [first_s, step_s]: [f64; 2],
    column_m: f64,
) -> f64 {
    // 0: no ray, 1: double reflection, 2: single or corner reflection.
    let mut kinds = Array2::<u8>::zeros(image.dim());
    let mut mark = |ray: &Ray, kind: u8| {
        let row = ((ray.t_s - first_s) / step_s).round() as usize;
        let low = ((ray.round_trip_m - TRACE_M) / column_m).floor().max(0.0) as usize;
        let high = ((ray.round_trip_m + TRACE_M) / column_m).ceil() as usize;
        for column in low..high.min(kinds.ncols()) {
            if let Some(cell) = kinds.get_mut((row, column)) {
                *cell = kind;
            }
        }
    };
    rays.iter().for_each(|ray| mark(ray, 1));
    usable.iter().for_each(|ray| mark(ray, 2));
    let level = |kind: u8| {
        let values: Vec<f64> = image
            .iter()
            .zip(&kinds)
            .filter(|(value, found)| **found == kind && **value > 0.0)
            .map(|(value, _)| f64::from(*value))
            .collect();
        mean(&values)
    };
    let ratio = level(2) / level(0);
    if ratio.is_finite() && ratio > 0.0 {
        20.0 * ratio.log10()
    } else {
        0.0
    }
}
