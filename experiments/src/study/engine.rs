//! Speed of the field computation on the scene, with all threads.

use anyhow::Result;
use fdtd::scheme::Scheme;

use crate::laboratory::Laboratory;
use crate::metrics::rounded;
use crate::schedule::steps_per_second;
use crate::simulate::{self, Take};
use crate::summary::{Engine, Summary};

/// Wall-clock time of one measurement, seconds.
const MEASURING_S: f64 = 1.5;

/// Runs the study.
pub(crate) fn run(lab: &Laboratory, summary: &mut Summary) -> Result<()> {
    if !lab.has_field() {
        summary.engine = Some(Engine {
            scheme: lab.scheme_name(),
            gcells_per_s: 0.0,
            slf_gcells_per_s: 0.0,
            threads: lab.threads,
            memory_bytes: 0,
        });
        return Ok(());
    }
    let measure = |scheme: Scheme| -> Result<(f64, u64)> {
        let take = Take {
            scheme: Some(scheme),
            ..lab.take("localization", None)
        };
        let mut simulation = simulate::prepare(&lab.scene, &take, lab.threads)?;
        let rate = steps_per_second(&mut simulation, MEASURING_S)?;
        Ok((
            rounded(rate * simulation.cells() as f64 * 1e-9),
            simulation.memory_bytes(),
        ))
    };
    let (gcells_per_s, memory_bytes) = measure(lab.scene.scheme)?;
    let (slf_gcells_per_s, _) = measure(Scheme::Slf)?;
    summary.engine = Some(Engine {
        scheme: lab.scheme_name(),
        gcells_per_s,
        slf_gcells_per_s,
        threads: lab.threads,
        memory_bytes,
    });
    Ok(())
}
