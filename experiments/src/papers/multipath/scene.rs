//! Model (b) against the Doppler method on the localization drive of the session's scene: the same recording and
//! odometry.

use anyhow::Result;
use localizer::filter::motion_model::dead_reckon;
use localizer::{Pose, Trajectory};

use super::paths::{COLUMNS, Errors, accuracy, errors, write_path};
use crate::data::table::Table;
use crate::papers::PaperSession;
use crate::papers::cells::doppler_trials;
use crate::summary::MultipathScene;
use crate::trials::arrivals::follow_scene;
use crate::trials::{self, TrialResult};

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
pub(super) fn run(session: &PaperSession) -> Result<MultipathScene> {
    let recording = session
        .recordings
        .read(&session.recordings.spec("localization", None), false)?;
    let start = recording.start_pose();
    let mut table = Table::new(COLUMNS);
    let mut single = |name: &str, path: &Trajectory| -> Result<_> {
        let found = errors(path, &recording)?;
        write_path(&mut table, name, 0, path, &found);
        Ok(accuracy(&[found]))
    };
    let parameters = &session.parameters;
    let planar = single(
        "planar",
        &follow_scene(&session.scene, &recording, parameters)?,
    )?;
    let odometry = single("odometry", &dead_reckon(&recording, parameters, start))?;
    let results = trials::run(
        session,
        "multipath, Doppler",
        &doppler_trials(&session.parameters, session.seeds().filter),
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
