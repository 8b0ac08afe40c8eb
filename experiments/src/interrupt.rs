//! Interruption by the user: the first Ctrl-C (or SIGTERM) asks for a clean stop, the second ends the program at once.

use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of an interrupted command.
pub const EXIT_CODE: u8 = 130;

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// What an interrupted command returns as its error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interrupted;

impl std::fmt::Display for Interrupted {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("interrupted; what was done so far is kept")
    }
}

impl std::error::Error for Interrupted {}

/// Watches for Ctrl-C and SIGTERM from now on.
///
/// # Errors
/// When the system refuses the handler.
pub fn watch() -> anyhow::Result<()> {
    ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(EXIT_CODE));
        }
    })?;
    Ok(())
}

/// Whether a stop was asked for.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}

/// Returns with [`Interrupted`] when a stop was asked for.
///
/// # Errors
/// [`Interrupted`].
pub fn check() -> Result<(), Interrupted> {
    if requested() {
        Err(Interrupted)
    } else {
        Ok(())
    }
}
