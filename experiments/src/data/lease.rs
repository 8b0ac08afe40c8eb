//! Leases: a worker's word that it is at a task, so that no other one begins it too.
//!
//! A lease is a file beside the cache's entries. Its holder touches it while it works; one that has not been touched
//! for a while belonged to a worker that is dead, and may be taken. Ages are differences between times of the file
//! system itself, so that clocks of different machines need not agree. A lease only saves work: entries of the cache
//! appear whole or not at all, and two workers at one task give the same bytes.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context, Result};
use localizer::io::temporary;
use serde::{Deserialize, Serialize};

/// Pause between two touches.
const RENEWED: Duration = Duration::from_secs(5);
/// Age from which on a lease of another machine is that of a dead worker.
const DEAD: Duration = Duration::from_secs(60);

/// Who holds a lease.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Holder {
    /// Name of the machine.
    pub host: String,
    /// Number of the process.
    pub pid: u32,
}

impl Holder {
    /// This process.
    fn here() -> Self {
        Self {
            host: temporary::machine(),
            pid: std::process::id(),
        }
    }

    /// A worker of which nothing is known.
    fn unknown() -> Self {
        Self {
            host: "unknown".to_string(),
            pid: 0,
        }
    }

    /// Whether the process is known to have ended: one of this machine that is not there.
    fn is_gone(&self) -> bool {
        self.host == temporary::machine() && !temporary::is_alive(self.pid)
    }
}

impl std::fmt::Display for Holder {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}, process {}", self.host, self.pid)
    }
}

/// A lease that is held; dropping it gives it back.
#[derive(Debug)]
pub struct Lease {
    path: PathBuf,
    stop: Option<Sender<()>>,
    renewal: Option<JoinHandle<()>>,
}

/// Outcome of asking for a lease.
#[derive(Debug)]
pub enum Asked {
    /// It is ours.
    Held(Lease),
    /// Another worker has it.
    Busy(Holder),
}

impl Lease {
    /// Asks for the lease at `path`; a dead worker's is taken.
    ///
    /// # Errors
    /// When the folder cannot be written.
    pub fn ask(path: &Path) -> Result<Asked> {
        super::atomic::make_parent(path)?;
        let text = serde_json::to_string(&Holder::here())?;
        let context = || path.display().to_string();
        if create(path, &text).with_context(context)? {
            return Ok(Asked::Held(Self::renewed(path, text)));
        }
        let holder = dead_or_holder(path)?;
        let Err(holder) = holder else {
            // Of several who find it dead, one at a time looks again and takes it.
            let taking = path.with_extension("taking");
            if !create(&taking, &text).with_context(context)? {
                if is_old(&taking)? {
                    drop(std::fs::remove_file(&taking));
                }
                return Ok(Asked::Busy(Holder::unknown()));
            }
            let still_dead = dead_or_holder(path)?.is_ok();
            if still_dead {
                drop(std::fs::remove_file(path));
            }
            let held = still_dead && create(path, &text).with_context(context)?;
            drop(std::fs::remove_file(&taking));
            return Ok(match held {
                true => Asked::Held(Self::renewed(path, text)),
                false => Asked::Busy(Holder::unknown()),
            });
        };
        Ok(Asked::Busy(holder))
    }

    /// A lease that is written, touched from now on.
    fn renewed(path: &Path, text: String) -> Self {
        let (stop, stopped) = channel();
        let file = path.to_path_buf();
        let renewal = std::thread::Builder::new()
            .name("lease".to_string())
            .spawn(move || renew(&file, &text, &stopped));
        Self {
            path: path.to_path_buf(),
            stop: Some(stop),
            renewal: renewal.ok(),
        }
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(renewal) = self.renewal.take() {
            drop(renewal.join());
        }
        drop(std::fs::remove_file(&self.path));
    }
}

/// Creates a file; false where there is one already.
fn create(path: &Path, text: &str) -> std::io::Result<bool> {
    let file = std::fs::OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(path);
    match file {
        Ok(mut file) => file.write_all(text.as_bytes()).map(|()| true),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(false),
        Err(error) => Err(error),
    }
}

/// Nothing where a lease is a dead worker's or was given back, else its holder.
fn dead_or_holder(path: &Path) -> Result<Result<(), Holder>> {
    let holder = match std::fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Ok(())),
        bytes => bytes
            .ok()
            .and_then(|bytes| serde_json::from_slice::<Holder>(&bytes).ok()),
    };
    match holder.as_ref().is_some_and(Holder::is_gone) || is_old(path)? {
        true => Ok(Ok(())),
        false => Ok(Err(holder.unwrap_or_else(Holder::unknown))),
    }
}

/// Touches a lease until its holder lets go.
fn renew(path: &Path, text: &str, stopped: &Receiver<()>) {
    while let Err(RecvTimeoutError::Timeout) = stopped.recv_timeout(RENEWED) {
        // A lease that was taken from us, asleep for a minute, is left to the taker.
        if path.exists() {
            drop(std::fs::write(path, text));
        }
    }
}

/// Whether a file was last written long before one that is written now.
fn is_old(path: &Path) -> Result<bool> {
    let time = |path: &Path| std::fs::metadata(path).and_then(|data| data.modified());
    let Ok(written) = time(path) else {
        return Ok(false);
    };
    let now = temporary::name_beside(path);
    std::fs::write(&now, "").with_context(|| now.display().to_string())?;
    let age = time(&now).map(|now| now.duration_since(written).unwrap_or_default());
    drop(std::fs::remove_file(&now));
    Ok(age.is_ok_and(|age| age > DEAD))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(path: &Path) -> Option<Lease> {
        match Lease::ask(path).unwrap() {
            Asked::Held(lease) => Some(lease),
            Asked::Busy(_) => None,
        }
    }

    #[test]
    fn one_worker_holds_a_lease_until_it_lets_go() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("leases/task.json");
        let lease = held(&path).expect("free");
        let Asked::Busy(holder) = Lease::ask(&path).unwrap() else {
            panic!("held twice")
        };
        assert_eq!(holder, Holder::here());
        drop(lease);
        assert!(!path.exists());
        assert!(held(&path).is_some());
    }

    #[test]
    fn a_dead_workers_lease_is_taken_and_a_living_ones_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("task.json");
        let write = |host: &str, pid: u32, age: Duration| {
            let text = serde_json::to_string(&Holder {
                host: host.to_string(),
                pid,
            })
            .unwrap();
            std::fs::write(&path, text).unwrap();
            let file = std::fs::File::options().write(true).open(&path).unwrap();
            file.set_modified(std::time::SystemTime::now() - age)
                .unwrap();
        };
        write("elsewhere", 1, Duration::from_secs(30));
        assert!(held(&path).is_none(), "renewed half a minute ago");
        write("elsewhere", 1, DEAD + Duration::from_secs(5));
        assert!(held(&path).is_some(), "silent for more than a minute");
        if cfg!(unix) {
            // The largest number is no process.
            write(&temporary::machine(), i32::MAX as u32, Duration::ZERO);
            assert!(held(&path).is_some(), "its process has ended");
        }
        // A half-written lease counts by its age.
        std::fs::write(&path, "{").unwrap();
        assert!(held(&path).is_none());
    }

    #[test]
    fn of_many_who_ask_one_is_given_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("task.json");
        std::fs::write(&path, "{\"host\":\"elsewhere\",\"pid\":1}").unwrap();
        let file = std::fs::File::options().write(true).open(&path).unwrap();
        let long_ago = std::time::SystemTime::now() - 2 * DEAD;
        file.set_modified(long_ago).unwrap();
        let leases: Vec<Option<Lease>> = std::thread::scope(|scope| {
            let asked: Vec<_> = (0..16).map(|_| scope.spawn(|| held(&path))).collect();
            asked.into_iter().map(|one| one.join().unwrap()).collect()
        });
        assert_eq!(leases.iter().flatten().count(), 1);
    }
}
