//! The papers' claims as data (`experiments/targets.json`), each held against a summary: our number, its interval, a verdict.
//!
//! A claim is measured by a path into `summary.json` and a bound, or by a rule of the same id in [`super::rules`], or it
//! cannot be tested and says why.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::rules::RULES;
use crate::summary::Summary;

/// The file, part of the program so that it works from any folder.
const FILE: &str = include_str!("../../targets.json");

/// All claims and the papers that make them.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Targets {
    /// Citation of each paper by its key.
    pub papers: BTreeMap<String, String>,
    /// Ids of the claims that README shows.
    pub shown: Vec<String>,
    /// What has to be known to read the numbers, one sentence or two each.
    pub caveats: Vec<String>,
    /// The claims.
    pub targets: Vec<Target>,
}

/// A claim of a paper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// Short name, unique.
    pub id: String,
    /// Key of the paper.
    pub paper: String,
    /// Figure, table or section.
    pub source: String,
    /// What is claimed.
    pub claim: String,
    /// The paper's number or word.
    pub claimed: String,
    /// The number that ours is held against, in SI units unless the claim says otherwise; none for an order.
    pub value: Option<f64>,
    /// By how much ours may miss it.
    pub tolerance: f64,
    /// Why this value and tolerance.
    pub why: String,
    /// Trials that are asked for; none where there is nothing to repeat.
    pub trials: Option<usize>,
    /// How ours is found.
    pub measure: Measure,
}

/// How our number is found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum Measure {
    /// A number or an accuracy of the summary.
    Path {
        /// Keys from the summary's root, joined by dots.
        summary: String,
        /// On which side of the value ours has to lie.
        bound: Bound,
    },
    /// The rule of the same id in the program, and what it does.
    Rule {
        /// What it does, in words.
        rule: String,
    },
    /// Not at all.
    Untestable {
        /// Why.
        untestable: String,
    },
}

/// On which side of a value a number has to lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bound {
    /// At most the value and the tolerance.
    AtMost,
    /// Within the tolerance on both sides.
    Near,
}

/// What a summary says to a claim.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Our number, in words.
    pub ours: String,
    /// Its 95 % interval, where it has one.
    pub interval: Option<[f64; 2]>,
    /// Number of trials behind it, where there are several.
    pub trials: Option<usize>,
    /// Whether the claim holds.
    pub holds: bool,
}

/// Verdict on a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// It holds here.
    Reproduced,
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
    /// Our number in words, or why there is none.
    pub ours: String,
    /// Its 95 % interval.
    pub interval: Option<[f64; 2]>,
    /// Number of trials behind it.
    pub our_trials: Option<usize>,
    /// The verdict.
    pub verdict: Verdict,
}

impl Targets {
    /// The claims of the project.
    ///
    /// # Errors
    /// When the file has a field that is not known or lacks one.
    pub fn load() -> Result<Self> {
        serde_json::from_str(FILE).context("experiments/targets.json")
    }

    /// Holds every claim against a summary.
    ///
    /// # Errors
    /// When the summary does not serialize.
    pub fn judge(&self, summary: &Summary) -> Result<Vec<Judged>> {
        let summary = serde_json::to_value(summary)?;
        Ok(self
            .targets
            .iter()
            .map(|target| target.judge(&summary))
            .collect())
    }
}

impl Target {
    /// Holds the claim against a summary as JSON.
    fn judge(&self, summary: &Value) -> Judged {
        let finding = match &self.measure {
            Measure::Path {
                summary: path,
                bound,
            } => self.find(summary, path, *bound),
            Measure::Rule { .. } => RULES
                .iter()
                .find(|(id, _)| *id == self.id)
                .and_then(|(_, rule)| rule(summary, self)),
            Measure::Untestable { .. } => None,
        };
        let (ours, verdict) = match (&finding, &self.measure) {
            (_, Measure::Untestable { untestable }) => {
                (untestable.clone(), Verdict::CannotBeTested)
            }
            (None, _) => ("study not run".to_string(), Verdict::NotRun),
            (Some(finding), _) if finding.holds => (finding.ours.clone(), Verdict::Reproduced),
            (Some(finding), _) => (finding.ours.clone(), Verdict::NotReproduced),
        };
        Judged {
            target: self.clone(),
            ours,
            interval: finding.as_ref().and_then(|finding| finding.interval),
            our_trials: finding.and_then(|finding| finding.trials),
            verdict,
        }
    }

    /// A number or an accuracy of the summary against the value.
    fn find(&self, summary: &Value, path: &str, bound: Bound) -> Option<Finding> {
        let found = at(summary, path)?;
        let number = found.as_f64().or_else(|| found["mae_m"].as_f64())?;
        let limit = self.value?;
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
                Bound::AtMost => number <= limit + self.tolerance,
                Bound::Near => (number - limit).abs() <= self.tolerance,
            },
        })
    }
}

/// The part of a summary at keys joined by dots, unless it is missing or null.
pub(super) fn at<'a>(summary: &'a Value, path: &str) -> Option<&'a Value> {
    path.split('.')
        .try_fold(summary, |value, key| value.get(key))
        .filter(|value| !value.is_null())
}

/// The 95 % interval of an accuracy.
pub(super) fn interval(accuracy: &Value) -> Option<[f64; 2]> {
    let ends = accuracy["interval_m"].as_array()?;
    Some([ends.first()?.as_f64()?, ends.get(1)?.as_f64()?])
}

impl Verdict {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::NotReproduced => "NOT reproduced",
            Self::NotRun => "not run",
            Self::CannotBeTested => "cannot be tested",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Accuracy;
    use crate::preset::Preset;
    use crate::summary::{Methods, WindowCell};
    use std::collections::BTreeSet;

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
        let judged = Targets::load()
            .unwrap()
            .judge(&Summary::new(Preset::Paper))
            .unwrap();
        assert!(
            judged.iter().all(|judged| {
                matches!(judged.verdict, Verdict::NotRun | Verdict::CannotBeTested)
            })
        );
    }

    #[test]
    fn verdicts_follow_the_numbers() {
        let mut summary = Summary::new(Preset::Paper);
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
        let judged = Targets::load().unwrap().judge(&summary).unwrap();
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
