//! `echolot check`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use super::arguments::ForceArgument;
use super::output::{print, print_json};
use super::study_files::{Loaded, files};
use crate::check::gate::{self, Baseline};
use crate::check::targets::Targets;
use crate::check::verdicts::{Verdicts, judge};
use crate::check::{CheckFailed, readme, report};
use crate::data::place::Place;
use crate::papers::Papers;
use crate::study::StudySummary;
use crate::summary::Summary;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  echolot check studies/quick\n\n\
    A study file names what its results are held against. `baseline`: fails when an error lies above its baseline by \
    more than the baseline's interval and 10 %. `verdicts`: compares the claims of experiments/targets.json with the \
    summary, writes report.md beside it, and fails when a verdict is another than in that file. --bless writes \
    either.")]
pub(crate) struct Arguments {
    /// Study files or folders of them.
    #[arg(required = true, value_name = "STUDY")]
    studies: Vec<PathBuf>,
    /// Folder of the results; each study's folder is below it.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Baseline of the regression gate instead of the study's.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Markdown file in which the claims and the commands' times are put between their marks (with verdicts).
    #[arg(long, value_name = "FILE")]
    into: Option<PathBuf>,
    /// Make the present summary the baseline, or its verdicts the known ones.
    #[arg(long)]
    bless: bool,
    #[command(flatten)]
    force: ForceArgument,
}

/// What results are held against.
enum Against {
    /// Errors.
    Baseline(PathBuf),
    /// Verdicts on the papers' claims.
    Verdicts(PathBuf),
}

/// How many of how many failed, and what.
type Failed = (usize, usize, &'static str);

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        let files = files(&self.studies)?;
        if self.baseline.is_some() && files.len() > 1 {
            bail!("--baseline: is for one study; name one study file");
        }
        let mut failures = Vec::new();
        for file in &files {
            let study = Loaded::read(file)?;
            let summary = self.results.join(study.name()).join("summary.json");
            if !summary.exists() {
                bail!(
                    "{}: there is no summary to check; `echolot run {}` makes it",
                    summary.display(),
                    file.display()
                );
            }
            let (failed, of, what) = match (&study, self.against(&study, file)?) {
                (Loaded::Papers(papers), Against::Verdicts(known)) => {
                    self.verdicts(papers, &summary, &known, json)?
                }
                (study, Against::Baseline(known) | Against::Verdicts(known)) => {
                    self.errors(study, &summary, &known, json)?
                }
            };
            if failed > 0 {
                failures.push(format!("{}: {failed} of {of} {what}", study.name()));
            }
        }
        match failures.is_empty() {
            true => Ok(()),
            false => Err(CheckFailed(failures.join("; ")).into()),
        }
    }

    /// What the results of a study are held against.
    fn against(&self, study: &Loaded, file: &Path) -> Result<Against> {
        if let Some(baseline) = &self.baseline {
            return Ok(Against::Baseline(baseline.clone()));
        }
        let (baseline, verdicts) = match study {
            Loaded::Study(study) => (
                study.file.baseline.as_deref().map(|f| study.beside(f)),
                None,
            ),
            Loaded::Papers(papers) => {
                let beside = |file: &Option<PathBuf>| file.as_deref().map(|f| papers.beside(f));
                (beside(&papers.file.baseline), beside(&papers.file.verdicts))
            }
        };
        let known = verdicts
            .map(Against::Verdicts)
            .or(baseline.map(Against::Baseline));
        known.ok_or_else(|| {
            anyhow::anyhow!(
                "{}: baseline: there is none; name a file in the study, or give --baseline FILE",
                file.display()
            )
        })
    }

    /// Errors of a study against a baseline, which --bless makes.
    fn errors(&self, study: &Loaded, summary: &Path, file: &Path, json: bool) -> Result<Failed> {
        let now = match study {
            Loaded::Study(_) => Baseline::of_study(&StudySummary::read(summary)?),
            Loaded::Papers(_) => Baseline::of(&Summary::read(summary)?),
        };
        if self.bless {
            self.place(summary, file)
                .file(|bytes| serde_json::from_slice::<Baseline>(bytes).is_ok())?;
            now.check(summary, study.name())?;
            now.write(file)?;
            eprintln!("wrote {}", file.display());
            return Ok((0, 0, ""));
        }
        let verdicts = Baseline::read(file, study.name())?.judge(&now);
        match json {
            true => print_json(&verdicts)?,
            false => print(&gate::table(&verdicts))?,
        }
        let failed = verdicts.iter().filter(|verdict| !verdict.passed).count();
        Ok((failed, verdicts.len(), "measures worse than the baseline"))
    }

    /// Verdicts on the papers' claims against those that are known, which --bless makes.
    fn verdicts(&self, papers: &Papers, file: &Path, known: &Path, json: bool) -> Result<Failed> {
        let summary = Summary::read(file)?;
        let targets = Targets::load()?;
        let judged = judge(&targets, &summary)?;
        if self.bless {
            self.place(file, known)
                .file(|bytes| serde_json::from_slice::<Verdicts>(bytes).is_ok())?;
            Verdicts::of(&judged).write(known)?;
            eprintln!("wrote {}", known.display());
            return Ok((0, 0, ""));
        }
        let folder = self.results.join(&papers.file.name);
        report::write(&folder, &targets, &judged, &summary)?;
        if let Some(file) = &self.into {
            let [quick, large] = readme::runs(&self.results, &summary.provenance)?;
            let layouts = readme::random_layouts(&self.results)?;
            let blocks = [
                readme::claims(&targets, &judged, layouts.as_ref()),
                readme::commands(&quick, &large),
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
        let changed = Verdicts::read(known)?.changed(&judged);
        for line in &changed {
            eprintln!("{line}");
        }
        Ok((changed.len(), judged.len(), "verdicts changed"))
    }

    /// The place of what --bless writes.
    fn place(&self, summary: &Path, file: &Path) -> Place {
        Place {
            inputs: vec![summary.to_path_buf()],
            ..Place::of(file, self.force.force)
        }
    }
}
