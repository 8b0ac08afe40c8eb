//! Options of a recording's alignment, and what is told of it.

use std::path::{Path, PathBuf};

use anyhow::Result;
use localizer::io::recording_source::{ReadOptions, RecordingSource};

/// Numbers of a recording that are otherwise read from its recording.json, or found.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Alignment (found unless given here or in recording.json)")]
pub(super) struct AlignmentArguments {
    /// Channel of signal.wav, the first is 1.
    #[arg(long, value_name = "N")]
    channel: Option<usize>,
    /// Time of the first sample of a period since the first sample of the sound, milliseconds.
    #[arg(long, value_name = "MS")]
    late: Option<f64>,
    /// Excess of the recorder's rate over the loudspeaker's, parts per million.
    #[arg(long, value_name = "PPM", allow_hyphen_values = true)]
    drift: Option<f64>,
    /// Reading of the wheels' clock at the first sample of the sound, seconds.
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    odometry_clock: Option<f64>,
    /// Reading of the truth's clock at the first sample of the sound, seconds.
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    truth_clock: Option<f64>,
    /// What was played: the description that `transmit` writes, or a WAV of one period.
    #[arg(long, value_name = "FILE")]
    transmitted: Option<PathBuf>,
}

impl AlignmentArguments {
    /// The files that are read besides the recording's.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        self.transmitted.iter().cloned().collect()
    }

    /// As options of the library.
    pub(super) fn options(&self) -> ReadOptions {
        ReadOptions {
            channel: self.channel,
            late_s: self.late.map(|late_ms| 1e-3 * late_ms),
            drift_ppm: self.drift,
            odometry_clock_s: self.odometry_clock,
            truth_clock_s: self.truth_clock,
            transmitted: self.transmitted.clone(),
            aligned: false,
        }
    }

    /// Opens a recording and tells on standard error what was found.
    pub(super) fn open(&self, folder: &Path) -> Result<RecordingSource> {
        let source = RecordingSource::open(folder, &self.options())?;
        for line in source.alignment.told() {
            eprintln!("{}: {line}", folder.display());
        }
        Ok(source)
    }
}
