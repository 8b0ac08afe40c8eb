//! Recording folders: `signal.wav`, `odometry.csv`, `recording.json`, and optionally `truth.tum` and `direct.wav`.

use std::path::Path;

use super::{files, odometry_csv, wav};
use crate::error::Error;
use crate::recording::{Recording, RecordingMeta};
use crate::trajectory::Trajectory;

impl Recording {
    /// Reads a recording folder.
    ///
    /// # Errors
    /// [`Error`] with the file and the field that is missing, damaged, or does not fit the others.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        if !folder.is_dir() {
            let remedy = "give a folder with signal.wav, odometry.csv and recording.json";
            return Err(Error::invalid(
                folder.display(),
                "recording",
                "is not a folder",
                remedy,
            ));
        }
        let meta_path = folder.join("recording.json");
        let meta: RecordingMeta = files::read_json(&meta_path)?;
        meta.check(&meta_path.display().to_string())?;
        let signal = wav::read(&folder.join("signal.wav"), meta.sample_rate_hz)?;
        let direct_path = folder.join("direct.wav");
        let direct = if direct_path.exists() {
            Some(wav::read(&direct_path, meta.sample_rate_hz)?)
        } else {
            None
        };
        let truth_path = folder.join("truth.tum");
        let truth = if truth_path.exists() {
            Some(Trajectory::read_tum(&truth_path)?)
        } else {
            None
        };
        let mut recording = Self {
            signal,
            direct,
            odometry: odometry_csv::read(&folder.join("odometry.csv"))?,
            truth,
            meta,
        };
        recording.shift_clocks(-1.0);
        recording.check(&folder.display().to_string())?;
        Ok(recording)
    }

    /// Writes a recording folder, making it if necessary. Every file is written under a temporary name and renamed.
    ///
    /// # Errors
    /// [`Error`] when the recording does not pass [`Self::check`] or a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        self.check(&folder.display().to_string())?;
        files::make_folder(folder)?;
        wav::write(
            &folder.join("signal.wav"),
            &self.signal,
            self.meta.sample_rate_hz,
        )?;
        if let Some(direct) = &self.direct {
            wav::write(&folder.join("direct.wav"), direct, self.meta.sample_rate_hz)?;
        }
        let mut logs = Self {
            signal: Vec::new(),
            direct: None,
            odometry: self.odometry.clone(),
            truth: self.truth.clone(),
            meta: self.meta.clone(),
        };
        logs.shift_clocks(1.0);
        if let Some(truth) = &logs.truth {
            truth.write_tum(&folder.join("truth.tum"))?;
        }
        odometry_csv::write(&folder.join("odometry.csv"), &logs.odometry)?;
        files::write_json(&folder.join("recording.json"), &self.meta)
    }

    /// Adds `sign` times the readings of the logs' own clocks at the first sample to their times.
    fn shift_clocks(&mut self, sign: f64) {
        let shift_s = sign * self.meta.odometry_clock_s;
        for sample in &mut self.odometry {
            sample.t_s += shift_s;
        }
        let shift_s = sign * self.meta.truth_clock_s;
        for t_s in self.truth.iter_mut().flat_map(|truth| &mut truth.t_s) {
            *t_s += shift_s;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::tests::recording;

    #[test]
    fn a_folder_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/recording");
        let written = recording();
        written.write(&path).unwrap();
        let read = Recording::read(&path).unwrap();
        assert_eq!(read.signal, written.signal);
        assert_eq!(read.direct, written.direct);
        assert_eq!(read.odometry, written.odometry);
        assert_eq!(read.meta, written.meta);
        assert!((read.start_pose().x_m - 1.0).abs() < 1e-9);
        assert!(std::fs::read_dir(&path).unwrap().all(|entry| {
            entry
                .unwrap()
                .path()
                .extension()
                .is_some_and(|end| end != "part")
        }));
    }

    #[test]
    fn logs_keep_their_own_clocks_in_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let mut written = recording();
        written.meta.odometry_clock_s = 512.25;
        written.meta.truth_clock_s = 1.7e9;
        written.meta.microphone_offset_m = [0.1, -0.02];
        written.write(folder.path()).unwrap();
        let text = std::fs::read_to_string(folder.path().join("truth.tum")).unwrap();
        assert!(text.starts_with("1700000000.000000 "), "{text}");
        let read = Recording::read(folder.path()).unwrap();
        let pairs = || read.odometry.iter().zip(&written.odometry);
        assert!(pairs().all(|(a, b)| (a.t_s - b.t_s).abs() < 1e-9));
        assert_eq!(read.truth.as_ref().unwrap().t_s, [0.0]);
        assert_eq!(read.meta.sensor_offset_m(), [0.05, -0.01]);
    }

    #[test]
    fn errors_name_file_and_field() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let message = |path: &Path| Recording::read(path).unwrap_err().to_string();
        assert!(message(&path.join("none")).contains("not a folder"));
        recording().write(path).unwrap();
        std::fs::remove_file(path.join("odometry.csv")).unwrap();
        assert!(message(path).contains("odometry.csv"));
        recording().write(path).unwrap();
        std::fs::write(
            path.join("recording.json"),
            r#"{"sample_rate_hz": 40000, "rate": 3}"#,
        )
        .unwrap();
        assert!(message(path).contains("recording.json"));
        let mut other = recording();
        other.meta.sample_rate_hz = 50_000.0;
        files::write_json(&path.join("recording.json"), &other.meta).unwrap();
        assert!(message(path).contains("signal.wav"));
        let mut bad = recording();
        bad.signal[7] = f32::NAN;
        assert!(bad.check("x").unwrap_err().to_string().contains("sample 7"));
        let mut bad = recording();
        bad.direct = Some(vec![0.0; 3]);
        assert!(
            bad.check("x")
                .unwrap_err()
                .to_string()
                .contains("direct.wav")
        );
    }
}
