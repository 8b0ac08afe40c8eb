//! The experimental site (2024 paper, section IV) in simulation: its studies on another scene with a robot whose wheels
//! slip and whose microphone is noisy (Figs. 11 to 16).

use anyhow::{Context, Result};

use super::PaperSession;
use super::stages::note_simulations;
use super::{layout, odometry_drift, reflections, snr, window_size};
use crate::run::interrupt;
use crate::schedule::Job;
use crate::summary::{Site, Summary};

/// The simulations that the site still needs.
pub(crate) fn missing(session: &PaperSession) -> Result<Vec<Job>> {
    let site = session.site()?;
    site.recordings.missing(&snr::specs(&site))
}

/// Runs the study: the other studies do the work, in the site's own session.
pub(crate) fn run(session: &PaperSession, summary: &mut Summary) -> Result<()> {
    let site = session.site()?;
    let specs = snr::specs(&site);
    site.simulate(&site.recordings.missing(&specs)?)?;
    // All of the site's recordings are noted below; those of another scheme of an earlier run are removed.
    let labels: Vec<String> = specs
        .iter()
        .map(|spec| site.recordings.label(spec))
        .collect();
    let of_site = |label: &str| label.starts_with(site.plan.prefix);
    (summary.provenance.simulation_seconds)
        .retain(|label, _| !of_site(label) || labels.contains(label));
    note_simulations(&site, &specs, summary)?;
    let mut own = Summary::new(session.preset);
    for study in [
        layout::run,
        odometry_drift::run,
        window_size::run,
        reflections::run,
        snr::run,
    ] {
        interrupt::check()?;
        study(&site, &mut own)?;
    }
    summary.site = Some(Site {
        odometry_drift: own.odometry_drift.context("no accuracy of the site")?,
        window_size: own.window_size,
        reflections: own.reflections.context("no reflections of the site")?,
        snr: own.snr,
    });
    Ok(())
}
