//! The cache: recordings and trials by a hash of all that determines them.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use super::lease::{Asked, Lease};
use super::{atomic, manifest};
use localizer::io::temporary;

/// Version of the files in the cache.
const FORMAT: u32 = 2;
/// How an entry begins; its digest follows, then its value.
const BEGIN: &str = "{\"digest\":\"";
/// Between digest and value.
const MIDDLE: &str = "\",\"value\":";

/// A key that is built up from named values.
pub struct Key {
    hash: Sha256,
}

impl Key {
    /// A key for entries of this kind.
    pub fn new(kind: &str) -> Self {
        let mut key = Self {
            hash: Sha256::new(),
        };
        key.text("kind", kind);
        key.numbers("format", &[f64::from(FORMAT)]);
        key
    }

    /// Adds a text.
    pub fn text(&mut self, name: &str, value: &str) {
        self.bytes(name, value.as_bytes());
    }

    /// Adds bytes.
    pub fn bytes(&mut self, name: &str, value: &[u8]) {
        for part in [name.as_bytes(), value] {
            self.hash.update((part.len() as u64).to_le_bytes());
            self.hash.update(part);
        }
    }

    /// Adds numbers, bit for bit.
    pub fn numbers(&mut self, name: &str, values: &[f64]) {
        self.text("numbers", name);
        self.hash.update((values.len() as u64).to_le_bytes());
        for value in values {
            self.hash.update(value.to_bits().to_le_bytes());
        }
    }

    /// Adds a value as JSON.
    ///
    /// # Errors
    /// When the value does not serialize.
    pub fn value(&mut self, name: &str, value: &impl Serialize) -> Result<()> {
        self.text(name, &serde_json::to_string(value)?);
        Ok(())
    }

    /// The key as 20 hexadecimal digits.
    pub fn finish(self) -> String {
        let digest = self.hash.finalize();
        digest
            .iter()
            .take(10)
            .map(|byte| format!("{byte:02x}"))
            .collect()
    }
}

/// A hash of a signal's exact samples.
pub fn hash_of_samples(samples: &[f32]) -> String {
    let mut key = Key::new("samples");
    let numbers: Vec<f64> = samples.iter().map(|sample| f64::from(*sample)).collect();
    key.numbers("samples", &numbers);
    key.finish()
}

/// A folder of cached recordings and values.
#[derive(Debug, Clone)]
pub struct Cache {
    folder: PathBuf,
}

impl Cache {
    /// The cache in `folder`, which is created with its first entry. What killed programs have left there is removed.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        let folder = folder.into();
        for below in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            temporary::sweep(&below.path());
        }
        Self { folder }
    }

    /// Whether the recording with this key is there as it was written. A damaged one is told of on standard error.
    pub fn has_recording(&self, key: &str) -> bool {
        let folder = self.recording(key);
        if !folder.is_dir() {
            return false;
        }
        let is_whole = self.is_whole(key);
        if !is_whole {
            eprintln!("{}: is damaged and made anew", folder.display());
        }
        is_whole
    }

    /// As [`Cache::has_recording`], without a word on a damaged one.
    pub fn is_whole(&self, key: &str) -> bool {
        let folder = self.recording(key);
        manifest::Manifest::read(&folder).is_some_and(|known| known.is_whole(&folder))
    }

    /// Folder of the recording with this key.
    pub fn recording(&self, key: &str) -> PathBuf {
        self.folder.join("recordings").join(key)
    }

    /// Checkpoint of the recording with this key while it is simulated.
    pub fn checkpoint(&self, key: &str) -> PathBuf {
        self.folder
            .join("checkpoints")
            .join(format!("{key}.checkpoint"))
    }

    /// Asks for the lease of the task that makes an entry.
    ///
    /// # Errors
    /// When the cache cannot be written.
    pub fn lease(&self, key: &str) -> Result<Asked> {
        Lease::ask(&self.folder.join("leases").join(format!("{key}.json")))
    }

    fn entry(&self, kind: &str, key: &str) -> PathBuf {
        self.folder.join(kind).join(format!("{key}.json"))
    }

    /// Whether there is a value with this key, whole or damaged.
    pub fn has(&self, kind: &str, key: &str) -> bool {
        self.entry(kind, key).exists()
    }

    /// A cached value; `None` when it is missing or damaged. A damaged one is told of on standard error.
    pub fn get<T: DeserializeOwned>(&self, kind: &str, key: &str) -> Option<T> {
        let path = self.entry(kind, key);
        let value = match std::fs::read(&path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return None,
            Err(_) => None,
            Ok(bytes) => unsealed(&bytes),
        };
        if value.is_none() {
            eprintln!("{}: is damaged and made anew", path.display());
        }
        value
    }

    /// Puts a value into the cache.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn put(&self, kind: &str, key: &str, value: &impl Serialize) -> Result<()> {
        let path: &Path = &self.entry(kind, key);
        let text = sealed(value).with_context(|| path.display().to_string())?;
        atomic::write(path, text.as_bytes())
    }
}

/// A value as JSON with the digest of its text, by which [`unsealed`] finds every damage.
///
/// # Errors
/// When the value does not serialize.
pub fn sealed(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string(value)?;
    let digest = manifest::digest(text.as_bytes());
    Ok(format!("{BEGIN}{digest}{MIDDLE}{text}}}"))
}

/// The value in a text of [`sealed`]; `None` when a byte of it is another.
pub fn unsealed<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let text = std::str::from_utf8(bytes).ok()?;
    let (digest, rest) = text.strip_prefix(BEGIN)?.split_once(MIDDLE)?;
    let value = rest.strip_suffix('}')?;
    let is_whole = manifest::digest(value.as_bytes()) == digest;
    is_whole.then(|| serde_json::from_str(value).ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_stable_and_separate_names_from_values() {
        let build = |parts: &[(&str, &str)]| {
            let mut key = Key::new("test");
            for (name, value) in parts {
                key.text(name, value);
            }
            key.finish()
        };
        assert_eq!(build(&[("a", "b")]), build(&[("a", "b")]));
        assert_ne!(build(&[("a", "b")]), build(&[("ab", "")]));
        assert_ne!(
            build(&[("a", "b"), ("c", "d")]),
            build(&[("c", "d"), ("a", "b")])
        );
        // Another length or hash would invalidate every cache.
        assert_eq!(build(&[("a", "b")]).len(), 20);
    }

    #[test]
    fn the_cache_returns_values_and_ignores_damaged_entries() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path());
        assert_eq!(cache.get::<Vec<f64>>("trials", "k"), None);
        cache.put("trials", "k", &[1.0, 2.5]).unwrap();
        assert_eq!(cache.get::<Vec<f64>>("trials", "k"), Some(vec![1.0, 2.5]));
        let file = folder.path().join("trials/k.json");
        let whole = std::fs::read(&file).unwrap();
        // Every bit counts, and so does every byte that is missing.
        for bit in 0..8 * whole.len() {
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            std::fs::write(&file, &flipped).unwrap();
            assert_eq!(cache.get::<Vec<f64>>("trials", "k"), None, "bit {bit}");
        }
        for length in 0..whole.len() {
            std::fs::write(&file, &whole[..length]).unwrap();
            assert_eq!(cache.get::<Vec<f64>>("trials", "k"), None, "{length} bytes");
        }
    }
}
