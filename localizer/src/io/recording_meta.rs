//! `recording.json` and what describes the transmitted signal.

use std::path::{Path, PathBuf};

use super::description::{PeriodicSpectrum, TransmitDescription};
use super::files;
use crate::error::Error;
use crate::recording::RecordingMeta;

/// What the user gives in place of `recording.json`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Channel of `signal.wav`, the first is 1.
    pub channel: Option<usize>,
    /// First sample of a period after the first of the sound, in seconds.
    pub late_s: Option<f64>,
    /// Excess of the recorder's rate over the loudspeaker's, parts per million.
    pub drift_ppm: Option<f64>,
    /// Reading of the wheels' clock at the first sample of the sound, in seconds.
    pub odometry_clock_s: Option<f64>,
    /// Reading of the truth's clock at the first sample of the sound, in seconds.
    pub truth_clock_s: Option<f64>,
    /// Description (`.json`) or one period (`.wav`) of what was transmitted.
    pub transmitted: Option<PathBuf>,
    /// What `recording.json` leaves out is zero instead of being found: the recording is aligned.
    pub aligned: bool,
}

/// `recording.json`, what describes the transmitted signal, and the options.
pub(super) fn read_meta(folder: &Path, options: &ReadOptions) -> Result<RecordingMeta, Error> {
    let path = folder.join("recording.json");
    let description = match &options.transmitted {
        Some(path) if path.extension().is_some_and(|end| end == "json") => Some(path.clone()),
        _ => Some(folder.join("transmitted.json")).filter(|path| path.exists()),
    };
    let has_waveform = options.transmitted.is_some() || folder.join("transmitted.wav").exists();
    let mut meta = if !path.exists() && (description.is_some() || has_waveform) {
        serde_json::from_str("{}")
            .map_err(|problem| Error::invalid(path.display(), "content", problem, "report this"))?
    } else {
        files::read_json::<RecordingMeta>(&path)?
    };
    if let Some(path) = description {
        let code = TransmitDescription::read(&path)?;
        let given = (meta.code_length, meta.chip_rate_hz, meta.carrier_hz);
        if given != (0, 0.0, 0.0) && given != (code.code_length, code.chip_rate_hz, code.carrier_hz)
        {
            let problem = "is not the code of recording.json";
            let remedy = "leave the code out of recording.json, or take the right description";
            return Err(Error::invalid(
                path.display(),
                "code_length",
                problem,
                remedy,
            ));
        }
        meta.code_length = code.code_length;
        meta.chip_rate_hz = code.chip_rate_hz;
        meta.carrier_hz = code.carrier_hz;
    }
    meta.channel = options.channel.or(meta.channel);
    meta.late_s = options.late_s.or(meta.late_s);
    meta.drift_ppm = options.drift_ppm.or(meta.drift_ppm);
    meta.odometry_clock_s = options.odometry_clock_s.or(meta.odometry_clock_s);
    meta.truth_clock_s = options.truth_clock_s.or(meta.truth_clock_s);
    if options.aligned {
        for field in [
            &mut meta.late_s,
            &mut meta.drift_ppm,
            &mut meta.odometry_clock_s,
            &mut meta.truth_clock_s,
        ] {
            field.get_or_insert(0.0);
        }
    }
    Ok(meta)
}

/// The waveform of `transmitted.wav`, if there is one; its numbers take the place of the code's.
pub(super) fn read_waveform(
    folder: &Path,
    options: &ReadOptions,
    meta: &mut RecordingMeta,
) -> Result<Option<PeriodicSpectrum>, Error> {
    let own = folder.join("transmitted.wav");
    let path = match &options.transmitted {
        Some(path) if path.extension().is_some_and(|end| end == "wav") => path,
        _ if own.exists() => &own,
        _ => return Ok(None),
    };
    let period_s = meta.code_length as f64 / meta.chip_rate_hz;
    let spectrum = PeriodicSpectrum::read(path, Some(period_s).filter(|period_s| *period_s > 0.0))?;
    if meta.code_length == 0 || meta.chip_rate_hz == 0.0 {
        meta.code_length = 1;
        meta.chip_rate_hz = 1.0 / spectrum.period_s;
    }
    if meta.carrier_hz == 0.0 {
        meta.carrier_hz = spectrum.centroid_hz();
    }
    Ok(Some(spectrum))
}

/// An error with the file it belongs to.
pub(super) fn at(path: &Path, error: Error) -> Error {
    match error {
        Error::Invalid {
            field,
            problem,
            remedy,
            ..
        } => Error::invalid(path.display(), field, problem, remedy),
        other => other,
    }
}

/// Reads a file if it is there.
pub(super) fn optional<T>(
    path: &Path,
    read: impl Fn(&Path) -> Result<T, Error>,
) -> Result<Option<T>, Error> {
    path.exists().then(|| read(path)).transpose()
}
