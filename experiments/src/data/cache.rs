//! The cache: recordings and trials by a hash of all that determines them.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use super::atomic;

/// Version of the files in the cache.
const FORMAT: u32 = 1;

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
    /// The cache in `folder`, which is created with its first entry.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
        }
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

    fn entry(&self, kind: &str, key: &str) -> PathBuf {
        self.folder.join(kind).join(format!("{key}.json"))
    }

    /// A cached value; `None` when it is missing or damaged.
    pub fn get<T: DeserializeOwned>(&self, kind: &str, key: &str) -> Option<T> {
        let text = std::fs::read_to_string(self.entry(kind, key)).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Puts a value into the cache.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn put(&self, kind: &str, key: &str, value: &impl Serialize) -> Result<()> {
        let path: &Path = &self.entry(kind, key);
        let text = serde_json::to_string(value).with_context(|| path.display().to_string())?;
        atomic::write(path, text.as_bytes())
    }
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
        std::fs::write(folder.path().join("trials/k.json"), "[1.0,").unwrap();
        assert_eq!(cache.get::<Vec<f64>>("trials", "k"), None);
    }
}
