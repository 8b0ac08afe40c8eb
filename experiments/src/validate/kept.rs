//! What an interrupted validation has measured, law by law, for the same command to go on from.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use oracles::laws::{Depth, Measurement};

use crate::atomic;
use crate::cache::Key;

/// A folder of measurements that belong to this very program and depth. It is removed when all is measured: a validation measures anew.
pub struct Kept {
    folder: PathBuf,
    key: String,
}

impl Kept {
    /// That of this program below a folder of results.
    ///
    /// # Errors
    /// When the program's own file cannot be read.
    pub fn below(results: &Path, depth: Depth) -> Result<Self> {
        let program = std::env::current_exe()?;
        let bytes = std::fs::read(&program).with_context(|| program.display().to_string())?;
        let mut key = Key::new("validation");
        key.bytes("program", &bytes);
        key.text("depth", &format!("{depth:?}"));
        Ok(Self {
            folder: results.join("cache").join("validation"),
            key: key.finish(),
        })
    }

    /// File of a law, named by the letters of its name.
    fn file(&self, law: &str) -> PathBuf {
        let words = law.split(|letter: char| !letter.is_ascii_alphanumeric());
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        (self.folder.join(&self.key)).join(format!("{}.json", words.join("-").to_lowercase()))
    }

    /// What was measured of a law; none when it was not, or the file is damaged.
    pub fn read(&self, law: &str) -> Option<Vec<Measurement>> {
        serde_json::from_slice(&std::fs::read(self.file(law)).ok()?).ok()
    }

    /// Keeps what was measured of a law.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, law: &str, measurements: &[Measurement]) -> Result<()> {
        atomic::write(&self.file(law), &serde_json::to_vec(measurements)?)
    }

    /// Removes all that is kept, of other programs too.
    ///
    /// # Errors
    /// When the folder cannot be removed.
    pub fn clear(&self) -> Result<()> {
        match std::fs::remove_dir_all(&self.folder) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(error).with_context(|| self.folder.display().to_string())
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_comes_back_to_the_last_bit_until_it_is_cleared() {
        let results = tempfile::tempdir().unwrap();
        let kept = Kept::below(results.path(), Depth::Quick).unwrap();
        let law = "R-L-C, 1:3";
        assert!(kept.read(law).is_none());
        kept.clear().unwrap();
        let numbers = [0.1 + 0.2, -1.0 / 3.0, 5e-324, 1.797e308, 0.0];
        let measurements: Vec<Measurement> = (numbers.iter())
            .map(|&x| Measurement::within(format!("case {x}"), "level, dB", x, 1.0))
            .collect();
        kept.write(law, &measurements).unwrap();
        assert_eq!(kept.read(law), Some(measurements));
        assert!(kept.read("R-L-C").is_none(), "another law");
        let full = Kept::below(results.path(), Depth::Full).unwrap();
        assert!(full.read(law).is_none(), "another depth");
        kept.clear().unwrap();
        assert!(kept.read(law).is_none());
    }
}
