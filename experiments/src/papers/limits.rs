//! What a file of the papers' studies may hold: names, numbers of values, and their bounds.

use anyhow::{Context, Result, bail};
use localizer::Parameters;

use super::file::PapersFile;
use super::study::PaperStudy;
use crate::study::cells::MOST_SEEDS;
use crate::study::file::Settings;
use crate::study::settings::check_name;
use crate::study::{check_folder_name, check_line};

/// Most values that a study tries.
const MOST_VALUES: usize = 100;
/// Most blocks that are timed.
const MOST_BLOCKS: usize = 100_000;
/// Largest ratio of signal to noise in decibels, on both sides of 0.
const MOST_DB: f64 = 300.0;

/// Checks a file's names and values.
///
/// # Errors
/// One line that names the field and the remedy.
pub(super) fn check(file: &PapersFile) -> Result<()> {
    check_folder_name(&file.name)?;
    check_set(&file.set, file.robot.is_some())?;
    for (name, count) in [("filter", file.seeds.filter), ("noise", file.seeds.noise)] {
        if !(1..=MOST_SEEDS).contains(&count) {
            bail!("seeds.{name}: {count} is out of range; give 1 to {MOST_SEEDS}");
        }
    }
    if file.papers.is_empty() {
        bail!("papers: there are none; name at least one");
    }
    for (number, study) in file.papers.iter().enumerate() {
        let name = study.name();
        if file.papers[..number].iter().any(|s| s.name() == name) {
            bail!("papers[{number}]: {name} is there twice; leave one out");
        }
        check_study(study).with_context(|| format!("papers[{number}] ({name})"))?;
    }
    Ok(())
}

/// Checks names and texts of values.
fn check_set(set: &Settings, has_robot: bool) -> Result<()> {
    for (name, value) in set {
        check_line("set", name)?;
        check_line("set", value.as_str().unwrap_or_default())?;
        check_name(name, has_robot).with_context(|| format!("set.{name}"))?;
        if name.starts_with("noise.") {
            bail!("set.{name}: is what the study snr varies; leave it out");
        }
    }
    Ok(())
}

/// Checks the values that a study tries.
fn check_study(study: &PaperStudy) -> Result<()> {
    let windows = |values: &[f64]| {
        each("half_widths_m", values, |&half_width_m, parameters| {
            parameters.filter.window_half_width_m = half_width_m;
        })
    };
    let ratios = |values: &[f64]| {
        each("snr_db", values, |_, _| {})?;
        match values.iter().find(|db| !(-MOST_DB..=MOST_DB).contains(*db)) {
            Some(db) => bail!(
                "snr_db: {db} is out of range; give {} to {MOST_DB}",
                -MOST_DB
            ),
            None => Ok(()),
        }
    };
    match study {
        PaperStudy::WindowSize { half_widths_m } => windows(half_widths_m),
        PaperStudy::Periods { periods } => each("periods", periods, |&periods, parameters| {
            parameters.measurement.periods = periods;
        }),
        PaperStudy::Snr { snr_db } => ratios(snr_db),
        PaperStudy::StepTime {
            half_widths_m,
            blocks,
        } => {
            if !(1..=MOST_BLOCKS).contains(blocks) {
                bail!("blocks: {blocks} is out of range; give 1 to {MOST_BLOCKS}");
            }
            windows(half_widths_m)
        }
        PaperStudy::Site(site) => {
            check_set(&site.set, true)?;
            windows(&site.half_widths_m)?;
            ratios(&site.snr_db)
        }
        _ => Ok(()),
    }
}

/// Refuses an empty list, one that is too long, and values that no parameters can have.
fn each<T>(name: &str, values: &[T], put: impl Fn(&T, &mut Parameters)) -> Result<()> {
    if !(1..=MOST_VALUES).contains(&values.len()) {
        bail!(
            "{name}: has {} values; give 1 to {MOST_VALUES}",
            values.len()
        );
    }
    for (number, value) in values.iter().enumerate() {
        let mut parameters = Parameters::default();
        put(value, &mut parameters);
        (parameters.check()).with_context(|| format!("{name}[{number}]"))?;
    }
    Ok(())
}
