//! Verdicts: each claim of the papers beside our number, its interval and whether it holds.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Result, bail};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::rules::{Finding, RULES, at, interval};
use super::targets::{Bound, Measure, Target, Targets};
use crate::data::{atomic, json};
use crate::study::claims::Kind;
use crate::summary::Summary;

/// Verdict on a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// It holds here, and could have failed.
    Reproduced,
    /// It holds here by how we made it: arithmetic on printed tables, a sensor, a geometry or a machine of our own.
    Consistent,
    /// It does not.
    NotReproduced,
    /// Its study has not been run.
    NotRun,
    /// It cannot be tested.
    CannotBeTested,
}

/// A claim beside our number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judged {
    /// The claim.
    #[serde(flatten)]
    pub target: Target,
    /// Our number as text, or the reason why there is none.
    pub ours: String,
    /// Its 95 % interval.
    pub interval: Option<[f64; 2]>,
    /// Number of trials behind it.
    pub our_trials: Option<usize>,
    /// The verdict.
    pub verdict: Verdict,
}

impl Verdict {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::Consistent => "consistent by construction",
            Self::NotReproduced => "NOT reproduced",
            Self::NotRun => "not run",
            Self::CannotBeTested => "cannot be tested",
        }
    }
}

/// The verdicts of all claims by their ids, with which later ones are compared.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Verdicts(BTreeMap<String, Verdict>);

impl Verdicts {
    /// The verdicts of these claims.
    pub fn of(judged: &[Judged]) -> Self {
        let entry = |judged: &Judged| (judged.target.id.clone(), judged.verdict);
        Self(judged.iter().map(entry).collect())
    }

    /// Reads verdicts.
    ///
    /// # Errors
    /// When the file cannot be read, or holds something else or no verdict at all.
    pub fn read(path: &Path) -> Result<Self> {
        let verdicts: Self = json::read(path)?;
        if verdicts.0.is_empty() {
            bail!(
                "{}: holds no verdict; write it with --bless",
                path.display()
            );
        }
        Ok(verdicts)
    }

    /// Writes the verdicts.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        atomic::write(path, text.as_bytes())
    }

    /// The claims whose verdict is another now, or that are new or gone, one line each.
    pub fn changed(&self, judged: &[Judged]) -> Vec<String> {
        let now = Self::of(judged).0;
        let ids: BTreeSet<&String> = self.0.keys().chain(now.keys()).collect();
        let word = |verdict: Option<&Verdict>| verdict.map_or("no claim", |verdict| verdict.name());
        ids.into_iter()
            .filter(|id| self.0.get(*id) != now.get(*id))
            .map(|id| {
                format!(
                    "{id}: was {}, is {}",
                    word(self.0.get(id)),
                    word(now.get(id))
                )
            })
            .collect()
    }
}

/// Compares every claim with a summary.
///
/// # Errors
/// When the summary does not serialize.
pub fn judge(targets: &Targets, summary: &Summary) -> Result<Vec<Judged>> {
    let summary = serde_json::to_value(summary)?;
    Ok(targets
        .targets
        .iter()
        .map(|target| judge_one(target, &summary))
        .collect())
}

/// Compares a claim with a summary as JSON.
fn judge_one(target: &Target, summary: &Value) -> Judged {
    let finding = match &target.measure {
        Measure::Path {
            summary: path,
            bound,
        } => find(target, summary, path, *bound),
        Measure::Rule { .. } => RULES
            .iter()
            .find(|(id, _)| *id == target.id)
            .and_then(|(_, rule)| rule(summary, target)),
        Measure::Untestable { .. } => None,
    };
    let (ours, verdict) = match (&finding, &target.measure) {
        (_, Measure::Untestable { untestable }) => (untestable.clone(), Verdict::CannotBeTested),
        (None, _) => ("study not run".to_string(), Verdict::NotRun),
        (Some(finding), _) if finding.holds => {
            let verdict = match target.kind {
                Kind::Reproducible => Verdict::Reproduced,
                Kind::ByConstruction => Verdict::Consistent,
            };
            (finding.ours.clone(), verdict)
        }
        (Some(finding), _) => (finding.ours.clone(), Verdict::NotReproduced),
    };
    Judged {
        target: target.clone(),
        ours,
        interval: finding.as_ref().and_then(|finding| finding.interval),
        our_trials: finding.and_then(|finding| finding.trials),
        verdict,
    }
}

/// A number or an accuracy of the summary against the value.
fn find(target: &Target, summary: &Value, path: &str, bound: Bound) -> Option<Finding> {
    let found = at(summary, path)?;
    let number = found.as_f64().or_else(|| found["mae_m"].as_f64())?;
    let limit = target.value?;
    let is_accuracy = found.is_object();
    let unit = if is_accuracy || path.ends_with("_m") {
        " m"
    } else {
        ""
    };
    Some(Finding {
        ours: format!("{number:.3}{unit}"),
        interval: interval(found),
        trials: found["trials"].as_u64().map(|count| count as usize),
        holds: match bound {
            Bound::AtMost => number <= limit + target.tolerance,
            Bound::Near => (number - limit).abs() <= target.tolerance,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Accuracy;
    use crate::summary::{Methods, WindowCell};

    fn accuracy(mae_m: f64) -> Accuracy {
        Accuracy::over(&[(&[mae_m], &[0.0])])
    }

    #[test]
    fn every_claim_is_whole_and_every_rule_has_one_claim() {
        let file = Targets::load().unwrap();
        let ids: BTreeSet<&str> = file
            .targets
            .iter()
            .map(|target| target.id.as_str())
            .collect();
        assert_eq!(ids.len(), file.targets.len(), "ids are unique");
        let ruled: BTreeSet<&str> = file
            .targets
            .iter()
            .filter(|target| matches!(target.measure, Measure::Rule { .. }))
            .map(|target| target.id.as_str())
            .collect();
        let rules: BTreeSet<&str> = RULES.iter().map(|(id, _)| *id).collect();
        assert_eq!(rules.len(), RULES.len(), "rules are unique");
        assert_eq!(ruled, rules);
        for target in &file.targets {
            assert!(file.papers.contains_key(&target.paper), "{}", target.id);
            assert!(!target.why.is_empty(), "{}", target.id);
            if let Measure::Path { .. } = target.measure {
                assert!(target.value.is_some(), "{}", target.id);
            }
        }
        for id in &file.shown {
            assert!(file.targets.iter().any(|target| target.id == *id), "{id}");
        }
        for paper in file.papers.keys() {
            assert!(file.targets.iter().any(|target| target.paper == *paper));
        }
    }

    #[test]
    fn an_empty_summary_reproduces_nothing() {
        let targets = Targets::load().unwrap();
        let judged = judge(&targets, &Summary::named("paper")).unwrap();
        assert!(
            judged.iter().all(|judged| {
                matches!(judged.verdict, Verdict::NotRun | Verdict::CannotBeTested)
            })
        );
    }

    #[test]
    fn only_a_verdict_that_changed_is_told() {
        let judged = judge(&Targets::load().unwrap(), &Summary::named("paper")).unwrap();
        let known = Verdicts::of(&judged);
        assert!(known.changed(&judged).is_empty());
        let mut other = judged.clone();
        other[0].verdict = Verdict::Reproduced;
        assert_eq!(
            known.changed(&other),
            ["sim-doppler-mae: was not run, is reproduced"]
        );
        assert_eq!(
            known.changed(&judged[1..]),
            ["sim-doppler-mae: was not run, is no claim"]
        );
    }

    #[test]
    fn verdicts_follow_the_numbers() {
        let mut summary = Summary::named("paper");
        summary.odometry_drift = Some(Methods {
            doppler: accuracy(0.03),
            toa_only: accuracy(0.05),
            odometry: accuracy(0.1),
        });
        summary.window_size = [1.0, 4.0, 6.0]
            .map(|half_width_m| WindowCell {
                half_width_m,
                accuracy: accuracy(0.03 + 0.01 * (half_width_m - 4.0_f64).abs()),
            })
            .to_vec();
        let judged = judge(&Targets::load().unwrap(), &summary).unwrap();
        let verdict = |id: &str| {
            let found = judged.iter().find(|judged| judged.target.id == id);
            found.map(|judged| judged.verdict)
        };
        assert_eq!(verdict("sim-doppler-mae"), Some(Verdict::Reproduced));
        assert_eq!(verdict("sim-odometry-drifts"), Some(Verdict::NotReproduced));
        assert_eq!(verdict("sim-toa-worse"), Some(Verdict::Reproduced));
        assert_eq!(verdict("sim-best-window"), Some(Verdict::Reproduced));
        assert_eq!(verdict("sim-snr-3db"), Some(Verdict::NotRun));
        assert_eq!(judged[0].ours, "0.030 m");
        assert_eq!(judged[0].interval, Some([0.03, 0.03]));
        assert_eq!(judged[0].our_trials, Some(1));
    }
}
