//! Claims of a study: what a paper or its author says, beside what came out.

use anyhow::{Result, bail};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::cells::Cell;
use super::file::{MethodName, Settings};
use super::interval::{mean_and_interval, share_interval};
use super::scores::{Measure, Row};

/// A claim.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Short name, unique in the study.
    pub id: String,
    /// The claim in words.
    pub claim: String,
    /// Whether it could have failed.
    #[serde(default)]
    pub kind: Kind,
    /// Key of the paper in references.bib, and figure, table or section.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// The paper's own words or number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub claimed: Option<String>,
    /// The reason for the test and its limits, or why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
    /// How it is tested; a claim without a test cannot be tested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub test: Option<Test>,
    /// Least share of the layouts in which it has to hold; it is tested on the mean over all unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share_of_layouts: Option<f64>,
}

/// Whether a claim could have failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// It could have failed.
    #[default]
    Reproducible,
    /// It follows from how the study is built: arithmetic on printed tables, a geometry or sensor of our own.
    ByConstruction,
}

/// Cells and method that a test looks at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Selection {
    /// The method; may be left out where the study has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<MethodName>,
    /// Values of the cells; all cells when left out.
    #[serde(default, rename = "where", skip_serializing_if = "Settings::is_empty")]
    pub cell: Settings,
}

/// How a claim is tested.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "test", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Test {
    /// A measure within bounds.
    Bound {
        /// What is measured.
        of: Selection,
        /// The measure.
        #[serde(default)]
        measure: Measure,
        /// Greatest value.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        at_most: Option<f64>,
        /// Least value.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        at_least: Option<f64>,
    },
    /// A measure over another within bounds.
    Ratio {
        /// What is measured.
        of: Selection,
        /// What it is divided by.
        over: Selection,
        /// The measure.
        #[serde(default)]
        measure: Measure,
        /// Greatest ratio.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        at_most: Option<f64>,
        /// Least ratio.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        at_least: Option<f64>,
    },
    /// Each has a smaller measure than the next.
    Order {
        /// The best first.
        of: Vec<Selection>,
        /// The measure.
        #[serde(default)]
        measure: Measure,
    },
    /// Values of a name that are as good as the best one, judged by the best one's interval, lie within bounds.
    Best {
        /// The name that varies.
        over: String,
        /// What is measured.
        of: Selection,
        /// The measure.
        #[serde(default)]
        measure: Measure,
        /// Bounds: at least one of the values as good as the best lies within.
        within: [f64; 2],
    },
}

/// Outcome of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// It holds.
    Holds,
    /// It does not.
    Fails,
    /// There is no test.
    NotTestable,
}

impl Verdict {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "DOES NOT HOLD",
            Self::NotTestable => "cannot be tested",
        }
    }
}

/// A claim beside what came out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// Name of the claim.
    pub id: String,
    /// What came out.
    pub ours: String,
    /// 95 % interval of what came out, where it has one.
    pub interval: Option<[f64; 2]>,
    /// The outcome.
    pub verdict: Verdict,
}

/// The trials of a study that tests look at.
pub(super) struct Trials<'a> {
    pub(super) cells: &'a [Cell],
    pub(super) methods: &'a [MethodName],
    pub(super) rows: Vec<&'a Row>,
}

/// What a test found.
struct Finding {
    ours: String,
    interval: Option<[f64; 2]>,
    holds: bool,
}

impl Selection {
    /// Its name in texts.
    fn name(&self) -> String {
        let method = self.method.map(|method| method.name().to_string());
        let values = self.cell.iter().map(|(name, value)| {
            let value = super::cells::label(value);
            format!("{} {value}", super::cells::short(name))
        });
        let parts: Vec<String> = method.into_iter().chain(values).collect();
        match parts.is_empty() {
            true => "all".to_string(),
            false => parts.join(", "),
        }
    }

    /// Refuses a method that the study does not have, a choice left open, and values of no cell.
    fn check(&self, cells: &[Cell], methods: &[MethodName]) -> Result<()> {
        match self.method {
            None if methods.len() > 1 => {
                bail!("method: is missing, the study has several; name one")
            }
            Some(method) if !methods.contains(&method) => {
                bail!(
                    "method: {} is not in the study; add it or name another",
                    method.name()
                )
            }
            _ => {}
        }
        if !cells.iter().any(|cell| cell.has(&self.cell)) {
            bail!("where: no cell of the study has these values; name values that vary");
        }
        Ok(())
    }
}

impl Test {
    /// What it looks at.
    pub(super) fn selections(&self) -> Vec<&Selection> {
        match self {
            Self::Bound { of, .. } | Self::Best { of, .. } => vec![of],
            Self::Ratio { of, over, .. } => vec![of, over],
            Self::Order { of, .. } => of.iter().collect(),
        }
    }
}

impl Claim {
    /// Refuses a test that could not be carried out or could not fail.
    ///
    /// # Errors
    /// One line that names the field.
    pub(super) fn check(&self, cells: &[Cell], methods: &[MethodName]) -> Result<()> {
        if let Some(share) = self
            .share_of_layouts
            .filter(|share| !(0.0..=1.0).contains(share))
        {
            bail!("share_of_layouts: {share} is out of range; give 0 to 1");
        }
        let Some(test) = &self.test else {
            if self.why.is_none() {
                bail!("test: is missing; give one, or say in `why` why there is none");
            }
            return Ok(());
        };
        for selection in test.selections() {
            selection.check(cells, methods)?;
        }
        match test {
            Test::Bound {
                at_most: None,
                at_least: None,
                ..
            }
            | Test::Ratio {
                at_most: None,
                at_least: None,
                ..
            } => {
                bail!("test: has no bound; give at_most or at_least")
            }
            Test::Order { of, .. } if of.len() < 2 => bail!("test.of: give at least two"),
            Test::Best { over, .. }
                if !cells
                    .iter()
                    .all(|cell| cell.labels.iter().any(|(name, _)| name == over)) =>
            {
                bail!("test.over: {over} does not vary; name what does")
            }
            _ => Ok(()),
        }
    }

    /// Judges the claim.
    pub(super) fn judge(&self, trials: &Trials<'_>) -> Judged {
        let Some(test) = &self.test else {
            return Judged {
                id: self.id.clone(),
                ours: self.why.clone().unwrap_or_default(),
                interval: None,
                verdict: Verdict::NotTestable,
            };
        };
        let finding = match self.share_of_layouts {
            None => test.find(trials),
            Some(least) => share(test, trials, least),
        };
        Judged {
            id: self.id.clone(),
            ours: finding.ours,
            interval: finding.interval,
            verdict: if finding.holds {
                Verdict::Holds
            } else {
                Verdict::Fails
            },
        }
    }
}

/// The share of the layouts in which a test holds.
fn share(test: &Test, trials: &Trials<'_>, least: f64) -> Finding {
    let mut layouts: Vec<(String, u64)> = trials
        .rows
        .iter()
        .map(|row| (scene_of(trials, row), row.draw[0]))
        .collect();
    layouts.sort();
    layouts.dedup();
    let held = layouts
        .iter()
        .filter(|(scene, layout)| {
            let rows = trials.rows.iter().copied();
            let of_layout = Trials {
                rows: rows
                    .filter(|row| row.draw[0] == *layout && scene_of(trials, row) == *scene)
                    .collect(),
                ..*trials
            };
            test.find(&of_layout).holds
        })
        .count();
    let share = held as f64 / layouts.len().max(1) as f64;
    Finding {
        ours: format!("in {held} of {} layouts", layouts.len()),
        interval: Some(share_interval(held, layouts.len().max(1))),
        holds: share >= least,
    }
}

/// The label of a trial's scene; empty in studies of one.
fn scene_of(trials: &Trials<'_>, row: &Row) -> String {
    let labels = &trials.cells[row.cell].labels;
    let scene = labels.iter().find(|(name, _)| name == "scene");
    scene.map_or(String::new(), |(_, value)| value.clone())
}

impl Trials<'_> {
    /// Mean and interval of a measure over the trials of a selection; a method that failed in one of them has none.
    fn mean(&self, selection: &Selection, measure: Measure) -> Option<(f64, [f64; 2])> {
        let rows = self.rows.iter().filter(|row| {
            selection
                .method
                .is_none_or(|method| self.methods[row.method] == method)
                && self.cells[row.cell].has(&selection.cell)
        });
        let values = rows
            .map(|row| {
                // Cells of a selection are draws like others.
                let [layout, slip, noise, filter] = row.draw;
                let layout = layout + ((row.cell as u64) << 40);
                Some(([layout, slip, noise, filter], row.value(measure)?))
            })
            .collect::<Option<Vec<_>>>()?;
        (!values.is_empty()).then(|| mean_and_interval(&values))
    }
}

impl Test {
    /// What the trials say.
    fn find(&self, trials: &Trials<'_>) -> Finding {
        self.found(trials).unwrap_or_else(|| Finding {
            ours: "the method failed in a trial, or has no such measure".to_string(),
            interval: None,
            holds: false,
        })
    }

    fn found(&self, trials: &Trials<'_>) -> Option<Finding> {
        let within = |value: f64, at_most: &Option<f64>, at_least: &Option<f64>| {
            at_most.is_none_or(|most| value <= most) && at_least.is_none_or(|least| value >= least)
        };
        Some(match self {
            Self::Bound {
                of,
                measure,
                at_most,
                at_least,
            } => {
                let (mean, interval) = trials.mean(of, *measure)?;
                Finding {
                    ours: format!("{mean:.4}{}", measure.unit()),
                    interval: Some(interval),
                    holds: within(mean, at_most, at_least),
                }
            }
            Self::Ratio {
                of,
                over,
                measure,
                at_most,
                at_least,
            } => {
                let (upper, _) = trials.mean(of, *measure)?;
                let (lower, _) = trials.mean(over, *measure)?;
                let unit = measure.unit();
                Finding {
                    ours: format!(
                        "{upper:.4}{unit} over {lower:.4}{unit}: {:.2}",
                        upper / lower
                    ),
                    interval: None,
                    holds: within(upper / lower, at_most, at_least),
                }
            }
            Self::Order { of, measure } => {
                let means = of
                    .iter()
                    .map(|selection| Some(trials.mean(selection, *measure)?.0))
                    .collect::<Option<Vec<f64>>>()?;
                let texts: Vec<String> = of
                    .iter()
                    .zip(&means)
                    .map(|(selection, mean)| {
                        format!("{} {mean:.4}{}", selection.name(), measure.unit())
                    })
                    .collect();
                Finding {
                    ours: texts.join("; "),
                    interval: None,
                    holds: means.is_sorted_by(|a, b| a < b),
                }
            }
            Self::Best {
                over,
                of,
                measure,
                within,
            } => {
                let mut values: Vec<(f64, f64, [f64; 2])> = Vec::new();
                for cell in trials.cells.iter().filter(|cell| cell.has(&of.cell)) {
                    let (_, value) = cell.labels.iter().find(|(name, _)| name == over)?;
                    let mut selection = of.clone();
                    let number: f64 = value.parse().ok()?;
                    selection
                        .cell
                        .insert(over.clone(), serde_json::json!(value));
                    let (mean, interval) = trials.mean(&selection, *measure)?;
                    values.push((number, mean, interval));
                }
                let best = values.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
                let good = values.iter().filter(|(_, mean, _)| *mean <= best.2[1]);
                let good: Vec<f64> = good.map(|(value, ..)| *value).collect();
                let low = good.iter().copied().fold(f64::INFINITY, f64::min);
                let high = good.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                Finding {
                    ours: format!(
                        "best at {}; as good within its interval: {low} to {high}",
                        best.0
                    ),
                    interval: None,
                    holds: good
                        .iter()
                        .any(|value| (within[0]..=within[1]).contains(value)),
                }
            }
        })
    }
}

#[cfg(test)]
mod tests;
