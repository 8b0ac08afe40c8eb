//! The studies. Each reads recordings of a session, writes data files, and fills its part of the summary.

mod angular_resolution;
mod cells;
mod dual_circle;
mod engine;
mod layout;
mod multipath;
mod odometry_drift;
mod periods;
mod reflections;
mod request;
mod schemes;
mod session;
mod site;
mod snr;
mod stages;
mod step_time;
mod window_size;

use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use self::stages::{note_simulations, stage};
use crate::recordings::spec::RecordingSpec;
use crate::run::interrupt;
use crate::run::preset::Preset;
use crate::run::progress::duration;
use crate::run::provenance::{Provenance, peak_memory_mib};
use crate::summary::Summary;

pub use self::request::Request;
pub use self::session::PaperSession;

/// A study.
pub struct Study {
    /// Name on the command line.
    pub name: &'static str,
    /// Its result, in one line.
    pub about: &'static str,
    /// Its figures.
    pub figures: &'static str,
    /// Presets that run it by default.
    pub presets: &'static [Preset],
    /// The recordings that it needs.
    specs: fn(&PaperSession) -> Vec<RecordingSpec>,
    /// Writes its data files and fills its part of the summary.
    run: fn(&PaperSession, &mut Summary) -> Result<()>,
}

const BOTH: &[Preset] = &[Preset::Paper, Preset::Quick];
const PAPER: &[Preset] = &[Preset::Paper];

/// All studies in the order in which they run.
pub const STUDIES: &[Study] = &[
    Study {
        name: "layout",
        about: "walls, drives, speeds and the map image",
        figures: "fig04, fig05",
        presets: BOTH,
        specs: |session| session.recordings.localization_specs(None),
        run: layout::run,
    },
    Study {
        name: "odometry-drift",
        about: "position error of Doppler, ToA only and odometry with a turn rate that is 0.01 rad/s too high",
        figures: "fig06",
        presets: BOTH,
        specs: |session| session.recordings.localization_specs(None),
        run: odometry_drift::run,
    },
    Study {
        name: "window-size",
        about: "position error over the half-width of the matched window",
        figures: "fig07",
        presets: BOTH,
        specs: |session| session.recordings.localization_specs(None),
        run: window_size::run,
    },
    Study {
        name: "reflections",
        about: "reflected intensity over time beside the distances of ray theory",
        figures: "fig08",
        presets: BOTH,
        specs: |session| session.recordings.localization_specs(None),
        run: reflections::run,
    },
    Study {
        name: "periods",
        about: "position error and paths for several numbers M of periods in a block",
        figures: "fig_periods",
        presets: BOTH,
        specs: |session| session.recordings.localization_specs(None),
        run: periods::run,
    },
    Study {
        name: "angular-resolution",
        about: "width of one exact echo over the direction for M = 1 to 8, beside theory",
        figures: "fig_angular_resolution",
        presets: BOTH,
        specs: |_| Vec::new(),
        run: angular_resolution::run,
    },
    Study {
        name: "snr",
        about: "position error over the signal-to-noise ratio, eqs. (19)-(21)",
        figures: "fig09",
        presets: PAPER,
        specs: snr::specs,
        run: snr::run,
    },
    Study {
        name: "schemes",
        about: "position error when the field is computed with the standard leapfrog scheme",
        figures: "-",
        presets: PAPER,
        specs: schemes::specs,
        run: schemes::run,
    },
    Study {
        name: "step-time",
        about: "compute time of one step, Doppler bank and filter",
        figures: "fig17",
        presets: BOTH,
        specs: |session| session.recordings.localization_specs(None),
        run: step_time::run,
    },
    Study {
        name: "dual-circle",
        about: "position from 40 kHz ranges to four receivers beside the tables of Hsu et al. (2021)",
        figures: "fig_dual_circle",
        presets: BOTH,
        specs: |_| Vec::new(),
        run: dual_circle::run,
    },
    Study {
        name: "multipath",
        about: "position from multipath arrival times by planes and a Kalman filter (2021), in a room and on the scene",
        figures: "fig_multipath_paths, fig_multipath_errors, fig_multipath_scene",
        presets: BOTH,
        specs: |session| session.recordings.localization_specs(None),
        run: multipath::run,
    },
    Study {
        name: "site",
        about: "the experimental site in simulation: slip, noise, a microphone beside the loudspeaker",
        figures: "site/fig11-fig16",
        presets: PAPER,
        // It has a session of its own; `run` asks for the recordings missing there.
        specs: |_| Vec::new(),
        run: site::run,
    },
    Study {
        name: "engine",
        about: "speed of the field computation on the scene",
        figures: "-",
        presets: BOTH,
        specs: |_| Vec::new(),
        run: engine::run,
    },
];

/// Time that looking up recordings in the cache takes at most.
const CACHED: Duration = Duration::from_secs(2);

/// Runs studies: first all simulations they need, then one after the other; the summary is written after each.
///
/// # Errors
/// The first failure. Studies finished before are on disk, and the same command resumes.
pub fn run(session: &PaperSession, studies: &[&Study]) -> Result<Summary> {
    let path = session.results().join("summary.json");
    let mut summary = if path.exists() {
        // Stages of earlier runs stay when one study runs.
        let mut summary = Summary::read(&path)?;
        let earlier = summary.provenance;
        summary.provenance = Provenance {
            seconds: earlier.seconds,
            simulation_seconds: earlier.simulation_seconds,
            peak_memory_mib: earlier.peak_memory_mib,
            ..Provenance::here()
        };
        summary
    } else {
        Summary::new(session.preset)
    };
    let started = Instant::now();
    let specs: Vec<RecordingSpec> = studies
        .iter()
        .flat_map(|study| (study.specs)(session))
        .collect();
    let mut missing = session.recordings.missing(&specs)?;
    if studies.iter().any(|study| study.name == "site") {
        // One queue for both scenes, so that no worker waits for another's last simulation between them.
        missing.extend(site::missing(session)?);
    }
    session.simulate(&missing)?;
    note_simulations(session, &specs, &mut summary)?;
    // A run that finds all recordings in the cache keeps the duration of their simulation.
    let known = summary.provenance.seconds.contains_key("simulations");
    if !known || started.elapsed() > CACHED {
        stage(&mut summary, "simulations", started);
    }
    for study in studies {
        interrupt::check()?;
        let started = Instant::now();
        (study.run)(session, &mut summary).with_context(|| format!("study {}", study.name))?;
        stage(&mut summary, study.name, started);
        let provenance = &mut summary.provenance;
        provenance.peak_memory_mib = provenance.peak_memory_mib.max(peak_memory_mib());
        summary.write(&path)?;
        session.board.say(format!(
            "study {} done in {}",
            study.name,
            duration(started.elapsed().as_secs_f64())
        ));
    }
    Ok(summary)
}
