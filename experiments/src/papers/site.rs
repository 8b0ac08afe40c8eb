//! The experimental site (2024 paper, section IV) in simulation: its studies on another scene with a robot whose wheels
//! slip and whose microphone is noisy (Figs. 11 to 16).

use anyhow::{Context, Result};

use super::session::SITE;
use super::stages::note_simulations;
use super::study::{PaperStudy, SiteStudy};
use super::{PaperSession, snr};
use crate::run::interrupt;
use crate::schedule::Job;
use crate::summary::{Site, Summary};

/// The simulations that the site still needs.
pub(super) fn missing(session: &PaperSession, study: &SiteStudy) -> Result<Vec<Job>> {
    let site = session.site(study)?;
    site.recordings.missing(&snr::specs(&site))
}

/// Number of the recordings that the site needs.
pub(super) fn needed(session: &PaperSession, study: &SiteStudy) -> Result<usize> {
    let site = session.site(study)?;
    Ok(site.recordings.jobs(&snr::specs(&site))?.len())
}

/// Runs the study: the other studies do the work, in the site's own session.
pub(super) fn run(session: &PaperSession, study: &SiteStudy, summary: &mut Summary) -> Result<()> {
    let site = session.site(study)?;
    let specs = snr::specs(&site);
    site.simulate(&site.recordings.missing(&specs)?)?;
    // All of the site's recordings are noted below; those of another scheme of an earlier run are removed.
    let labels: Vec<String> = specs
        .iter()
        .map(|spec| site.recordings.label(spec))
        .collect();
    let of_site = |label: &str| label.starts_with(SITE);
    (summary.provenance.simulation_seconds)
        .retain(|label, _| !of_site(label) || labels.contains(label));
    note_simulations(&site, &specs, summary)?;
    let mut own = Summary::new(&session.papers.file);
    for part in [
        PaperStudy::Layout {},
        PaperStudy::OdometryDrift {},
        PaperStudy::WindowSize {
            half_widths_m: study.half_widths_m.clone(),
        },
        PaperStudy::Reflections {},
        PaperStudy::Snr {
            snr_db: study.snr_db.clone(),
        },
    ] {
        interrupt::check()?;
        part.run(&site, &mut own)?;
    }
    summary.site = Some(Site {
        odometry_drift: own.odometry_drift.context("no accuracy of the site")?,
        window_size: own.window_size,
        reflections: own.reflections.context("no reflections of the site")?,
        snr: own.snr,
    });
    Ok(())
}
