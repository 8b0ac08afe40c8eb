//! The scores of one trial, and the table of them: `data/trials.csv`.

use std::path::Path;

use anyhow::{Context, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::cells::{Cell, DRAWN, Draw};
use super::file::MethodName;
use crate::data::table::Table;
use crate::metrics::{mean, quantile, rounded};
use crate::trials::TrialResult;

/// What is measured of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Mean distance from the true position, metres: the papers' MAE.
    #[default]
    MaeM,
    /// Root mean square distance, metres: `evo_ape`.
    RmseM,
    /// Median distance, metres.
    MedianM,
    /// 90 % quantile of the distance, metres.
    P90M,
    /// Largest distance, metres.
    MaxM,
    /// Distance at the end of the drive, metres.
    FinalM,
    /// Mean absolute error of the heading, radians.
    HeadingMaeRad,
    /// Mean distance of the pose at the newest sample, metres.
    LatestMaeM,
    /// Root mean square distance after the best rigid motion, metres: `evo_ape --align`.
    AlignedRmseM,
    /// Root mean square error of the way from one estimate to the next, metres: `evo_rpe`.
    RpeM,
    /// Share of the estimates that say they are sure.
    Sure,
    /// Share of the estimates that say they are sure and are off by more than 0.1 m.
    SureAndWrong,
    /// Squared error of the position over its covariance, by two degrees of freedom.
    Nees,
}

impl Measure {
    /// All measures in the order of the tables.
    pub const ALL: [Self; 13] = [
        Self::MaeM,
        Self::RmseM,
        Self::MedianM,
        Self::P90M,
        Self::MaxM,
        Self::FinalM,
        Self::HeadingMaeRad,
        Self::LatestMaeM,
        Self::AlignedRmseM,
        Self::RpeM,
        Self::Sure,
        Self::SureAndWrong,
        Self::Nees,
    ];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::MaeM => "mae_m",
            Self::RmseM => "rmse_m",
            Self::MedianM => "median_m",
            Self::P90M => "p90_m",
            Self::MaxM => "max_m",
            Self::FinalM => "final_m",
            Self::HeadingMaeRad => "heading_mae_rad",
            Self::LatestMaeM => "latest_mae_m",
            Self::AlignedRmseM => "aligned_rmse_m",
            Self::RpeM => "rpe_m",
            Self::Sure => "sure",
            Self::SureAndWrong => "sure_and_wrong",
            Self::Nees => "nees",
        }
    }

    /// Name on axes.
    pub fn title(self) -> &'static str {
        match self {
            Self::MaeM => "mean position error [m]",
            Self::RmseM => "RMS position error [m]",
            Self::MedianM => "median position error [m]",
            Self::P90M => "90 % of position errors below [m]",
            Self::MaxM => "largest position error [m]",
            Self::FinalM => "position error at the end [m]",
            Self::HeadingMaeRad => "mean heading error [rad]",
            Self::LatestMaeM => "mean error of the newest position [m]",
            Self::AlignedRmseM => "RMS position error, aligned [m]",
            Self::RpeM => "RMS error from pose to pose [m]",
            Self::Sure => "share of sure estimates",
            Self::SureAndWrong => "share of sure estimates off by > 0.1 m",
            Self::Nees => "squared error over covariance",
        }
    }

    /// Unit behind a number, with a blank before it.
    pub fn unit(self) -> &'static str {
        match self {
            Self::HeadingMaeRad => " rad",
            Self::Sure | Self::SureAndWrong | Self::Nees => "",
            _ => " m",
        }
    }

    /// The measure of a trial; `None` where its method has none.
    fn of(self, result: &TrialResult) -> Option<f64> {
        let errors = &result.error_m;
        let value = match self {
            Self::MaeM => result.mae_m(),
            Self::RmseM => {
                let squares: Vec<f64> = errors.iter().map(|error| error * error).collect();
                mean(&squares).sqrt()
            }
            Self::MedianM => quantile(errors, 0.5),
            Self::P90M => quantile(errors, 0.9),
            Self::MaxM => quantile(errors, 1.0),
            Self::FinalM => *errors.last()?,
            Self::HeadingMaeRad => {
                let turns: Vec<f64> = result.heading_error_rad.iter().map(|e| e.abs()).collect();
                mean(&turns)
            }
            Self::LatestMaeM => result.latest_mae_m?,
            Self::AlignedRmseM => result.aligned_rmse_m,
            Self::RpeM => result.rpe_m,
            Self::Sure => result.sure?,
            Self::SureAndWrong => result.sure_and_wrong?,
            Self::Nees => result.nees?,
        };
        value.is_finite().then_some(value)
    }
}

/// One trial with its scores.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Number of the cell.
    pub cell: usize,
    /// Number of the method among the study's.
    pub method: usize,
    /// What was drawn.
    pub draw: Draw,
    /// Measures in the order of [`Measure::ALL`].
    pub values: [Option<f64>; Measure::ALL.len()],
    /// The reason why the method gave no poses.
    pub failure: Option<String>,
}

impl Row {
    /// The scores of a trial.
    pub fn of(cell: usize, method: usize, draw: Draw, result: &TrialResult) -> Self {
        let failed = result.failure.is_some();
        Self {
            cell,
            method,
            draw,
            values: Measure::ALL.map(|measure| measure.of(result).filter(|_| !failed)),
            failure: result.failure.clone(),
        }
    }

    /// A measure; `None` where the method has none or failed.
    pub fn value(&self, measure: Measure) -> Option<f64> {
        self.values[Measure::ALL.iter().position(|known| *known == measure)?]
    }
}

/// Writes the table of all trials.
///
/// # Errors
/// When the file cannot be written.
pub fn write(path: &Path, rows: &[Row], cells: &[Cell], methods: &[MethodName]) -> Result<()> {
    let labels: Vec<&str> = cells
        .first()
        .map(|cell| cell.labels.iter().map(|(name, _)| name.as_str()).collect())
        .unwrap_or_default();
    let measures = Measure::ALL.map(Measure::name);
    let header = labels
        .iter()
        .copied()
        .chain(["method"])
        .chain(DRAWN)
        .chain(measures)
        .chain(["failure"]);
    let mut table = Table::new(header);
    for row in rows {
        let values = row
            .values
            .iter()
            .map(|value| value.map_or(String::new(), |value| format!("{}", rounded(value))));
        let labels = cells[row.cell]
            .labels
            .iter()
            .map(|(_, value)| value.clone());
        table.push(
            labels
                .chain([methods[row.method].name().to_string()])
                .chain(row.draw.iter().map(u64::to_string))
                .chain(values)
                .chain([row.failure.clone().unwrap_or_default()]),
        );
    }
    table.write(path)
}

/// The numbers of a measure in a table of trials; `None` for trials that have none.
///
/// # Errors
/// When the column is missing or a word is no number.
pub fn numbers(table: &Table, measure: Measure) -> Result<Vec<Option<f64>>> {
    table
        .words(measure.name())?
        .iter()
        .map(|word| match word.is_empty() {
            true => Ok(None),
            false => word
                .parse()
                .map(Some)
                .with_context(|| format!("trials.csv: {}: '{word}' is no number", measure.name())),
        })
        .collect()
}
