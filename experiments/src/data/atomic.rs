//! Files and folders that appear whole or not at all: written under a temporary name and renamed.

use std::path::Path;

use anyhow::{Context, Result};
use localizer::io::temporary;

/// Creates the folder of `path`.
///
/// # Errors
/// When that fails.
pub fn make_parent(path: &Path) -> Result<()> {
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
/// When the folder cannot be created, the file cannot be written, or `path` is no regular file.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_with(path, |temporary| Ok(std::fs::write(temporary, bytes)?))
}

/// Lets `fill` write a file under a temporary name and renames it to `path`.
///
/// # Errors
/// Whatever `fill` returns (the temporary file is removed then), a failed rename, or a `path` that is no regular file.
pub fn write_with(path: &Path, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    make_parent(path)?;
    temporary::check_file(path).with_context(|| path.display().to_string())?;
    let temporary = temporary::name_beside(path);
    fill(&temporary)
        .and_then(|()| Ok(temporary::put_file(&temporary, path)?))
        .inspect_err(|_| _ = std::fs::remove_file(&temporary))
        .with_context(|| path.display().to_string())
}

/// Lets `fill` write a folder under a temporary name and renames it to `path`, replacing a folder that is there.
///
/// # Errors
/// Whatever `fill` returns (the temporary folder is removed then), a failed rename, or a `path` that is no folder.
pub fn write_folder(path: &Path, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    make_parent(path)?;
    let temporary = temporary::name_beside(path);
    std::fs::create_dir_all(&temporary)
        .map_err(anyhow::Error::from)
        .and_then(|()| fill(&temporary))
        .and_then(|()| Ok(temporary::put_folder(&temporary, path)?))
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

    #[test]
    fn writers_at_once_leave_one_whole_folder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("entry");
        std::thread::scope(|scope| {
            for writer in 0..4 {
                let path = &path;
                scope.spawn(move || {
                    for _ in 0..50 {
                        write_folder(path, |at| {
                            for name in ["a", "b"] {
                                std::fs::write(at.join(name), format!("{writer}"))?;
                            }
                            Ok(())
                        })
                        .unwrap();
                    }
                });
            }
        });
        let text = |name: &str| std::fs::read_to_string(path.join(name)).unwrap();
        assert_eq!(text("a"), text("b"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
