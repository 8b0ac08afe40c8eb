//! The command line tool `echolot`.

use std::process::ExitCode;

use clap::Parser;
use experiments::check::CheckFailed;
use experiments::cli::Cli;
use experiments::run::interrupt::{self, Interrupted};
use experiments::run::one_line;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = interrupt::watch().and_then(|()| cli.run());
    let Err(error) = result else {
        return ExitCode::SUCCESS;
    };
    let code = if error.chain().any(|cause| cause.is::<Interrupted>()) {
        interrupt::EXIT_CODE
    } else if error.chain().any(|cause| cause.is::<CheckFailed>()) {
        1
    } else {
        2
    };
    eprintln!("error: {}", one_line(&error));
    ExitCode::from(code)
}
