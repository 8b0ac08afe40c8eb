//! Files and folders that appear whole or not at all: written under a temporary name and renamed.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::{Context, Result};

/// A sibling of `path` that no other writer uses at the same time.
fn temporary_beside(path: &Path) -> PathBuf {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let name = path
        .file_name()
        .map_or_else(|| "output".into(), |name| name.to_string_lossy());
    let serial = COUNTER.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".tmp-{}-{serial}-{name}", std::process::id()))
}

/// Creates the folder of `path`.
fn make_parent(path: &Path) -> Result<()> {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => {
            std::fs::create_dir_all(parent).with_context(|| parent.display().to_string())
        }
        _ => Ok(()),
    }
}

/// Writes `bytes` to `path`; creates its folder.
///
/// # Errors
/// When the folder cannot be created or the file cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_with(path, |temporary| Ok(std::fs::write(temporary, bytes)?))
}

/// Lets `fill` write a file under a temporary name and renames it to `path`.
///
/// # Errors
/// Whatever `fill` returns (the temporary file is removed then), or a failed rename.
pub fn write_with(path: &Path, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    make_parent(path)?;
    let temporary = temporary_beside(path);
    fill(&temporary)
        .and_then(|()| Ok(std::fs::rename(&temporary, path)?))
        .inspect_err(|_| _ = std::fs::remove_file(&temporary))
        .with_context(|| path.display().to_string())
}

/// Lets `fill` write a folder under a temporary name and renames it to `path`, replacing a folder that is there.
///
/// # Errors
/// Whatever `fill` returns (the temporary folder is removed then), or a failed rename.
pub fn write_folder(path: &Path, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    make_parent(path)?;
    let temporary = temporary_beside(path);
    let replace = || -> Result<()> {
        if path.exists() {
            let old = temporary_beside(path);
            std::fs::rename(path, &old)?;
            std::fs::rename(&temporary, path)?;
            std::fs::remove_dir_all(&old)?;
        } else {
            std::fs::rename(&temporary, path)?;
        }
        Ok(())
    };
    std::fs::create_dir_all(&temporary)
        .map_err(anyhow::Error::from)
        .and_then(|()| fill(&temporary))
        .and_then(|()| replace())
        .inspect_err(|_| _ = std::fs::remove_dir_all(&temporary))
        .with_context(|| path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b.txt");
        assert!(
            write_with(&path, |temporary| {
                std::fs::write(temporary, "half")?;
                anyhow::bail!("full")
            })
            .is_err()
        );
        assert_eq!(
            std::fs::read_dir(path.parent().unwrap()).unwrap().count(),
            0
        );
        write(&path, b"whole").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
    }

    #[test]
    fn a_folder_is_replaced_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("recording");
        for text in ["one", "two"] {
            write_folder(&path, |at| Ok(std::fs::write(at.join(text), text)?)).unwrap();
            assert_eq!(std::fs::read_dir(&path).unwrap().count(), 1);
            assert!(path.join(text).exists());
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
