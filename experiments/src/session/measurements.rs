//! Echoes and maps measured from a session's recordings, kept in memory for the studies that follow.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use anyhow::{Context, Result};
use fdtd::scheme::Scheme;
use localizer::image::{MapImage, map_builder};
use localizer::{EchoSequence, Parameters, Recording, echo};

use super::recordings::Recordings;
use crate::recordings::noise::Noise;
use crate::recordings::spec::RecordingSpec;

/// Echoes and maps by recording and parameters.
pub struct Measurements {
    recordings: Arc<Recordings>,
    /// Parameters whose filter part is put into the names of maps.
    base: Parameters,
    maps: Mutex<HashMap<String, Arc<MapImage>>>,
    /// The echoes measured last, which consecutive studies share.
    recent: Mutex<Option<(String, Arc<EchoSequence>)>>,
}

impl Measurements {
    /// Measurements of `recordings`; trials that differ from `base` in the filter alone share them.
    pub(super) fn new(recordings: Arc<Recordings>, base: &Parameters) -> Self {
        Self {
            recordings,
            base: base.clone(),
            maps: Mutex::default(),
            recent: Mutex::default(),
        }
    }

    /// The map for localization with these parameters and this scheme.
    ///
    /// # Errors
    /// When the mapping recording is missing or cannot be measured.
    pub fn map(&self, scheme: Option<Scheme>, parameters: &Parameters) -> Result<Arc<MapImage>> {
        self.noisy_map(scheme, None, parameters)
    }

    /// As [`Measurements::map`], from a mapping drive with noise.
    ///
    /// # Errors
    /// As [`Measurements::map`].
    pub fn noisy_map(
        &self,
        scheme: Option<Scheme>,
        noise: Option<Noise>,
        parameters: &Parameters,
    ) -> Result<Arc<MapImage>> {
        let parameters = measurement_of(parameters, &self.base);
        let spec = self.recordings.spec("mapping", scheme);
        let name = format!("{} {noise:?}", self.name_of(&spec, &parameters)?);
        if let Some(map) = self
            .maps
            .lock()
            .ok()
            .and_then(|maps| maps.get(&name).cloned())
        {
            return Ok(map);
        }
        let recording = self.recordings.noisy(&spec, noise)?;
        let sequence = echo::measure(&recording, &parameters)?;
        let map = Arc::new(map_of(&recording, &sequence)?);
        if let Ok(mut maps) = self.maps.lock() {
            maps.insert(name, Arc::clone(&map));
        }
        Ok(map)
    }

    /// The echoes of a recording without noise, measured with these parameters (see [`measurement_of`]).
    ///
    /// # Errors
    /// When the recording is missing or cannot be measured.
    pub fn echoes(
        &self,
        spec: &RecordingSpec,
        parameters: &Parameters,
    ) -> Result<Arc<EchoSequence>> {
        let name = self.name_of(spec, parameters)?;
        let known = self.recent.lock().ok().and_then(|recent| recent.clone());
        if let Some((_, echoes)) = known.filter(|(known, _)| *known == name) {
            return Ok(echoes);
        }
        let recording = self.recordings.read(spec, false)?;
        let echoes = Arc::new(echo::measure(&recording, parameters)?);
        if let Ok(mut recent) = self.recent.lock() {
            *recent = Some((name, Arc::clone(&echoes)));
        }
        Ok(echoes)
    }

    /// All that determines a measurement.
    fn name_of(&self, spec: &RecordingSpec, parameters: &Parameters) -> Result<String> {
        let parameters = serde_json::to_string(parameters)?;
        Ok(format!("{} {parameters}", self.recordings.key(spec)?))
    }
}

/// The map image of one recording with truth.
///
/// # Errors
/// When the recording has no truth or no moving block.
pub fn map_of(recording: &Recording, sequence: &EchoSequence) -> Result<MapImage> {
    let truth = recording
        .truth
        .as_ref()
        .context("recording: truth.tum: is missing; a map needs the true poses of its drive")?;
    Ok(map_builder::build(&[(sequence, &sequence.poses(truth))])?)
}

/// The parameters with the filter's set to those of `base`: equal for trials that can share measured echoes and map.
pub fn measurement_of(parameters: &Parameters, base: &Parameters) -> Parameters {
    Parameters {
        filter: base.filter,
        ..parameters.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use localizer::{Method, Resampling};

    #[test]
    fn trials_that_differ_in_the_filter_alone_share_their_measurement() {
        let base = Parameters::default();
        let mut trial = base.clone();
        trial.filter.method = Method::ToaOnly;
        trial.filter.resampling = Resampling::Multinomial;
        assert_eq!(measurement_of(&trial, &base), base);
        trial.measurement.periods = 3;
        assert_ne!(measurement_of(&trial, &base), base);
        assert_eq!(measurement_of(&trial, &base).measurement, trial.measurement);
    }
}
