//! The command line tool `echolot`.

use std::process::ExitCode;

use clap::Parser;
use experiments::check::CheckFailed;
use experiments::cli::Cli;
use experiments::run::interrupt::{self, Interrupted};

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

/// The causes of an error in one line, without those that the cause before contains.
fn one_line(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain() {
        let cause = cause
            .to_string()
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        if text.is_empty() {
            text = cause;
        } else if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}
