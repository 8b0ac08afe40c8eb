//! Size of a run: the paper's studies in the paper's size, or a small scene for every day.

use std::path::PathBuf;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// Size of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// The paper's studies in the paper's size.
    Paper,
    /// A small scene with the same physics, for the regression gate.
    Quick,
}

/// Cells of the studies of a preset.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Prefix of the names of its simulations; empty for the preset's own scene.
    pub prefix: &'static str,
    /// Scene file, relative to the folder of the project.
    pub scene: PathBuf,
    /// File of the robot whose instruments the recordings get, relative to the folder of the project; ideal but for the
    /// steady error of the paper's simulation when `None`.
    pub robot: Option<PathBuf>,
    /// Filter seeds of every cell.
    pub trials: usize,
    /// Half-width of the matched window where a study does not vary it, metres.
    pub half_width_m: f64,
    /// Periods M in a block where a study does not vary them.
    pub periods: usize,
    /// Half-widths of the window study, metres.
    pub half_widths_m: Vec<f64>,
    /// Numbers of periods of the periods study.
    pub period_counts: Vec<usize>,
    /// Signal-to-noise ratios, decibels.
    pub snr_db: Vec<f64>,
    /// Noise seeds at each ratio.
    pub noise_trials: usize,
    /// Blocks timed by the step time study.
    pub timed_blocks: usize,
}

impl Preset {
    /// Name on the command line and in paths.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Quick => "quick",
        }
    }

    /// Cells of its studies.
    pub fn plan(self) -> Plan {
        match self {
            Self::Paper => Plan {
                prefix: "",
                scene: PathBuf::from("scenes/four_walls.json"),
                robot: None,
                trials: 10,
                half_width_m: 4.0,
                periods: 6,
                half_widths_m: vec![1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0],
                period_counts: (1..=8).collect(),
                snr_db: vec![-15.0, -10.0, -5.0, 0.0, 3.0, 5.0, 10.0, 15.0, 20.0],
                noise_trials: 6,
                timed_blocks: 60,
            },
            Self::Quick => Plan {
                prefix: "",
                scene: PathBuf::from("scenes/quick.json"),
                robot: None,
                trials: 6,
                half_width_m: 2.0,
                periods: 6,
                half_widths_m: vec![1.0, 1.5, 2.0, 2.5, 3.0],
                period_counts: vec![2, 6],
                snr_db: vec![-15.0, 0.0, 20.0],
                noise_trials: 3,
                timed_blocks: 20,
            },
        }
    }

    /// Cells of the experimental site (2024 paper, section IV) beside the preset's own scene: the paper's cells on
    /// another scene and robot. Quick runs fewer seeds.
    pub fn site_plan(self) -> Plan {
        let own = self.plan();
        Plan {
            prefix: "site ",
            scene: PathBuf::from("scenes/site.json"),
            robot: Some(PathBuf::from("experiments/robots/site.json")),
            trials: own.trials,
            noise_trials: own.noise_trials,
            ..Self::Paper.plan()
        }
    }
}
