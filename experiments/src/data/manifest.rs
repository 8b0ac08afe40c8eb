//! The manifest of a folder: which files this program wrote there, and what was in them. By it a folder is known as
//! this program's own before it is replaced, and a damaged entry of the cache is found.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::atomic;

/// Name of the file.
pub const NAME: &str = "manifest.json";

/// Files of a folder by name, each with the digests of what this program wrote.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The program and its version.
    program: String,
    /// Digests by file name: one, or two while a file is replaced.
    files: BTreeMap<String, Vec<String>>,
}

/// A digest of bytes: 16 hexadecimal digits of SHA-256.
pub fn digest(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest
        .iter()
        .take(8)
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

fn digest_of(file: &Path) -> Result<String> {
    let bytes = std::fs::read(file).with_context(|| file.display().to_string())?;
    Ok(digest(&bytes))
}

/// The regular names in a folder, but for the manifest's.
fn names(folder: &Path) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        names.push(entry?.file_name().to_string_lossy().into_owned());
    }
    names.retain(|name| name != NAME);
    names.sort();
    Ok(names)
}

impl Manifest {
    /// The manifest of everything that is in a folder.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn of(folder: &Path) -> Result<Self> {
        let mut manifest = Self {
            program: format!("echolot {}", env!("CARGO_PKG_VERSION")),
            ..Self::default()
        };
        for name in names(folder)? {
            let digest = digest_of(&folder.join(&name))?;
            manifest.files.insert(name, vec![digest]);
        }
        Ok(manifest)
    }

    /// Reads the manifest of a folder; `None` when there is none or it is damaged.
    pub fn read(folder: &Path) -> Option<Self> {
        localizer::io::json::parse(&std::fs::read_to_string(folder.join(NAME)).ok()?).ok()
    }

    /// Writes the manifest into its folder.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        atomic::write(&folder.join(NAME), text.as_bytes())
    }

    /// Whether a file of the folder is as this program wrote it.
    fn wrote(&self, folder: &Path, name: &str) -> bool {
        self.files.get(name).is_some_and(|known| {
            digest_of(&folder.join(name)).is_ok_and(|digest| known.contains(&digest))
        })
    }

    /// The files that are no longer as this program wrote them.
    pub fn changed(&self, folder: &Path) -> Vec<&str> {
        let names = self.files.keys().map(String::as_str);
        names.filter(|name| !self.wrote(folder, name)).collect()
    }

    /// Whether all files that the manifest lists are there, each as it was written.
    pub fn is_whole(&self, folder: &Path) -> bool {
        !self.files.is_empty() && self.files.keys().all(|name| self.wrote(folder, name))
    }
}

/// A file in a folder that this program did not write, among those with the given names, or among all; `None` when
/// there is none.
///
/// # Errors
/// When the folder cannot be read.
pub fn foreign(folder: &Path, among: Option<&[&str]>) -> Result<Option<String>> {
    let manifest = Manifest::read(folder).unwrap_or_default();
    let mine = |name: &String| manifest.wrote(folder, name);
    let asked = |name: &String| among.is_none_or(|among| among.contains(&name.as_str()));
    Ok(names(folder)?
        .into_iter()
        .filter(asked)
        .find(|name| !mine(name)))
}

/// Puts files into a folder, which is made, beside others that are there: `fill` writes them into an empty folder, and
/// each then takes its name. Killed in between, every file is the old one or the new one, and both are known as this
/// program's.
///
/// # Errors
/// Whatever `fill` returns, or when a file cannot be written.
pub fn put_into(folder: &Path, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let place = folder.join("new");
    let temporary = localizer::io::temporary::name_beside(&place);
    let put = || -> Result<()> {
        std::fs::create_dir(&temporary)?;
        fill(&temporary)?;
        let new = Manifest::of(&temporary)?;
        let mut both = Manifest::read(folder).unwrap_or_default();
        both.program.clone_from(&new.program);
        for (name, digests) in &new.files {
            both.files
                .entry(name.clone())
                .or_default()
                .extend(digests.iter().cloned());
        }
        both.write(folder)?;
        for name in new.files.keys() {
            localizer::io::temporary::put_file(&temporary.join(name), &folder.join(name))
                .with_context(|| folder.join(name).display().to_string())?;
        }
        both.files.extend(new.files);
        both.write(folder)?;
        Ok(std::fs::remove_dir(&temporary)?)
    };
    put()
        .inspect_err(|_| _ = std::fs::remove_dir_all(&temporary))
        .with_context(|| folder.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_program_wrote_is_known_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path().join("map");
        let write = |text: &'static str| {
            put_into(&at, |new| {
                std::fs::write(new.join("map.npy"), text)?;
                Ok(std::fs::write(new.join("map.json"), text)?)
            })
            .unwrap();
        };
        write("one");
        write("two");
        assert_eq!(std::fs::read(at.join("map.npy")).unwrap(), b"two");
        assert_eq!(foreign(&at, None).unwrap(), None);
        assert!(Manifest::read(&at).unwrap().is_whole(&at));
        std::fs::write(at.join("notes.txt"), "mine").unwrap();
        assert_eq!(foreign(&at, None).unwrap().as_deref(), Some("notes.txt"));
        assert_eq!(foreign(&at, Some(&["map.npy", "map.json"])).unwrap(), None);
        // Edited by hand, or a bit has flipped.
        std::fs::write(at.join("map.npy"), "twp").unwrap();
        let found = foreign(&at, Some(&["map.npy", "map.json"])).unwrap();
        assert_eq!(found.as_deref(), Some("map.npy"));
        assert!(!Manifest::read(&at).unwrap().is_whole(&at));
        std::fs::remove_file(at.join("map.npy")).unwrap();
        assert!(
            !Manifest::read(&at).unwrap().is_whole(&at),
            "a file is missing"
        );
    }

    #[test]
    fn a_file_half_way_between_old_and_new_is_still_ours() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        std::fs::write(at.join("map.npy"), "old").unwrap();
        let mut manifest = Manifest::of(at).unwrap();
        manifest
            .files
            .get_mut("map.npy")
            .unwrap()
            .push(digest(b"new"));
        manifest.write(at).unwrap();
        for text in ["old", "new"] {
            std::fs::write(at.join("map.npy"), text).unwrap();
            assert_eq!(foreign(at, None).unwrap(), None, "{text}");
        }
    }
}
