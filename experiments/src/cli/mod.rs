//! The command line of `echolot`, one file per command.

mod bench;
mod check;
mod figures;
mod list;
mod localize;
mod map;
mod output;
mod reference;
mod run;
mod scene;
mod simulate;
mod validate;

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use clap::{Parser, Subcommand};
use localizer::Parameters;

pub use reference::page as reference;

use crate::simulate::{Engine, IMAGE_ORDER};

/// Simulate, map and localize with Doppler-resolved echoes, and reproduce the papers' studies.
///
/// Exit codes: 0 done, 1 a check failed, 2 bad input or a failure, 130 interrupted.
#[derive(Debug, Parser)]
#[command(
    name = "echolot",
    version,
    after_help = "Example:\n  echolot run --preset quick && echolot check --preset quick"
)]
pub struct Cli {
    /// Print results as JSON on standard output.
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Check or draw a scene file, or print the schema of scene files.
    Scene(scene::Arguments),
    /// Simulate a drive in a scene and write the recording.
    Simulate(simulate::Arguments),
    /// Build a map from recordings with known poses.
    Map(map::Arguments),
    /// Localize the robot of a recording in a map.
    Localize(localize::Arguments),
    /// Run the papers' studies.
    Run(run::Arguments),
    /// Draw the figures from data files.
    Figures(figures::Arguments),
    /// Hold a summary against the baseline (quick) or the papers' claims (paper).
    Check(check::Arguments),
    /// Measure the speed of the field engines.
    Bench(bench::Arguments),
    /// Hold the field against laws of physics: table, data, figure.
    Validate(validate::Arguments),
    /// List the studies.
    List(list::Arguments),
    /// Write the help of all commands as one page of the documents.
    Reference(reference::Arguments),
}

impl Cli {
    /// Does what was asked for.
    ///
    /// # Errors
    /// One error that says what was wrong with which file; [`crate::check::CheckFailed`] and
    /// [`crate::interrupt::Interrupted`] have exit codes of their own.
    pub fn run(self) -> Result<()> {
        let json = self.json;
        match self.command {
            Command::Scene(arguments) => arguments.run(json),
            Command::Simulate(arguments) => arguments.run(json),
            Command::Map(arguments) => arguments.run(json),
            Command::Localize(arguments) => arguments.run(json),
            Command::Run(arguments) => arguments.run(json),
            Command::Figures(arguments) => arguments.run(json),
            Command::Check(arguments) => arguments.run(json),
            Command::Bench(arguments) => arguments.run(json),
            Command::Validate(arguments) => arguments.run(json),
            Command::List(arguments) => arguments.run(json),
            Command::Reference(arguments) => arguments.run(),
        }
    }
}

/// What computes the sound.
#[derive(Debug, Clone, Copy, clap::Args)]
struct EngineArguments {
    /// What computes the sound: the field, or image sources (approximate, seconds).
    #[arg(long, value_enum, default_value_t = Engine::Fdtd)]
    engine: Engine,
    /// Most reflections of an echo by image sources [default: 2].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=6))]
    image_order: Option<u8>,
}

impl EngineArguments {
    /// Most reflections of an image source's echo.
    fn image_order(&self) -> Result<usize> {
        if let (Engine::Fdtd, Some(order)) = (self.engine, self.image_order) {
            bail!(
                "--image-order {order}: is for image sources, the field has all reflections; add --engine image-source or leave it out"
            );
        }
        Ok(usize::from(self.image_order.unwrap_or(IMAGE_ORDER)))
    }
}

/// Where the parameters of the localizer come from.
#[derive(Debug, Clone, clap::Args)]
struct ParameterArguments {
    /// JSON file with parameters of the localizer; those it leaves out keep the paper's values.
    #[arg(long, value_name = "FILE")]
    parameters: Option<PathBuf>,
}

impl ParameterArguments {
    /// Reads the file, if one was given.
    fn read(&self) -> Result<Parameters> {
        let Some(path) = &self.parameters else {
            return Ok(Parameters::default());
        };
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        serde_json::from_str(&text).with_context(|| path.display().to_string())
    }
}

/// A spelling in files (`slf`, `kaiser8`) as an argument.
fn named<T: serde::de::DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_value(serde_json::Value::String(text.to_string()))
        .map_err(|error| error.to_string())
}
