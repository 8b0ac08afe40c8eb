//! Trials of methods that have no random numbers: one run over the drive stands for all trials that share its echoes.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use anyhow::{Context, Result, anyhow};
use localizer::landmarks::{self, LandmarkMap, Start};
use localizer::{Pose, echo, slam};
use rayon::prelude::*;

use super::arrivals;
use super::group::{Finished, Group, Output};
use super::trial::{Approach, Found, TrialResult};
use crate::localization::START_SIGMA;
use crate::run::interrupt;
use crate::session::Session;

/// Maps of landmarks by all that determines them; the text is the reason why there is none.
pub(super) type Maps = Mutex<HashMap<String, Result<Arc<LandmarkMap>, String>>>;

/// A start that truth gives.
pub fn known(pose: Pose) -> Start {
    let [sigma_m, sigma_rad] = START_SIGMA;
    Start::Known {
        pose,
        sigma_m,
        sigma_rad,
    }
}

/// Runs the trials of groups, several groups at a time.
pub(super) fn run(
    session: &Session,
    groups: &[Group<'_>],
    output: &Output<'_>,
) -> Result<Vec<Finished>> {
    let maps = Maps::default();
    let finished = groups
        .par_iter()
        .with_max_len(1)
        .map(|group| {
            interrupt::check()?;
            let result = run_group(session, group, &maps)?;
            (group.members.iter())
                .map(|&(index, _)| {
                    output.keep(index, &result)?;
                    Ok((index, result.clone()))
                })
                .collect::<Result<Vec<Finished>>>()
        })
        .collect::<Result<Vec<_>>>()?;
    Ok(finished.into_iter().flatten().collect())
}

/// The method of a group on its drive.
fn run_group(session: &Session, group: &Group<'_>, maps: &Maps) -> Result<TrialResult> {
    let spec = session.recordings.spec("localization", group.scheme);
    let recording = session.recordings.noisy(&spec, group.noise)?;
    let start = recording.start_pose();
    let noise = landmarks::Noise::default();
    let found: Vec<Found> = match group.approach {
        Approach::Images => return Err(anyhow!("trials of images have random numbers")),
        Approach::Landmarks => {
            let map = match map_of(session, group, maps)? {
                Ok(map) => map,
                Err(reason) => return Ok(TrialResult::failed(reason)),
            };
            let echoes = echo::measure(&recording, &group.parameters)?;
            let estimates = landmarks::localize(&echoes, &map, &known(start), noise);
            estimates.iter().map(Found::from).collect()
        }
        Approach::Slam => {
            let echoes = echo::measure(&recording, &group.parameters)?;
            let drive = slam::slam(&echoes, start, noise);
            drive.estimates.iter().map(Found::from).collect()
        }
        Approach::Arrivals => {
            let path = arrivals::follow_scene(&session.scene, &recording, &group.parameters)?;
            let poses = path.t_s.iter().zip(&path.poses).skip(1);
            poses.map(|(&t_s, &pose)| Found::at(t_s, pose)).collect()
        }
    };
    TrialResult::of(&recording, &found)
}

/// The landmarks of a group's mapping drive, or the reason why there are none.
pub(super) fn map_of(
    session: &Session,
    group: &Group<'_>,
    maps: &Maps,
) -> Result<Result<Arc<LandmarkMap>, String>> {
    let noise = group.mapping_noise();
    let parameters = serde_json::to_string(&group.parameters)?;
    let name = format!("{:?} {noise:?} {parameters}", group.scheme);
    if let Some(known) = maps.lock().ok().and_then(|maps| maps.get(&name).cloned()) {
        return Ok(known);
    }
    let spec = session.recordings.spec("mapping", group.scheme);
    let recording = session.recordings.noisy(&spec, noise)?;
    let echoes = echo::measure(&recording, &group.parameters)?;
    let truth = recording
        .truth
        .as_ref()
        .context("recording: truth.tum: is missing")?;
    let poses = echoes.poses(truth);
    let map = landmarks::learn(&[(&echoes, &poses)])
        .map(Arc::new)
        .map_err(|error| error.to_string());
    if let Ok(mut maps) = maps.lock() {
        maps.insert(name, map.clone());
    }
    Ok(map)
}
