//! The papers' studies. Each reads recordings of a session, writes data files, and fills its part of the summary.

mod angular_resolution;
mod cells;
mod dual_circle;
mod engine;
mod file;
mod layout;
mod limits;
mod multipath;
mod odometry_drift;
mod periods;
mod reflections;
mod schemes;
mod session;
mod site;
mod snr;
mod stages;
mod step_time;
mod study;
mod window_size;

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};

use self::stages::{note_simulations, stage};
use crate::data::frames::FRAMES;
use crate::figures;
use crate::recordings::spec::RecordingSpec;
use crate::run::interrupt;
use crate::run::progress::duration;
use crate::run::provenance::{SIMULATIONS, peak_memory_mib};
use crate::schedule::Job;
use crate::summary::Summary;

pub use self::file::{PaperSeeds, Papers, PapersFile, json_schema};
pub use self::session::PaperSession;
pub use self::study::{About, PaperStudy, STUDIES, SiteStudy};

/// Runs studies: first the simulations that are [`missing()`], then one after the other; the summary is written after
/// each.
///
/// # Errors
/// The first failure. Studies finished before are on disk, and the same command resumes.
pub fn run(session: &PaperSession, studies: &[&PaperStudy], missing: &[Job]) -> Result<Summary> {
    let path = session.results().join("summary.json");
    let mut summary = begun(session, &path)?;
    let started = Instant::now();
    let specs = specs(session, studies);
    session.simulate(missing)?;
    note_simulations(session, &specs, &mut summary)?;
    // Only who simulates all of it knows how long that takes; a run that finds all of it in the cache keeps what is
    // known, and one that finds a part knows nothing.
    if missing.len() == needed(session, studies)? {
        stage(&mut summary, SIMULATIONS, started);
    } else if !missing.is_empty() {
        summary.provenance.seconds.remove(SIMULATIONS);
    }
    for study in studies {
        interrupt::check()?;
        let started = Instant::now();
        (study.run(session, &mut summary)).with_context(|| format!("study {}", study.name()))?;
        stage(&mut summary, study.name(), started);
        let provenance = &mut summary.provenance;
        provenance.peak_memory_mib = provenance.peak_memory_mib.max(peak_memory_mib());
        summary.write(&path)?;
        session.board.say(format!(
            "study {} done in {}",
            study.name(),
            duration(started.elapsed().as_secs_f64())
        ));
    }
    Ok(summary)
}

/// The summary that the studies fill: that of an earlier run of the same scene, robot, values and seeds, whose other
/// studies stay, or a new one.
fn begun(session: &PaperSession, path: &Path) -> Result<Summary> {
    let mut new = Summary::new(&session.papers.file);
    if !path.exists() {
        return Ok(new);
    }
    let earlier = Summary::read(path)?;
    let agrees = |file: &PapersFile| session.papers.agrees_with(file);
    if !earlier.study.as_ref().is_none_or(agrees) {
        remove_data(session.results())?;
        return Ok(new);
    }
    new.provenance.seconds = earlier.provenance.seconds.clone();
    new.provenance.simulation_seconds = earlier.provenance.simulation_seconds.clone();
    new.provenance.peak_memory_mib = earlier.provenance.peak_memory_mib;
    Ok(Summary {
        name: new.name,
        study: new.study,
        provenance: new.provenance,
        ..earlier
    })
}

/// Removes what figures would be drawn of: the data files of studies of another scene, robot or values.
fn remove_data(results: &Path) -> Result<()> {
    for folder in [results.to_path_buf(), results.join("site")] {
        for name in figures::data_files().chain([FRAMES]) {
            let file = folder.join("data").join(name);
            if file.exists() {
                std::fs::remove_file(&file).with_context(|| file.display().to_string())?;
            }
        }
    }
    Ok(())
}

/// The recordings of the session's scene that studies need.
fn specs(session: &PaperSession, studies: &[&PaperStudy]) -> Vec<RecordingSpec> {
    let specs = studies.iter().flat_map(|study| study.specs(session));
    specs.collect()
}

/// Number of the recordings that studies need.
fn needed(session: &PaperSession, studies: &[&PaperStudy]) -> Result<usize> {
    let mut needed = session.recordings.jobs(&specs(session, studies))?.len();
    for study in studies {
        if let PaperStudy::Site(study) = study {
            needed += site::needed(session, study)?;
        }
    }
    Ok(needed)
}

/// The simulations that studies still need: one queue for scene and site, so that no worker waits for another's last
/// simulation between them.
///
/// # Errors
/// When a scene does not have the drives, or the cache cannot be read.
pub fn missing(session: &PaperSession, studies: &[&PaperStudy]) -> Result<Vec<Job>> {
    let mut missing = session.recordings.missing(&specs(session, studies))?;
    for study in studies {
        if let PaperStudy::Site(study) = study {
            missing.extend(site::missing(session, study)?);
        }
    }
    Ok(missing)
}
