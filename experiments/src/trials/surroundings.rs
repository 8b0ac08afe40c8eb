//! What a trial knows of its surroundings: the map that its method follows, or has made.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result};
use localizer::landmarks::LandmarkMap;
use localizer::{MapImage, Method};

use super::drives::{Maps, map_of};
use super::group::Group;
use super::trial::{Approach, Trial};
use crate::drive::Drive;
use crate::localization;
use crate::session::Session;
use crate::trust::Warnings;

/// A map of a trial.
pub enum Surroundings {
    /// Intensities of echoes, of the paper's method.
    Image(Arc<MapImage>),
    /// Walls and points.
    Landmarks(Arc<LandmarkMap>),
}

/// The map that a trial's method follows, or has made in the end; `None` where it has none: wheels alone, given walls,
/// or a drive in which nothing was learnt.
///
/// # Errors
/// When a recording is missing or cannot be used.
pub fn surroundings(session: &Session, trial: &Trial) -> Result<Option<Surroundings>> {
    let groups = Group::of(std::slice::from_ref(trial), &[None], &session.parameters)?;
    let group = groups.first().context("a trial has no group")?;
    let parameters = &trial.parameters;
    Ok(match trial.approach {
        Approach::Images if parameters.filter.method == Method::Odometry => None,
        Approach::Arrivals => None,
        Approach::Images => {
            let noise = group.mapping_noise();
            let map = (session.measurements).noisy_map(trial.scheme, noise, parameters)?;
            Some(Surroundings::Image(map))
        }
        Approach::Landmarks => {
            let map = map_of(session, group, &Maps::default())?;
            map.ok().map(Surroundings::Landmarks)
        }
        Approach::Slam => {
            let spec = session.recordings.spec("localization", trial.scheme);
            let recording = session.recordings.noisy(&spec, trial.noise)?;
            let drive = Drive::loaded(&recording, Path::new("recording"));
            let start = recording.start_pose();
            // Trials have told already how far to trust them.
            let mut warnings = Warnings::default();
            let each = &mut |_: [u64; 2], _: &_, _: &_| Ok(());
            let found = localization::without_map(&drive, parameters, start, &mut warnings, each)?;
            found.map.map(|map| Surroundings::Landmarks(Arc::new(map)))
        }
    })
}
