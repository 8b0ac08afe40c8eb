//! Reading, one channel, piece by piece or whole.

use std::fs::File;
use std::io::Cursor;
use std::path::Path;

use symphonia::core::codecs::audio::{AudioDecoder, AudioDecoderOptions};
use symphonia::core::errors::Error as SymphoniaError;
use symphonia::core::formats::{FormatReader, TrackType};
use symphonia::core::io::{MediaSource, MediaSourceStream};
use symphonia::default::{formats::WavReader, get_codecs};

use super::MOST_CHANNELS;
use crate::error::Error;

/// A WAV file that is read piece by piece, one channel of it.
pub struct WavStream {
    reader: WavReader<'static>,
    decoder: Box<dyn AudioDecoder>,
    origin: String,
    rate_hz: f64,
    channels: usize,
    /// Frames that the header promises.
    length: u64,
    /// Frames read so far.
    frames: u64,
    /// Decoded frames, interleaved, and how many of the values are taken.
    decoded: Vec<f64>,
    taken: usize,
    /// Frames decoded so far.
    found: u64,
}

impl WavStream {
    /// Opens a file.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be opened; [`Error::Invalid`] when it is no WAV file.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let file = File::open(path).map_err(|source| Error::io(path, source))?;
        Self::new(Box::new(file), &path.display().to_string())
    }

    /// Reads the header of a source that `origin` names in errors.
    fn new(source: Box<dyn MediaSource>, origin: &str) -> Result<Self, Error> {
        let refuse = |field: &str, problem: String, remedy: &str| {
            Error::invalid(origin, field, problem, remedy)
        };
        let most = source.byte_len().unwrap_or(u64::MAX);
        let source = MediaSourceStream::new(source, Default::default());
        let reader = WavReader::try_new(source, Default::default())
            .map_err(|error| damaged(origin, &error))?;
        let track = reader.default_track(TrackType::Audio);
        let codec = track
            .and_then(|track| track.codec_params.as_ref()?.audio().cloned())
            .ok_or_else(|| refuse("WAV format", "holds no sound".into(), "export it again"))?;
        let Some(length) = track.and_then(|track| track.num_frames) else {
            let remedy = "write a whole file, not through a pipe, or convert it once more";
            return Err(refuse("WAV format", "tells no length".into(), remedy));
        };
        let channels = codec
            .channels
            .as_ref()
            .map_or(0, |channels| channels.count());
        if !(1..=usize::from(MOST_CHANNELS)).contains(&channels) {
            let problem = format!("there are {channels}");
            return Err(refuse("channels", problem, "export 1 to 64"));
        }
        let rate_hz = f64::from(codec.sample_rate.unwrap_or_default());
        if rate_hz == 0.0 {
            let remedy = "repair the file's header";
            return Err(refuse("sample rate", "is 0 Hz".into(), remedy));
        }
        // No sample takes less than a byte.
        if length > most {
            let problem = format!("its {most} bytes do not hold the {length} frames of its header");
            let remedy = "write a whole file, not through a pipe, or export it again";
            return Err(refuse("samples", problem, remedy));
        }
        let decoder = get_codecs()
            .make_audio_decoder(&codec, &AudioDecoderOptions::default())
            .map_err(|error| damaged(origin, &error))?;
        Ok(Self {
            reader,
            decoder,
            origin: origin.to_owned(),
            rate_hz,
            channels,
            length,
            frames: 0,
            decoded: Vec::new(),
            taken: 0,
            found: 0,
        })
    }

    /// Sample rate of the header in Hz.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Number of channels.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Frames that the header promises.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Appends at most `frames` samples of a channel (the first is 1) to `samples`; fewer at the end of the file.
    ///
    /// # Errors
    /// [`Error`] for a channel that is not there, a file that is damaged, ends before its header says or holds nothing,
    /// or a sample that is not finite.
    pub fn read(
        &mut self,
        frames: usize,
        channel: usize,
        samples: &mut Vec<f32>,
    ) -> Result<usize, Error> {
        let channels = self.channels;
        if !(1..=channels).contains(&channel) {
            let problem = format!("there is no channel {channel}");
            let remedy = format!("give 1 to {channels}");
            return Err(Error::invalid(&self.origin, "channel", problem, remedy));
        }
        let before = samples.len();
        while samples.len() - before < frames && self.decode()? {
            let wanted = (frames - (samples.len() - before)) * channels;
            let end = self.decoded.len().min(self.taken + wanted);
            let fresh = self.decoded[self.taken..end].iter().skip(channel - 1);
            samples.extend(fresh.step_by(channels).map(|&sample| sample as f32));
            self.taken = end;
        }
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

    /// Makes some decoded frames ready; false at the end.
    fn decode(&mut self) -> Result<bool, Error> {
        while self.taken == self.decoded.len() {
            let damaged = |error: SymphoniaError| damaged(&self.origin, &error);
            let Some(packet) = self.reader.next_packet().map_err(damaged)? else {
                return self.check_end().map(|()| false);
            };
            let sound = self.decoder.decode(&packet).map_err(damaged)?;
            self.decoded.resize(sound.samples_interleaved(), 0.0);
            sound.copy_to_slice_interleaved(&mut self.decoded);
            self.taken = 0;
            self.found += (self.decoded.len() / self.channels) as u64;
            if self.found > self.length {
                return self.check_end().map(|()| false);
            }
        }
        Ok(true)
    }

    /// Refuses a file with another number of frames than its header promises, or none.
    fn check_end(&self) -> Result<(), Error> {
        if self.found != self.length {
            let problem = format!("there are {}, its header says {}", self.found, self.length);
            let remedy = "export it again";
            return Err(Error::invalid(&self.origin, "samples", problem, remedy));
        }
        if self.found == 0 {
            let remedy = "record again";
            return Err(Error::invalid(
                &self.origin,
                "samples",
                "there are none",
                remedy,
            ));
        }
        Ok(())
    }
}

fn damaged(origin: &str, error: &SymphoniaError) -> Error {
    let remedy = "write a whole file of 32-bit float or 16-bit PCM, not through a pipe";
    Error::invalid(origin, "WAV format", error, remedy)
}

/// Reads a mono WAV file of the given rate.
///
/// # Errors
/// [`Error::Io`] when the file cannot be opened, otherwise those of [`parse`].
pub fn read(path: &Path, sample_rate_hz: f64) -> Result<Vec<f32>, Error> {
    whole(WavStream::open(path)?, sample_rate_hz)
}

/// Reads the bytes of a mono WAV file of the given rate; `origin` names it in errors.
///
/// # Errors
/// [`Error::Invalid`] when they are no WAV file, end before its lengths say, hold several channels, another rate, no
/// sample, or samples that are not finite.
pub fn parse(bytes: Vec<u8>, sample_rate_hz: f64, origin: &str) -> Result<Vec<f32>, Error> {
    let stream = WavStream::new(Box::new(Cursor::new(bytes)), origin)?;
    whole(stream, sample_rate_hz)
}

fn whole(mut stream: WavStream, sample_rate_hz: f64) -> Result<Vec<f32>, Error> {
    if stream.channels() != 1 {
        let problem = format!("there are {}", stream.channels());
        let remedy = "export one channel";
        return Err(Error::invalid(&stream.origin, "channels", problem, remedy));
    }
    check_rate(&stream.origin, stream.rate_hz(), sample_rate_hz)?;
    let mut samples = Vec::new();
    while stream.read(1 << 16, 1, &mut samples)? > 0 {}
    Ok(samples)
}

/// Refuses a header's rate, whole hertz, that is not the one that recording.json gives.
pub(crate) fn check_rate(origin: &str, header_hz: f64, sample_rate_hz: f64) -> Result<(), Error> {
    if (header_hz - sample_rate_hz).abs() <= 0.5 {
        return Ok(());
    }
    let problem = format!("{header_hz} Hz, but recording.json says {sample_rate_hz} Hz");
    let remedy = "correct sample_rate_hz in recording.json, or leave it out";
    Err(Error::invalid(origin, "sample rate", problem, remedy))
}
