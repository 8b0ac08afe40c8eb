//! Model (b) against the Doppler method on the localization drive of the preset's scene: the same recording and
//! odometry.

use anyhow::{Context, Result};
use fdtd::scene::Scene;
use localizer::filter::motion_model::dead_reckon;
use localizer::multipath::arrivals;
use localizer::multipath::ekf::follow;
use localizer::multipath::planes::Plane;
use localizer::multipath::prediction::{Model, Predictor};
use localizer::parameters::MeasurementParameters;
use localizer::{Parameters, Pose, Trajectory};
use oracles::rays::Reflectors;

use super::paths::{COLUMNS, Errors, GATE_M, PICKING, accuracy, errors, noise, write_path};
use crate::data::table::Table;
use crate::session::Session;
use crate::study::cells::doppler_trials;
use crate::summary::MultipathScene;
use crate::trials::{self, TrialResult};

/// Longest round trip at which peaks are picked, metres; the papers' scene has its longest single and corner echoes
/// there.
const FARTHEST_M: f64 = 8.0;

/// The faces of the scene's walls as finite planes that reflect to their front.
fn planes(scene: &Scene) -> Result<Vec<Plane>> {
    Reflectors::of(&scene.walls)
        .faces()
        .iter()
        .map(|face| {
            let end = [0, 1].map(|i| face.start_m[i] + face.length_m * face.along[i]);
            let left = face.along[0] * face.normal[1] - face.along[1] * face.normal[0];
            let ends = if left > 0.0 {
                [face.start_m, end]
            } else {
                [end, face.start_m]
            };
            Plane::wall(ends).context("scene: walls: one has no length")
        })
        .collect()
}

/// A trial of the particle filter as a trajectory with a start, which [`write_path`] skips.
fn trajectory(result: &TrialResult) -> (Trajectory, Errors) {
    let poses = result
        .x_m
        .iter()
        .zip(&result.y_m)
        .zip(&result.heading_rad)
        .map(|((&x_m, &y_m), &heading_rad)| Pose {
            x_m,
            y_m,
            heading_rad,
        });
    let trajectory = Trajectory {
        t_s: [&[0.0], result.t_s.as_slice()].concat(),
        poses: std::iter::once(Pose::default()).chain(poses).collect(),
    };
    let errors = Errors {
        position_m: result.error_m.clone(),
        heading_rad: result.heading_error_rad.clone(),
    };
    (trajectory, errors)
}

/// Runs both methods.
pub(super) fn run(session: &Session) -> Result<MultipathScene> {
    let recording = session
        .recordings
        .read(&session.recordings.spec("localization", None), false)?;
    let c_mps = session.parameters.signal.speed_of_sound_mps;
    let parameters = Parameters {
        measurement: MeasurementParameters {
            periods: 2,
            // The noise level is estimated from all delays of a period.
            max_range_m: 0.48 * c_mps * session.parameters.period_s(),
            ..session.parameters.measurement
        },
        ..session.parameters.clone()
    };
    let nearest_m = 2.0 * parameters.measurement.min_range_m;
    let blocks = arrivals::measure(&recording, &parameters, &PICKING, [nearest_m, FARTHEST_M])?;
    // In the plane all heights are equal.
    let predictor = Predictor::new(&planes(&session.scene)?, Model::Planar, [0.0; 2], c_mps);
    let start = recording.start_pose();
    let mut table = Table::new(COLUMNS);
    let mut single = |name: &str, path: &Trajectory| -> Result<_> {
        let found = errors(path, &recording)?;
        write_path(&mut table, name, 0, path, &found);
        Ok(accuracy(&[found]))
    };
    let planar = single(
        "planar",
        &follow(&blocks, &predictor, noise(c_mps, GATE_M), start),
    )?;
    let odometry = single("odometry", &dead_reckon(&recording, &parameters, start))?;
    let results = trials::run(
        session,
        "multipath, Doppler",
        &doppler_trials(&session.parameters, session.plan.trials),
    )?;
    if let Some(first) = results.first() {
        let (path, errors) = trajectory(first);
        write_path(&mut table, "doppler", 0, &path, &errors);
    }
    table.write(&session.data("multipath_scene.csv"))?;
    Ok(MultipathScene {
        planar,
        doppler: trials::accuracy(&results),
        odometry,
    })
}
