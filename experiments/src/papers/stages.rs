//! Durations of a run's stages in the provenance of its summary.

use std::time::Instant;

use anyhow::Result;

use super::PaperSession;
use crate::recordings::recording::simulation_seconds;
use crate::recordings::spec::RecordingSpec;
use crate::summary::Summary;

/// Notes the duration of a stage, seconds.
pub(super) fn stage(summary: &mut Summary, name: &str, started: Instant) {
    let seconds = (started.elapsed().as_secs_f64() * 10.0).round() / 10.0;
    summary.provenance.seconds.insert(name.to_string(), seconds);
}

/// Notes the time that the simulation of each recording took, seconds.
///
/// # Errors
/// When a recording is not in the cache.
pub(super) fn note_simulations(
    session: &PaperSession,
    specs: &[RecordingSpec],
    summary: &mut Summary,
) -> Result<()> {
    for spec in specs {
        let recording = session.recordings.read(spec, false)?;
        let seconds = simulation_seconds(&recording);
        summary
            .provenance
            .simulation_seconds
            .insert(session.recordings.label(spec), seconds);
    }
    Ok(())
}
