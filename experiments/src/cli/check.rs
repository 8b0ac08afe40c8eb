//! `echolot check`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use super::arguments::ForceArgument;
use super::output::{print, print_json};
use crate::check::gate::{self, Baseline};
use crate::check::targets::Targets;
use crate::check::verdicts::{Verdicts, judge};
use crate::check::{CheckFailed, readme, report};
use crate::data::place::Place;
use crate::run::preset::Preset;
use crate::summary::Summary;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  echolot check --preset quick\n\n\
    quick: fails when an error lies above its baseline by more than the baseline's interval and 10 %.\n\
    paper: compares the claims of experiments/targets.json with the summary, writes report.md beside it, and fails \
    when a verdict is another than in experiments/baselines/verdicts.json, which --bless writes.")]
pub(crate) struct Arguments {
    /// Preset that is checked.
    #[arg(long, value_enum, default_value_t = Preset::Quick)]
    preset: Preset,
    /// Folder of the results.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Baseline of the regression gate; `experiments/baselines/<preset>.json` unless given.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Markdown file in which the claims and the commands' times are put between their marks (paper).
    #[arg(long, value_name = "FILE")]
    into: Option<PathBuf>,
    /// Make the present summary the baseline.
    #[arg(long)]
    bless: bool,
    #[command(flatten)]
    force: ForceArgument,
}

/// Verdicts that the claims of the papers had.
const VERDICTS: &str = "experiments/baselines/verdicts.json";

/// The summary of a preset.
fn summary_of(results: &Path, preset: Preset) -> PathBuf {
    results.join(preset.name()).join("summary.json")
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let file = summary_of(&self.results, self.preset);
        if !file.exists() {
            bail!(
                "{}: there is no summary to check; `echolot run --preset {}` makes it",
                file.display(),
                self.preset.name()
            );
        }
        let summary = Summary::read(&file)?;
        let baseline = self.baseline.clone().unwrap_or_else(|| {
            PathBuf::from(format!("experiments/baselines/{}.json", self.preset.name()))
        });
        if self.bless {
            let place = Place {
                inputs: vec![file],
                ..Place::of(&baseline, self.force.force)
            };
            if self.preset == Preset::Paper && self.baseline.is_none() {
                let judged = judge(&Targets::load()?, &summary)?;
                let place = Place {
                    path: PathBuf::from(VERDICTS),
                    ..place
                };
                place.file(|bytes| serde_json::from_slice::<Verdicts>(bytes).is_ok())?;
                Verdicts::of(&judged).write(Path::new(VERDICTS))?;
                eprintln!("wrote {VERDICTS}");
                return Ok(());
            }
            place.file(|bytes| serde_json::from_slice::<Baseline>(bytes).is_ok())?;
            let new = Baseline::of(&summary);
            new.check(&summary_of(&self.results, self.preset), self.preset)?;
            new.write(&baseline)?;
            eprintln!("wrote {}", baseline.display());
            return Ok(());
        }
        let (failed, of, what) = if self.preset == Preset::Paper && self.baseline.is_none() {
            let targets = Targets::load()?;
            let judged = judge(&targets, &summary)?;
            let folder = self.results.join(self.preset.name());
            report::write(&folder, &targets, &judged, &summary)?;
            if let Some(file) = &self.into {
                let quick = self.results.join("quick/summary.json");
                let quick = quick.exists().then(|| Summary::read(&quick)).transpose()?;
                let blocks = [
                    readme::claims(&targets, &judged),
                    readme::commands(quick.as_ref(), &summary),
                ];
                readme::insert(file, &blocks)?;
            }
            if json {
                print_json(&judged)?;
            } else {
                print(&report::table(&judged))?;
                eprintln!(
                    "{}; wrote {}",
                    report::count(&judged),
                    folder.join("report.md").display()
                );
            }
            let known = Verdicts::read(Path::new(VERDICTS))?;
            let changed = known.changed(&judged);
            for line in &changed {
                eprintln!("{line}");
            }
            (changed.len(), judged.len(), "verdicts changed")
        } else {
            let verdicts = Baseline::read(&baseline, self.preset)?.judge(&summary);
            if json {
                print_json(&verdicts)?;
            } else {
                print(&gate::table(&verdicts))?;
            }
            let failed = verdicts.iter().filter(|verdict| !verdict.passed).count();
            (failed, verdicts.len(), "measures worse than the baseline")
        };
        if failed > 0 {
            return Err(CheckFailed(format!("{failed} of {of} {what}")).into());
        }
        Ok(())
    }
}
