//! Size and duration of a simulation, measured by a short run.

use std::time::Instant;

use anyhow::Result;
use fdtd::scene::Scene;
use fdtd::simulation::{Flow, Simulation};

use crate::recordings::simulate::prepare;
use crate::recordings::spec::RecordingSpec;
use crate::run::interrupt;
use crate::run::progress::duration;

/// Wall-clock time of the speed measurement behind an estimate, seconds.
pub(super) const MEASURING_S: f64 = 0.4;

/// Size and expected duration of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// Cells of the grid.
    pub cells: usize,
    /// Steps in time.
    pub steps: u64,
    /// Memory, bytes.
    pub memory_bytes: u64,
    /// Expected duration, seconds.
    pub seconds: f64,
}

impl std::fmt::Display for Estimate {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            formatter,
            "{} cells, {} steps, {:.0} MiB, about {}",
            self.cells,
            self.steps,
            self.memory_bytes as f64 / (1024.0 * 1024.0),
            duration(self.seconds)
        )
    }
}

/// Steps per second that a simulation reaches within about `seconds`. The simulation only serves this measurement: its
/// subnormal numbers are set to zero, as they are soon after the start of a long drive.
///
/// # Errors
/// When the field turns non-finite.
pub fn steps_per_second(simulation: &mut Simulation, seconds: f64) -> Result<f64> {
    // The first call comes after the field is in the caches.
    let mut first: Option<(Instant, u64)> = None;
    let mut rate = 0.0;
    simulation.flush_subnormals();
    simulation.run(&mut |progress, _| {
        let (since, from) = *first.get_or_insert((Instant::now(), progress.step));
        let elapsed = since.elapsed().as_secs_f64();
        if progress.step > from {
            rate = (progress.step - from) as f64 / elapsed.max(1e-9);
        }
        if elapsed < seconds && !interrupt::requested() {
            Flow::Continue
        } else {
            Flow::Stop
        }
    })?;
    Ok(rate)
}

/// Size of a recording's simulation and its duration on `threads` threads, measured by running it for a moment.
///
/// # Errors
/// When the field refuses the scene.
pub fn estimate(scene: &Scene, spec: &RecordingSpec, threads: usize) -> Result<Estimate> {
    let mut simulation = prepare(scene, spec, threads)?;
    let steps = simulation.steps_total();
    let rate = steps_per_second(&mut simulation, MEASURING_S)?;
    Ok(Estimate {
        cells: simulation.cells(),
        steps,
        memory_bytes: simulation.memory_bytes(),
        seconds: if rate > 0.0 { steps as f64 / rate } else { 0.0 },
    })
}
