//! The command line of `echolot`, one file per command.

mod alignment;
mod arguments;
mod bench;
mod check;
mod compare;
mod estimates;
mod figures;
mod import;
mod landmarks;
mod list;
mod localize;
mod map;
mod output;
mod record;
mod reference;
mod report;
mod robustness;
mod run;
mod scene;
mod shown;
mod simulate;
mod slam;
mod start;
mod study;
mod study_files;
mod tasks;
mod track;
mod transmit;
mod validate;

use anyhow::Result;
use clap::{CommandFactory, Parser, Subcommand};

/// Simulate, map and localize with Doppler-resolved echoes, and reproduce the papers' studies.
///
/// Exit codes: 0 done, 1 a check failed, 2 bad input or a failure, 130 interrupted.
#[derive(Debug, Parser)]
#[command(
    name = "echolot",
    version,
    after_help = "Example:\n  echolot run studies/quick && echolot check studies/quick"
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
    /// Write the sound that the loudspeaker plays, and its description.
    Transmit(transmit::Arguments),
    /// Build a map from recordings with known poses.
    Map(map::Arguments),
    /// Make a recording of a ROS 2 bag.
    Import(import::Arguments),
    /// Look at a recording before it is trusted.
    Record(record::Arguments),
    /// Localize the robot of a recording in a map.
    Localize(localize::Arguments),
    /// Estimate a drive and the landmarks around it together, without map or truth.
    Slam(slam::Arguments),
    /// Follow the robot live: sound on standard input, odometry beside it, poses on standard output.
    Track(track::Arguments),
    /// Run study files, or the papers' studies.
    Run(run::Arguments),
    /// Check or draw a study file, or print the schema of study files.
    Study(study::Arguments),
    /// List the tasks of a study.
    Plan(tasks::PlanArguments),
    /// Do tasks of a study, beside other workers.
    Task(tasks::TaskArguments),
    /// Write the results of a study whose tasks are done.
    Gather(tasks::GatherArguments),
    /// Write the results of a study as one page.
    Report(report::Arguments),
    /// Compare two results of a study, trial by trial.
    Compare(compare::Arguments),
    /// Draw the figures from data files.
    Figures(figures::Arguments),
    /// Compare a summary with the baseline (quick) or the papers' claims (paper).
    Check(check::Arguments),
    /// Measure the speed of the field engines.
    Bench(bench::Arguments),
    /// Compare the field with laws of physics: table, data, figure.
    Validate(validate::Arguments),
    /// List the studies.
    List(list::Arguments),
    /// Write the table of what was tried against wrong inputs and faults as a page of the documents.
    Robustness(robustness::Arguments),
    /// Write the help of all commands as one page of the documents.
    Reference(reference::Arguments),
}

impl Cli {
    /// Runs the command.
    ///
    /// # Errors
    /// An error that names file, field and remedy; [`crate::check::CheckFailed`] and
    /// [`crate::run::interrupt::Interrupted`] have exit codes of their own.
    pub fn run(self) -> Result<()> {
        let json = self.json;
        match self.command {
            Command::Scene(arguments) => arguments.run(json),
            Command::Simulate(arguments) => arguments.run(json),
            Command::Transmit(arguments) => arguments.run(json),
            Command::Map(arguments) => arguments.run(json),
            Command::Import(arguments) => arguments.run(json),
            Command::Record(arguments) => arguments.run(json),
            Command::Localize(arguments) => arguments.run(json),
            Command::Slam(arguments) => arguments.run(json),
            Command::Track(arguments) => arguments.run(),
            Command::Run(arguments) => arguments.run(json),
            Command::Study(arguments) => arguments.run(json),
            Command::Plan(arguments) => arguments.run(json),
            Command::Task(arguments) => arguments.run(),
            Command::Gather(arguments) => arguments.run(json),
            Command::Report(arguments) => arguments.run(),
            Command::Compare(arguments) => arguments.run(json),
            Command::Figures(arguments) => arguments.run(json),
            Command::Check(arguments) => arguments.run(json),
            Command::Bench(arguments) => arguments.run(json),
            Command::Validate(arguments) => arguments.run(json),
            Command::List(arguments) => arguments.run(json),
            Command::Robustness(arguments) => arguments.run(json),
            Command::Reference(arguments) => arguments.run(&reference()),
        }
    }
}

/// The help of all commands as one Markdown page.
pub fn reference() -> String {
    reference::page(Cli::command())
}
