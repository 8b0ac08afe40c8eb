//! The experimental site (2024 paper, section IV) in simulation: its studies on another scene with a robot whose wheels slip
//! and whose microphone is noisy (Figs. 11 to 16).

use anyhow::{Context, Result};

use super::{layout, note_simulations, odometry_drift, reflections, snr, window_size};
use crate::interrupt;
use crate::laboratory::Laboratory;
use crate::schedule::Job;
use crate::summary::{Site, Summary};

/// The simulations that the site still needs.
pub(crate) fn missing(lab: &Laboratory) -> Result<Vec<Job>> {
    let site = lab.site()?;
    site.missing(&snr::takes(&site))
}

/// Runs the study: the other studies do the work, in the site's own laboratory.
pub(crate) fn run(lab: &Laboratory, summary: &mut Summary) -> Result<()> {
    let site = lab.site()?;
    let takes = snr::takes(&site);
    site.simulate(&site.missing(&takes)?)?;
    // All of the site's recordings are noted below; those of another scheme that an earlier run had made are none of its any more.
    let labels: Vec<String> = takes.iter().map(|take| site.label(take)).collect();
    let of_site = |label: &str| label.starts_with(site.plan.prefix);
    (summary.provenance.simulation_seconds)
        .retain(|label, _| !of_site(label) || labels.contains(label));
    note_simulations(&site, &takes, summary)?;
    let mut own = Summary::new(lab.preset);
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
