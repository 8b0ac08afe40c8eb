//! Long computations: on a thread of their own, without the interpreter's lock, with progress and Ctrl-C.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use anyhow::Result;
use experiments::run::interrupt::Interrupted;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Pause between two looks at signals and progress.
const LOOK: Duration = Duration::from_millis(50);

/// What a computation tells and is told.
#[derive(Debug, Default)]
pub(crate) struct Control {
    stop: AtomicBool,
    done: AtomicU64,
    all: AtomicU64,
}

impl Control {
    /// Tells how far it is.
    pub(crate) fn set(&self, done: u64, all: u64) {
        self.done.store(done, Ordering::Relaxed);
        self.all.store(all, Ordering::Relaxed);
    }

    /// Whether it is to stop.
    pub(crate) fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// An error when it is to stop.
    pub(crate) fn check(&self) -> Result<(), Interrupted> {
        match self.stopped() {
            true => Err(Interrupted),
            false => Ok(()),
        }
    }
}

/// Runs `work` to its end and returns what it gives. `progress(done, all)` is called now and then. After Ctrl-C the
/// call ends at once; the work stops at its next look at its control, with nobody waiting for it.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> Result<T> + Send + 'static,
) -> PyResult<T> {
    let control = Arc::new(Control::default());
    let (send, mut receive) = channel();
    let own = Arc::clone(&control);
    let body = move || {
        // The receiver is gone after Ctrl-C.
        let _ = send.send(catch_unwind(AssertUnwindSafe(|| work(&own))));
    };
    std::thread::Builder::new()
        .name("echolot".into())
        .spawn(body)
        .map_err(PyErr::from)?;
    let tell = || -> PyResult<()> {
        let all = control.all.load(Ordering::Relaxed);
        if let Some(progress) = progress.filter(|_| all > 0) {
            progress.call1((control.done.load(Ordering::Relaxed), all))?;
        }
        Ok(())
    };
    loop {
        let came = py.detach(move || {
            let came = receive.recv_timeout(LOOK);
            (receive, came)
        });
        receive = came.0;
        match came.1 {
            Ok(Ok(result)) => {
                tell()?;
                return result.map_err(crate::error::raised);
            }
            Err(RecvTimeoutError::Timeout) => {
                if let Err(error) = py.check_signals().and_then(|()| tell()) {
                    control.stop.store(true, Ordering::Relaxed);
                    return Err(error);
                }
            }
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err(
                    "echolot failed in a way it should not; please report it with the message above",
                ));
            }
        }
    }
}
