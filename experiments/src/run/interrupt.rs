//! Interruption by the user: the first Ctrl-C (or SIGTERM) requests a clean stop, the second ends the program at once.
//! The first ends it where nothing has to be cleaned up.

use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of an interrupted command.
pub const EXIT_CODE: u8 = 130;

static REQUESTED: AtomicBool = AtomicBool::new(false);
static AT_ONCE: AtomicBool = AtomicBool::new(false);

/// Error of an interrupted command.
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
        let again = REQUESTED.swap(true, Ordering::SeqCst);
        let at_once = AT_ONCE.load(Ordering::SeqCst);
        if at_once && !again {
            eprintln!("error: interrupted");
        }
        if at_once || again {
            std::process::exit(i32::from(EXIT_CODE));
        }
    })?;
    Ok(())
}

/// While this value lives, the first Ctrl-C ends the program at once: for work of which only the present computation is
/// lost.
#[must_use = "holds only until it is dropped"]
pub struct AtOnce(());

/// See [`AtOnce`].
pub fn at_once() -> AtOnce {
    AT_ONCE.store(true, Ordering::SeqCst);
    AtOnce(())
}

impl Drop for AtOnce {
    fn drop(&mut self) {
        AT_ONCE.store(false, Ordering::SeqCst);
    }
}

/// Requests a clean stop, as the first Ctrl-C does: for programs that have a handler of their own.
pub fn request() {
    REQUESTED.store(true, Ordering::SeqCst);
}

/// Takes a request back, once what it stopped has ended.
pub fn clear() {
    REQUESTED.store(false, Ordering::SeqCst);
}

/// Whether a stop was requested.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}

/// Returns with [`Interrupted`] when a stop was requested.
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
