//! A recording that has to be simulated.

use std::sync::Arc;

use fdtd::scene::Scene;

use crate::recordings::spec::RecordingSpec;

/// A recording that has to be simulated.
#[derive(Debug, Clone)]
pub struct Job {
    /// Name for progress and provenance, e.g. `mapping m13`.
    pub label: String,
    /// Key in the cache.
    pub key: String,
    /// The scene.
    pub scene: Arc<Scene>,
    /// The recording.
    pub spec: RecordingSpec,
}

impl Job {
    /// Length of the drive, seconds.
    pub(super) fn length_s(&self) -> f64 {
        self.scene
            .path(&self.spec.path)
            .map_or(0.0, |path| path.duration_s())
    }
}
