//! Measurements of an interrupted validation, law by law, from which the same command resumes.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use oracles::laws::{Depth, Measurement};

use crate::data::atomic;
use crate::data::cache::{Key, sealed, unsealed};

/// A folder of measurements of this program at one depth. It is removed when all laws are measured: the next validation
/// measures anew.
pub struct Resume {
    folder: PathBuf,
    key: String,
}

impl Resume {
    /// The folder of this program below a folder of results.
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

    /// Measurements of a law; `None` when there are none or the file is damaged.
    pub fn read(&self, law: &str) -> Option<Vec<Measurement>> {
        unsealed(&std::fs::read(self.file(law)).ok()?)
    }

    /// Writes the measurements of a law.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, law: &str, measurements: &[Measurement]) -> Result<()> {
        atomic::write(&self.file(law), sealed(&measurements)?.as_bytes())
    }

    /// Removes all measurements, of other programs too.
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
    fn measurements_come_back_to_the_last_bit_until_they_are_cleared() {
        let results = tempfile::tempdir().unwrap();
        let resume = Resume::below(results.path(), Depth::Quick).unwrap();
        let law = "R-L-C, 1:3";
        assert!(resume.read(law).is_none());
        resume.clear().unwrap();
        let numbers = [0.1 + 0.2, -1.0 / 3.0, 5e-324, 1.797e308, 0.0];
        let measurements: Vec<Measurement> = (numbers.iter())
            .map(|&x| Measurement::within(format!("case {x}"), "level, dB", x, 1.0))
            .collect();
        resume.write(law, &measurements).unwrap();
        assert_eq!(resume.read(law), Some(measurements));
        assert!(resume.read("R-L-C").is_none(), "another law");
        let full = Resume::below(results.path(), Depth::Full).unwrap();
        assert!(full.read(law).is_none(), "another depth");
        resume.clear().unwrap();
        assert!(resume.read(law).is_none());
    }
}
