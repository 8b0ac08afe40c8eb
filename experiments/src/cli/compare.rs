//! `echolot compare`.

use std::path::PathBuf;

use anyhow::Result;

use super::arguments::{ForceArgument, named};
use super::output::{print, print_json};
use crate::data::place::Place;
use crate::figures;
use crate::figures::drawing::png;
use crate::study::compare::{differences, table};
use crate::study::scores::Measure;

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot run my_study.json --results before\n  \
    echolot run my_study.json --results after\n  \
    echolot compare before/my_study after/my_study --figure difference.png\n\n\
    Trials are paired by cell, method and seeds; intervals are by nested bootstrap over all that was drawn."
)]
pub(crate) struct Arguments {
    /// Results of a study.
    a: PathBuf,
    /// Other results of it.
    b: PathBuf,
    /// What is compared, by its column in data/trials.csv.
    #[arg(long, value_name = "MEASURE", default_value = "mae_m", value_parser = named::<Measure>)]
    measure: Measure,
    /// Picture of the differences (PNG).
    #[arg(long, value_name = "FILE.png")]
    figure: Option<PathBuf>,
    #[command(flatten)]
    force: ForceArgument,
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        if let Some(picture) = &self.figure {
            Place::of(picture, self.force.force).file(png::is_ours)?;
        }
        let found = differences(&self.a, &self.b, self.measure)?;
        if let Some(picture) = &self.figure {
            figures::study::draw_differences(&found, self.measure, picture)?;
        }
        match json {
            true => print_json(&found),
            false => print(&table(&found, self.measure)),
        }
    }
}
