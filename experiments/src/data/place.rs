//! The place of an output, checked before anything is computed.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use localizer::io::temporary;

use super::{atomic, manifest};

/// Bytes that every output may take without being counted.
const SMALL: u64 = 64 << 10;

/// Where a command will write, and what it reads.
#[derive(Debug, Clone)]
pub struct Place {
    /// The file or folder.
    pub path: PathBuf,
    /// Files that the command reads: they are never replaced.
    pub inputs: Vec<PathBuf>,
    /// Whether what this program did not write may be replaced.
    pub force: bool,
    /// About how many bytes will be written.
    pub bytes: u64,
}

impl Place {
    /// A small output of a command that reads nothing.
    pub fn of(path: impl Into<PathBuf>, force: bool) -> Self {
        Self {
            path: path.into(),
            inputs: Vec::new(),
            force,
            bytes: 0,
        }
    }

    /// Checks the place of a file: `is_ours` says whether bytes are what this program writes there.
    ///
    /// # Errors
    /// When the place is an input, no regular file, holds what this program did not write (unless forced), or cannot be
    /// written.
    pub fn file(&self, is_ours: impl Fn(&[u8]) -> bool) -> Result<()> {
        let name = self.path.display();
        if self.path.file_name().is_none() {
            bail!("{name}: is no name of a file; give one");
        }
        if let Some(input) = self.inputs.iter().find(|input| is_same(&self.path, input)) {
            bail!(
                "{name}: is read by this command ({}); give another name",
                input.display()
            );
        }
        temporary::check_file(&self.path).with_context(|| name.to_string())?;
        if self.path.exists() && !self.force {
            let bytes = std::fs::read(&self.path).with_context(|| name.to_string())?;
            if !is_ours(&bytes) {
                bail!(
                    "{name}: exists, and this command did not write it; give another name, or --force to replace it"
                );
            }
        }
        self.writable()
    }

    /// Checks the place of a folder that will be replaced whole.
    ///
    /// # Errors
    /// As [`Place::file`], for any file in it.
    pub fn whole_folder(&self) -> Result<()> {
        self.folder(None)
    }

    /// Checks the place of a folder in which files of these names will be replaced.
    ///
    /// # Errors
    /// As [`Place::file`], for these files.
    pub fn files_in_folder(&self, names: &[&str]) -> Result<()> {
        for name in names {
            let path = self.path.join(name);
            if let Some(input) = self.inputs.iter().find(|input| is_same(&path, input)) {
                bail!(
                    "{}: is read by this command ({}); give another folder",
                    path.display(),
                    input.display()
                );
            }
            temporary::check_file(&path).with_context(|| path.display().to_string())?;
        }
        self.folder(Some(names))
    }

    fn folder(&self, names: Option<&[&str]>) -> Result<()> {
        let name = self.path.display();
        if self.path.file_name().is_none() && names.is_none() {
            bail!("{name}: is no name for a new folder; give one");
        }
        temporary::check_folder(&self.path).with_context(|| name.to_string())?;
        if names.is_none()
            && let Some(input) = self
                .inputs
                .iter()
                .find(|input| is_inside(&self.path, input))
        {
            bail!(
                "{name}: holds {}, which this command reads; give the name of a new folder",
                input.display()
            );
        }
        if self.path.exists()
            && !self.force
            && let Some(file) = manifest::foreign(&self.path, names)?
        {
            bail!(
                "{name}: holds {file}, which this program did not write or somebody changed; give the name of a new \
                folder, or --force to replace it"
            );
        }
        self.writable()
    }

    /// Makes the folder of the output, removes what a killed program left there, and tries to write.
    fn writable(&self) -> Result<()> {
        let name = self.path.display();
        let context = || format!("{name}: cannot be written");
        atomic::make_parent(&self.path).with_context(context)?;
        let folder = match self.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        temporary::sweep(folder);
        if self.path.is_dir() {
            temporary::sweep(&self.path);
        }
        let probe = temporary::name_beside(&self.path);
        let tried = std::fs::write(&probe, vec![0; SMALL as usize]);
        // Where nothing could be written there is nothing to remove.
        drop(std::fs::remove_file(&probe));
        tried.with_context(context)?;
        match free_bytes(folder) {
            Some(free) if free < self.bytes.saturating_add(SMALL) => bail!(
                "{name}: needs about {:.1} MB, {:.1} MB are free there; make room or write elsewhere",
                self.bytes as f64 * 1e-6,
                free as f64 * 1e-6
            ),
            _ => Ok(()),
        }
    }
}

/// A path whose folder is spelt without links and dots; a folder that does not exist stays as it is.
fn resolved(path: &Path) -> PathBuf {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let folder = folder
        .canonicalize()
        .unwrap_or_else(|_| folder.to_path_buf());
    folder.join(path.file_name().unwrap_or_default())
}

/// Whether two paths are the same file, or would be.
fn is_same(one: &Path, other: &Path) -> bool {
    let by_name = || {
        let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| resolved(path));
        resolved(one) == resolved(other) || real(one) == real(other)
    };
    by_name() || is_same_node(one, other)
}

/// Whether two names are links to one file.
#[cfg(unix)]
fn is_same_node(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let node = |path: &Path| std::fs::metadata(path).map(|data| (data.dev(), data.ino()));
    node(one).is_ok_and(|one| node(other).is_ok_and(|other| one == other))
}

#[cfg(not(unix))]
fn is_same_node(_: &Path, _: &Path) -> bool {
    false
}

/// Whether a file lies in a folder.
fn is_inside(folder: &Path, file: &Path) -> bool {
    let (Ok(folder), Ok(file)) = (folder.canonicalize(), file.canonicalize()) else {
        return false;
    };
    file.starts_with(folder)
}

/// Free bytes of the file system of a folder; `None` where that is not known.
#[cfg(unix)]
fn free_bytes(folder: &Path) -> Option<u64> {
    let system = rustix::fs::statvfs(folder).ok()?;
    (system.f_blocks > 0).then(|| system.f_bavail.saturating_mul(system.f_frsize))
}

#[cfg(not(unix))]
fn free_bytes(_: &Path) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(place: &Place, is_ours: bool) -> String {
        place
            .file(|_| is_ours)
            .map_or_else(|error| format!("{error:#}"), |()| "ok".into())
    }

    #[test]
    fn a_file_is_replaced_when_it_is_ours_and_no_input() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a.tum"), "x").unwrap();
        std::fs::hard_link(at("a.tum"), at("b.tum")).unwrap();
        let path = at("a.tum");
        let mut place = Place::of(&path, false);
        assert_eq!(message(&place, true), "ok");
        assert!(message(&place, false).contains("--force"));
        place.force = true;
        assert_eq!(message(&place, false), "ok");
        // Never an input, under any name, nor one that is not there yet.
        for input in [
            at("b.tum"),
            folder
                .path()
                .join("../")
                .join(folder.path().file_name().unwrap())
                .join("a.tum"),
        ] {
            place.inputs = vec![input];
            assert!(message(&place, true).contains("is read by this command"));
        }
        let new = at("truth.tum");
        let place = Place {
            inputs: vec![at("truth.tum")],
            ..Place::of(&new, true)
        };
        assert!(message(&place, true).contains("is read by this command"));
        let missing = at("not/there/yet.tum");
        assert_eq!(message(&Place::of(&missing, false), true), "ok");
        assert!(missing.parent().unwrap().is_dir());
        let below_a_file = at("a.tum/b.tum");
        assert!(message(&Place::of(&below_a_file, false), true).contains("a.tum"));
        let huge = Place {
            bytes: u64::MAX / 2,
            ..Place::of(&missing, false)
        };
        if cfg!(unix) {
            assert!(message(&huge, true).contains("are free there"));
        }
        assert_eq!(
            std::fs::read_dir(missing.parent().unwrap())
                .unwrap()
                .count(),
            0
        );
    }
}
