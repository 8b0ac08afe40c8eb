//! Reading, one channel, piece by piece or whole.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use hound::{SampleFormat, WavReader, WavSpec};

use super::{MOST_CHANNELS, of_hound};
use crate::error::Error;

/// A WAV stream that is read piece by piece, one channel of it.
pub struct WavStream<R> {
    reader: WavReader<R>,
    origin: String,
    spec: WavSpec,
    /// Frames read so far.
    frames: u64,
}

impl WavStream<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be opened; [`Error::Invalid`] when it is no WAV file.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let file = File::open(path).map_err(|source| Error::io(path, source))?;
        Self::new(BufReader::new(file), &path.display().to_string())
    }
}

impl<R: Read> WavStream<R> {
    /// Reads the header of a stream that `origin` names in errors.
    ///
    /// # Errors
    /// As [`WavStream::open`].
    pub fn new(stream: R, origin: &str) -> Result<Self, Error> {
        let reader = WavReader::new(stream).map_err(|error| of_hound(Path::new(origin), error))?;
        let spec = reader.spec();
        let refuse = |field: &str, problem: String, remedy: &str| {
            Err(Error::invalid(origin, field, problem, remedy))
        };
        if !(1..=MOST_CHANNELS).contains(&spec.channels) {
            return refuse(
                "channels",
                format!("there are {}", spec.channels),
                "export 1 to 64",
            );
        }
        if spec.sample_rate == 0 {
            return refuse(
                "sample rate",
                "is 0 Hz".to_owned(),
                "repair the file's header",
            );
        }
        Ok(Self {
            reader,
            origin: origin.to_owned(),
            spec,
            frames: 0,
        })
    }

    /// Sample rate of the header in Hz.
    pub fn rate_hz(&self) -> f64 {
        f64::from(self.spec.sample_rate)
    }

    /// Number of channels.
    pub fn channels(&self) -> usize {
        usize::from(self.spec.channels)
    }

    /// Frames that the header promises.
    pub fn length(&self) -> u64 {
        u64::from(self.reader.duration())
    }

    /// Appends at most `frames` samples of a channel (the first is 1) to `samples`; fewer at the end of the stream.
    ///
    /// # Errors
    /// [`Error`] for a channel that is not there, a damaged file, or a sample that is not finite.
    pub fn read(
        &mut self,
        frames: usize,
        channel: usize,
        samples: &mut Vec<f32>,
    ) -> Result<usize, Error> {
        let channels = self.channels();
        if !(1..=channels).contains(&channel) {
            let problem = format!("there is no channel {channel}");
            let remedy = format!("give 1 to {channels}");
            return Err(Error::invalid(&self.origin, "channel", problem, remedy));
        }
        let before = samples.len();
        let place = channel - 1;
        let read = match self.spec.sample_format {
            SampleFormat::Float => {
                let values = self.reader.samples::<f32>().take(frames * channels);
                take_channel(values, channels, place, |value| value, samples)
            }
            SampleFormat::Int => {
                let scale = 0.5_f64.powi(i32::from(self.spec.bits_per_sample) - 1);
                let values = self.reader.samples::<i32>().take(frames * channels);
                let scaled = |value: i32| (f64::from(value) * scale) as f32;
                take_channel(values, channels, place, scaled, samples)
            }
        };
        read.map_err(|error| of_hound(Path::new(&self.origin), error))?;
        let fresh = &samples[before..];
        if let Some(place) = fresh.iter().position(|sample| !sample.is_finite()) {
            let problem = format!(
                "sample {} is not a finite number",
                self.frames + place as u64
            );
            let remedy = "repair or cut the file";
            return Err(Error::invalid(&self.origin, "samples", problem, remedy));
        }
        self.frames += fresh.len() as u64;
        Ok(fresh.len())
    }
}

/// Appends every `channels`-th value.
fn take_channel<T>(
    values: impl Iterator<Item = Result<T, hound::Error>>,
    channels: usize,
    place: usize,
    scale: impl Fn(T) -> f32,
    samples: &mut Vec<f32>,
) -> Result<(), hound::Error> {
    for (index, value) in values.enumerate() {
        match value {
            Ok(value) if index % channels == place => samples.push(scale(value)),
            Ok(_) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// Reads a mono WAV file of the given rate.
///
/// # Errors
/// [`Error::Io`] when the file cannot be opened; [`Error::Invalid`] when it is no WAV file, has several channels,
/// another rate, or samples that are not finite.
pub fn read(path: &Path, sample_rate_hz: f64) -> Result<Vec<f32>, Error> {
    let mut stream = WavStream::open(path)?;
    let refuse = |field: &str, problem: String, remedy: &str| {
        Err(Error::invalid(path.display(), field, problem, remedy))
    };
    if stream.channels() != 1 {
        let problem = format!("there are {}", stream.channels());
        return refuse("channels", problem, "export one channel");
    }
    check_rate(path, stream.rate_hz(), sample_rate_hz)?;
    let mut samples = Vec::new();
    while stream.read(1 << 16, 1, &mut samples)? > 0 {}
    Ok(samples)
}

/// Refuses a header's rate, whole hertz, that is not the one that recording.json gives.
pub(crate) fn check_rate(path: &Path, header_hz: f64, sample_rate_hz: f64) -> Result<(), Error> {
    if (header_hz - sample_rate_hz).abs() <= 0.5 {
        return Ok(());
    }
    let problem = format!("{header_hz} Hz, but recording.json says {sample_rate_hz} Hz");
    let remedy = "correct sample_rate_hz in recording.json, or leave it out";
    Err(Error::invalid(
        path.display(),
        "sample rate",
        problem,
        remedy,
    ))
}
