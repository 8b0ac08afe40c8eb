//! Temporary names beside a file or folder: what is written under one takes its place whole, and what a killed program
//! left behind is swept away by the next one.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime};

/// First letters of every temporary name.
const PREFIX: &str = ".tmp-";
/// Age after which a temporary name of another machine is left over for certain.
const LEFT_OVER: Duration = Duration::from_secs(24 * 3600);

/// Machine, process and start of this program, as they stand in its temporary names.
static OWNER: LazyLock<Owner> = LazyLock::new(|| {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    Owner {
        machine: machine(),
        process: std::process::id(),
        start: since.map_or(0, |since| since.as_nanos()),
    }
});

/// Who writes under a temporary name.
#[derive(Debug, PartialEq, Eq)]
struct Owner {
    machine: String,
    process: u32,
    start: u128,
}

/// A name in the folder of `path` that no other writer uses at the same time, here or on a machine that shares the
/// folder.
pub fn name_beside(path: &Path) -> PathBuf {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let Owner {
        machine,
        process,
        start,
    } = &*OWNER;
    let serial = COUNTER.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!("{PREFIX}{machine}-{process}-{start}-{serial}"))
}

/// Refuses a place that holds anything but a regular file: a device, a pipe, a link, a folder.
///
/// # Errors
/// An error that says what is there, or that of the operating system.
pub fn check_file(path: &Path) -> io::Result<()> {
    refuse_other(path, fs::FileType::is_file, "regular file")
}

/// Refuses a place that holds anything but a folder, a link to one included.
///
/// # Errors
/// As [`check_file`].
pub fn check_folder(path: &Path) -> io::Result<()> {
    refuse_other(path, fs::FileType::is_dir, "folder")
}

fn refuse_other(path: &Path, wanted: impl Fn(&fs::FileType) -> bool, what: &str) -> io::Result<()> {
    let there = match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        there => there?.file_type(),
    };
    if wanted(&there) {
        return Ok(());
    }
    let is = match there {
        _ if there.is_symlink() => "a link",
        _ if there.is_dir() => "a folder",
        _ if there.is_file() => "a file",
        _ => "a device or a pipe",
    };
    Err(io::Error::new(
        io::ErrorKind::InvalidInput,
        format!("is {is} and stays as it is; give the name of a {what}, or a new one"),
    ))
}

/// Gives a file under a temporary name its own, replacing a regular file that has it.
///
/// # Errors
/// As [`check_file`], and when the file cannot be renamed.
pub fn put_file(temporary: &Path, path: &Path) -> io::Result<()> {
    check_file(path)?;
    fs::rename(temporary, path)
}

/// Gives a folder under a temporary name its own, replacing a folder that has it: readers see the old one or the new
/// one, and so does whoever looks after a kill.
///
/// # Errors
/// As [`check_folder`], and when the folder cannot be renamed.
pub fn put_folder(temporary: &Path, path: &Path) -> io::Result<()> {
    // Another process may put its own there, or take it away, at the same time.
    let mut failed = io::Error::from(io::ErrorKind::AlreadyExists);
    for _ in 0..16 {
        check_folder(path)?;
        match fs::rename(temporary, path) {
            Ok(()) => return Ok(()),
            Err(error) if !path.is_dir() => failed = error,
            Err(_) => match exchange(temporary, path) {
                // The temporary name has the old folder now.
                Ok(()) => return fs::remove_dir_all(temporary),
                Err(error) => failed = error,
            },
        }
    }
    Err(failed)
}

/// Exchanges two folders at once.
#[cfg(target_os = "linux")]
fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    use rustix::io::Errno;
    match renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE) {
        // Some file systems cannot.
        Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP) => by_turns(one, other),
        done => Ok(done?),
    }
}

#[cfg(not(target_os = "linux"))]
fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    by_turns(one, other)
}

/// Exchanges two folders by a third name.
fn by_turns(one: &Path, other: &Path) -> io::Result<()> {
    let third = name_beside(other);
    fs::rename(other, &third)?;
    fs::rename(one, other)?;
    fs::rename(&third, one)
}

/// Removes what killed programs have left in `folder` under temporary names. What a living one writes stays. A folder
/// that cannot be read or changed is left as it is: whoever writes there will hear of it.
pub fn sweep(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(owner) = name.to_str().and_then(owner) else {
            continue;
        };
        let age = || {
            let changed = entry.metadata().and_then(|data| data.modified()).ok()?;
            SystemTime::now().duration_since(changed).ok()
        };
        let left_over = match owner.machine == OWNER.machine {
            true if owner.process == OWNER.process => owner.start != OWNER.start,
            true => !is_alive(owner.process),
            false => age().is_some_and(|age| age > LEFT_OVER),
        };
        if left_over {
            let path = entry.path();
            let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
            let removed = match is_folder {
                true => fs::remove_dir_all(&path),
                false => fs::remove_file(&path),
            };
            // Another sweeper may have been quicker.
            drop(removed);
        }
    }
}

/// The owner in a temporary name; `None` for any other name.
fn owner(name: &str) -> Option<Owner> {
    let mut parts = name.strip_prefix(PREFIX)?.split('-');
    let owner = Owner {
        machine: parts.next()?.to_string(),
        process: parts.next()?.parse().ok()?,
        start: parts.next()?.parse().ok()?,
    };
    parts.next()?.parse::<u64>().ok()?;
    parts.next().is_none().then_some(owner)
}

/// Name of this machine in letters and digits.
pub fn machine() -> String {
    #[cfg(unix)]
    let name = rustix::system::uname()
        .nodename()
        .to_string_lossy()
        .into_owned();
    #[cfg(not(unix))]
    let name = std::env::var("COMPUTERNAME").unwrap_or_default();
    let letters = name.chars().filter(char::is_ascii_alphanumeric);
    match letters.take(40).collect::<String>() {
        name if name.is_empty() => "machine".to_string(),
        name => name,
    }
}

/// Whether a process of this machine runs.
#[cfg(unix)]
pub fn is_alive(process: u32) -> bool {
    use rustix::process::{Pid, test_kill_process};
    i32::try_from(process)
        .ok()
        .and_then(Pid::from_raw)
        .is_some_and(|pid| test_kill_process(pid) != Err(rustix::io::Errno::SRCH))
}

/// Whether a process of this machine runs: not known here.
#[cfg(not(unix))]
pub fn is_alive(_: u32) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dead_are_swept_and_the_living_stay() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let machine = machine();
        // The first process of the machine always runs; the largest number is none.
        let dead = format!(".tmp-{machine}-{}-5-0", i32::MAX);
        let kept = [
            ".tmp-notes".to_string(),
            "drive.tum".to_string(),
            format!(".tmp-{machine}-1-5-0"),
            format!(".tmp-another{machine}-{}-5-0", i32::MAX),
            name_beside(&at("x"))
                .file_name()
                .unwrap()
                .to_string_lossy()
                .into_owned(),
        ];
        for name in &kept {
            fs::write(at(name), "x").unwrap();
        }
        fs::create_dir(at(&dead)).unwrap();
        fs::write(at(&dead).join("signal.wav"), "x").unwrap();
        // The same number as this process, but started at another time.
        let before = format!(".tmp-{machine}-{}-5-0", std::process::id());
        fs::write(at(&before), "x").unwrap();
        sweep(folder.path());
        assert!(!at(&dead).exists() && !at(&before).exists());
        assert!(kept.iter().all(|name| at(name).exists()));
        sweep(&at("nowhere"));
    }

    #[test]
    fn a_folder_takes_the_place_of_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("recording");
        for text in ["one", "two"] {
            let temporary = name_beside(&path);
            fs::create_dir(&temporary).unwrap();
            fs::write(temporary.join(text), text).unwrap();
            put_folder(&temporary, &path).unwrap();
            assert_eq!(fs::read_dir(&path).unwrap().count(), 1);
            assert!(path.join(text).exists());
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_regular_file_stays() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "x").unwrap();
        std::os::unix::fs::symlink(at("file"), at("link")).unwrap();
        std::os::unix::fs::symlink(folder.path(), at("way")).unwrap();
        fs::write(at("new"), "y").unwrap();
        for (path, word) in [
            (at("link"), "a link"),
            (folder.path().to_path_buf(), "a folder"),
            ("/dev/null".into(), "a device"),
        ] {
            let error = check_file(&path).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
        assert!(put_file(&at("new"), &at("link")).is_err());
        assert!(check_folder(&at("way")).is_err() && check_folder(&at("file")).is_err());
        put_file(&at("new"), &at("file")).unwrap();
        assert_eq!(fs::read(at("link")).unwrap(), b"y");
    }
}
