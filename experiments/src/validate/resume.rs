//! Measurements law by law: what the present field has been measured with is not measured again.

use std::path::{Path, PathBuf};

use anyhow::Result;
use oracles::laws::{Depth, Measurement};
use serde::{Deserialize, Serialize};

use crate::data::atomic;
use crate::data::cache::{sealed, unsealed};
use crate::run::provenance::Provenance;

/// Hash of the sources of field and laws.
const FIELD: &str = env!("FIELD_FINGERPRINT");

/// A folder of measurements, one file for each law.
pub struct Resume {
    folder: PathBuf,
}

/// The measurements of a law.
#[derive(Serialize, Deserialize)]
struct Measured {
    /// Hash of the sources that it was measured with.
    field: String,
    /// Revision that it was measured with.
    commit: String,
    /// Processor that it was measured on.
    cpu: String,
    measurements: Vec<Measurement>,
}

impl Resume {
    /// The measurements of a depth, in a folder of results: those of all cases beside table and figures, where they
    /// stay, those of a few in the cache.
    pub fn below(results: &Path, depth: Depth) -> Self {
        let folder = match depth {
            Depth::Full => results.join("validation").join("measured"),
            Depth::Quick => results.join("cache").join("validation"),
        };
        Self { folder }
    }

    /// File of a law, named by the letters of its name.
    fn file(&self, law: &str) -> PathBuf {
        let words = law.split(|letter: char| !letter.is_ascii_alphanumeric());
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        self.folder
            .join(format!("{}.json", words.join("-").to_lowercase()))
    }

    /// Measurements of a law by the present sources of field and laws; `None` when there are none or the file is
    /// damaged.
    pub fn read(&self, law: &str) -> Option<Vec<Measurement>> {
        let measured: Measured = unsealed(&std::fs::read(self.file(law)).ok()?)?;
        (measured.field == FIELD).then_some(measured.measurements)
    }

    /// Writes the measurements of a law.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, law: &str, measurements: &[Measurement]) -> Result<()> {
        let here = Provenance::here();
        let measured = Measured {
            field: FIELD.to_string(),
            commit: here.commit,
            cpu: here.cpu,
            measurements: measurements.to_vec(),
        };
        atomic::write(&self.file(law), sealed(&measured)?.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measurements_come_back_to_the_last_bit_from_the_same_sources() {
        let results = tempfile::tempdir().unwrap();
        let resume = Resume::below(results.path(), Depth::Quick);
        let law = "R-L-C, 1:3";
        assert!(resume.read(law).is_none());
        let numbers = [0.1 + 0.2, -1.0 / 3.0, 5e-324, 1.797e308, 0.0];
        let measurements: Vec<Measurement> = (numbers.iter())
            .map(|&x| Measurement::within(format!("case {x}"), "level, dB", x, 1.0))
            .collect();
        resume.write(law, &measurements).unwrap();
        assert_eq!(resume.read(law), Some(measurements.clone()));
        assert!(resume.read("R-L-C").is_none(), "another law");
        let full = Resume::below(results.path(), Depth::Full);
        assert!(full.read(law).is_none(), "another depth");
        let other = Measured {
            field: "other sources".to_string(),
            commit: String::new(),
            cpu: String::new(),
            measurements,
        };
        std::fs::write(resume.file(law), sealed(&other).unwrap()).unwrap();
        assert!(resume.read(law).is_none(), "other sources");
        std::fs::write(resume.file(law), "{").unwrap();
        assert!(resume.read(law).is_none(), "damaged");
    }
}
