//! Speed of the field computation on the scene, with all threads.

use anyhow::Result;
use fdtd::scheme::Scheme;

use super::PaperSession;
use crate::metrics::rounded;
use crate::recordings::simulate::prepare;
use crate::recordings::spec::RecordingSpec;
use crate::schedule::steps_per_second;
use crate::summary::{Engine, Summary};

/// Wall-clock time of one measurement, seconds.
const MEASURING_S: f64 = 1.5;

/// Runs the study.
pub(super) fn run(session: &PaperSession, summary: &mut Summary) -> Result<()> {
    if !session.recordings.has_field() {
        summary.engine = Some(Engine {
            scheme: session.recordings.scheme_name(),
            gcells_per_s: 0.0,
            slf_gcells_per_s: 0.0,
            threads: session.threads,
            memory_bytes: 0,
        });
        return Ok(());
    }
    let measure = |scheme: Scheme| -> Result<(f64, u64)> {
        let spec = RecordingSpec {
            scheme: Some(scheme),
            ..session.recordings.spec("localization", None)
        };
        let mut simulation = prepare(&session.scene, &spec, session.threads)?;
        let rate = steps_per_second(&mut simulation, MEASURING_S)?;
        Ok((
            rounded(rate * simulation.cells() as f64 * 1e-9),
            simulation.memory_bytes(),
        ))
    };
    let (gcells_per_s, memory_bytes) = measure(session.scene.scheme)?;
    let (slf_gcells_per_s, _) = measure(Scheme::Slf)?;
    summary.engine = Some(Engine {
        scheme: session.recordings.scheme_name(),
        gcells_per_s,
        slf_gcells_per_s,
        threads: session.threads,
        memory_bytes,
    });
    Ok(())
}
