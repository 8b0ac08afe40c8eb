//! The papers' claims as data (`experiments/targets.json`).
//!
//! A claim is measured by a path into `summary.json` and a bound, or by a rule of the same id in [`super::rules`], or
//! it cannot be tested and gives the reason.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use crate::study::claims::Kind;

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
    /// Caveats to the numbers, one sentence or two each.
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
    /// Whether it could have failed.
    #[serde(default)]
    pub kind: Kind,
    /// The claim.
    pub claim: String,
    /// The paper's number or word.
    pub claimed: String,
    /// The number that ours is compared with, in SI units unless the claim gives another; `None` for an order.
    pub value: Option<f64>,
    /// Greatest difference of ours that passes.
    pub tolerance: f64,
    /// The reason for this value and tolerance.
    pub why: String,
    /// Trials that are required; `None` where there is nothing to repeat.
    pub trials: Option<usize>,
    /// The way to our number.
    pub measure: Measure,
    /// Claim of the study of random layouts (`studies/papers/ensemble.json`) that asks the same of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layouts: Option<String>,
}

/// The way to our number.
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
    /// The rule of the same id in the program.
    Rule {
        /// Description of the rule.
        rule: String,
    },
    /// The claim cannot be tested.
    Untestable {
        /// The reason.
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

impl Targets {
    /// The claims of the project.
    ///
    /// # Errors
    /// When the file has a field that is not known or lacks one.
    pub fn load() -> Result<Self> {
        serde_json::from_str(FILE).context("experiments/targets.json")
    }
}
