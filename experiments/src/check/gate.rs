//! Regression gate: the errors of a summary against those of a committed baseline.

use std::path::Path;

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};

use crate::data::table::aligned;
use crate::data::{atomic, json};
use crate::metrics::Accuracy;
use crate::study::{CellScores, StudySummary};
use crate::summary::Summary;

/// Share by which an error may grow beyond the mean of the baseline.
const TOLERANCE: f64 = 0.10;
/// Largest error that a baseline can hold, metres: no scene is as wide.
const WORST_M: f64 = 1000.0;
/// Rounding of the numbers in a summary, metres.
const ROUNDING_M: f64 = 1e-5;

/// Accuracies that later summaries are compared with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    /// Name of the study.
    #[serde(alias = "preset")]
    pub name: String,
    /// Revision it was taken from.
    pub commit: String,
    /// Accuracies by name.
    pub measures: Vec<Measure>,
}

/// One accuracy of a baseline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Name, e.g. `window_size 4 m`.
    pub name: String,
    /// Mean absolute error, metres.
    pub mae_m: f64,
    /// Its 95 % interval, metres.
    pub interval_m: [f64; 2],
}

/// Verdict on one measure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// Name of the measure.
    pub name: String,
    /// Error in the baseline, metres.
    pub baseline_m: f64,
    /// Error now, metres; absent when the summary lacks it.
    pub now_m: Option<f64>,
    /// Greatest error that passes, metres.
    pub limit_m: f64,
    /// Whether it passes.
    pub passed: bool,
}

/// The named accuracies of a summary that the gate compares.
fn measures(summary: &Summary) -> Vec<Measure> {
    let measure = |name: String, accuracy: &Accuracy| Measure {
        name,
        mae_m: accuracy.mae_m,
        interval_m: accuracy.interval_m,
    };
    let mut list = Vec::new();
    if let Some(methods) = &summary.odometry_drift {
        list.push(measure("drift doppler".into(), &methods.doppler));
        list.push(measure("drift toa-only".into(), &methods.toa_only));
        list.push(measure("drift odometry".into(), &methods.odometry));
    }
    for cell in &summary.window_size {
        list.push(measure(
            format!("window {} m", cell.half_width_m),
            &cell.accuracy,
        ));
    }
    for cell in &summary.periods {
        list.push(measure(format!("periods {}", cell.m), &cell.accuracy));
    }
    for cell in &summary.snr {
        list.push(measure(format!("snr {} dB", cell.snr_db), &cell.accuracy));
    }
    if let Some(schemes) = &summary.schemes {
        list.push(measure("slf doppler".into(), &schemes.slf.doppler));
        list.push(measure("slf toa-only".into(), &schemes.slf.toa_only));
    }
    list
}

impl Baseline {
    /// The errors of the papers' studies.
    pub fn of(summary: &Summary) -> Self {
        Self {
            name: summary.name.clone(),
            commit: summary.provenance.commit.clone(),
            measures: measures(summary),
        }
    }

    /// The errors of a study: one of every cell and method that gave poses in all trials.
    pub fn of_study(summary: &StudySummary) -> Self {
        let measure = |scores: &CellScores| -> Option<Measure> {
            let method = scores.method.name();
            let name = match scores.labels.is_empty() {
                true => method.to_string(),
                false => format!("{method}, {}", scores.cell),
            };
            (scores.failed == 0).then_some(Measure {
                name,
                mae_m: *scores.mean.get("mae_m")?,
                interval_m: *scores.interval.get("mae_m")?,
            })
        };
        Self {
            name: summary.study.name.clone(),
            commit: summary.provenance.commit.clone(),
            measures: summary.cells.iter().filter_map(measure).collect(),
        }
    }

    /// Reads a baseline.
    ///
    /// # Errors
    /// When the file cannot be read, or [`Baseline::check`] refuses it.
    pub fn read(path: &Path, name: &str) -> Result<Self> {
        let text = std::fs::read_to_string(path)
            .with_context(|| format!("{}: no baseline; make one with --bless", path.display()))?;
        Self::parse(&text, path, name)
    }

    /// Reads the text of a baseline; errors name `origin`.
    ///
    /// # Errors
    /// As [`Baseline::read`].
    pub fn parse(text: &str, origin: &Path, name: &str) -> Result<Self> {
        let baseline: Self = json::parse(text, origin)?;
        baseline.check(origin, name)?;
        Ok(baseline)
    }

    /// Refuses a baseline against which nothing could fail: of another study, without measures, or with numbers that
    /// no drive gives.
    ///
    /// # Errors
    /// One that names `origin` and the measure.
    pub fn check(&self, origin: &Path, name: &str) -> Result<()> {
        let origin = origin.display();
        if self.name != name {
            bail!(
                "{origin}: name: is {}, the summary is of {name}; give the baseline of that study",
                self.name,
            );
        }
        if self.measures.is_empty() {
            bail!("{origin}: measures: there are none; make a baseline with --bless");
        }
        for (index, measure) in self.measures.iter().enumerate() {
            let field = format!("measures[{index}] ({})", measure.name);
            let [low, high] = measure.interval_m;
            let numbers = [low, measure.mae_m, high];
            let possible = |number: &f64| (0.0..=WORST_M).contains(number);
            // Rounding may put the mean of equal numbers outside of their interval.
            let in_order = low <= measure.mae_m + ROUNDING_M && measure.mae_m <= high + ROUNDING_M;
            if !(numbers.iter().all(possible) && in_order) {
                bail!(
                    "{origin}: {field}: {} m in [{low}, {high}] m is impossible; give errors of 0 to {WORST_M} m \
                    within their interval",
                    measure.mae_m
                );
            }
            if self.measures[..index]
                .iter()
                .any(|other| other.name == measure.name)
            {
                bail!("{origin}: {field}: is there twice; leave one out");
            }
        }
        Ok(())
    }

    /// Writes the baseline.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        atomic::write(path, text.as_bytes())
    }

    /// Verdicts on the errors of `now`: a measure fails when its error lies above the interval of the baseline and
    /// above its mean by more than 10 %, or when it is missing.
    pub fn judge(&self, now: &Self) -> Vec<Verdict> {
        self.measures
            .iter()
            .map(|measure| {
                let limit_m = measure.interval_m[1].max((1.0 + TOLERANCE) * measure.mae_m);
                let now_m = (now.measures.iter())
                    .find(|other| other.name == measure.name)
                    .map(|other| other.mae_m);
                Verdict {
                    name: measure.name.clone(),
                    baseline_m: measure.mae_m,
                    now_m,
                    limit_m,
                    passed: now_m.is_some_and(|error| (0.0..=limit_m).contains(&error)),
                }
            })
            .collect()
    }
}

/// The verdicts as a table.
pub fn table(verdicts: &[Verdict]) -> String {
    let mut rows = vec![
        ["measure", "baseline [m]", "now [m]", "limit [m]", "verdict"]
            .map(String::from)
            .to_vec(),
    ];
    rows.extend(verdicts.iter().map(|verdict| {
        vec![
            verdict.name.clone(),
            format!("{:.4}", verdict.baseline_m),
            verdict
                .now_m
                .map_or("missing".to_string(), |now| format!("{now:.4}")),
            format!("{:.4}", verdict.limit_m),
            if verdict.passed { "ok" } else { "WORSE" }.to_string(),
        ]
    }));
    aligned(&rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::summary::Methods;

    fn summary(doppler: &[f64]) -> Summary {
        let accuracy = |errors: &[f64]| {
            let trials: Vec<(&[f64], &[f64])> = errors
                .iter()
                .map(|error| (std::slice::from_ref(error), &[0.0][..]))
                .collect();
            Accuracy::over(&trials)
        };
        let mut summary = Summary::named("quick");
        summary.odometry_drift = Some(Methods {
            doppler: accuracy(doppler),
            toa_only: accuracy(&[0.1]),
            odometry: accuracy(&[0.5]),
        });
        summary
    }

    #[test]
    fn a_baseline_that_cannot_fail_is_refused() {
        let good = Baseline::of(&summary(&[0.04, 0.05, 0.06]));
        let origin = Path::new("quick.json");
        good.check(origin, "quick").unwrap();
        let refused = |baseline: &Baseline, name, word: &str| {
            let message = format!("{:#}", baseline.check(origin, name).unwrap_err());
            assert!(
                message.contains("quick.json") && message.contains(word),
                "{message}"
            );
        };
        refused(&good, "paper", "name");
        let empty = Baseline {
            measures: Vec::new(),
            ..good.clone()
        };
        refused(&empty, "quick", "there are none");
        for (mae_m, interval_m) in [
            (-0.1, [-0.2, 0.1]),
            (1e30, [0.0, 1e30]),
            (0.05, [0.06, 0.07]),
            (0.05, [0.01, 0.02]),
            (f64::NAN, [0.0, 1.0]),
            (0.05, [0.0, f64::INFINITY]),
        ] {
            let mut bad = good.clone();
            bad.measures[1].mae_m = mae_m;
            bad.measures[1].interval_m = interval_m;
            refused(&bad, "quick", "drift toa-only");
        }
        let mut twice = good.clone();
        twice.measures.push(twice.measures[0].clone());
        refused(&twice, "quick", "twice");
    }

    #[test]
    fn only_a_clear_loss_fails() {
        let baseline = Baseline::of(&summary(&[0.04, 0.05, 0.06]));
        let passed = |now: &[f64]| baseline.judge(&Baseline::of(&summary(now)))[0].passed;
        assert!(passed(&[0.05]));
        assert!(passed(&[0.01]));
        assert!(passed(&[0.055]), "within 10 %");
        assert!(!passed(&[0.08]));
        let verdicts = baseline.judge(&Baseline::of(&Summary::named("quick")));
        assert!(
            verdicts.iter().all(|verdict| !verdict.passed),
            "missing measures fail"
        );
        assert!(table(&verdicts).contains("missing"));
    }
}
