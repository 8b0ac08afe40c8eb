//! A trial once more, looked on: what its replay shows.

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use localizer::echo::EchoBlock;
use localizer::{Method, Pose};

use super::drives::{Maps, known, map_of};
use super::group::Group;
use super::trial::{Approach, Trial};
use crate::data::frames::Frames;
use crate::drive::Drive;
use crate::localization;
use crate::session::Session;
use crate::trust::Warnings;

/// What a trial hears and believes over its drive, under the name of its method; none of one that does not listen.
///
/// # Errors
/// When a recording is missing or cannot be used.
pub fn watch(session: &Session, trial: &Trial, method: &str) -> Result<Option<Frames>> {
    let wheels_alone = trial.parameters.filter.method == Method::Odometry;
    if trial.approach == Approach::Images && wheels_alone {
        return Ok(None);
    }
    let groups = Group::of(std::slice::from_ref(trial), &[None], &session.parameters)?;
    let group = groups.first().context("a trial has no group")?;
    let spec = session.recordings.spec("localization", trial.scheme);
    let recording = session.recordings.noisy(&spec, trial.noise)?;
    let drive = Drive::loaded(&recording, Path::new("recording"));
    let start = recording.start_pose();
    let parameters = &trial.parameters;
    let mut frames = Frames::new(method, parameters, recording.duration_s());
    // Trials have told already how far to trust them.
    let mut warnings = Warnings::default();
    match trial.approach {
        Approach::Arrivals => return Ok(None),
        Approach::Images => {
            let noise = group.mapping_noise();
            let map = (session.measurements).noisy_map(trial.scheme, noise, parameters)?;
            frames.put_map(&map);
            let begin = (start, trial.seed());
            let mut look_on = |block: &EchoBlock, poses: &[Pose]| frames.add(block, poses);
            localization::by_images(&drive, &map, parameters, begin, &mut warnings, &mut look_on)?;
        }
        Approach::Landmarks => {
            let map =
                map_of(session, group, &Maps::default())?.map_err(|reason| anyhow!(reason))?;
            frames.know(0.0, &map);
            let mut look_on = |block: &EchoBlock, poses: &[Pose]| frames.add(block, poses);
            let start = known(start);
            localization::among_landmarks(
                &drive,
                &map,
                parameters,
                &start,
                &mut warnings,
                &mut look_on,
            )?;
        }
        Approach::Slam => {
            let mut each = |_: [u64; 2], block: &EchoBlock, estimator: &localizer::slam::Slam| {
                frames.add(block, &[]);
                if let Some(map) = estimator.map() {
                    frames.know(block.t_s, map);
                }
                Ok(())
            };
            localization::without_map(&drive, parameters, start, &mut warnings, &mut each)?;
        }
    }
    Ok(Some(frames.finish()))
}
