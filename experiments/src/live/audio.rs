//! A sound device that plays the code over and over and records what comes back.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, Result, anyhow, bail};
use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{
    Device, ErrorKind, FromSample, Host, I24, Sample, SampleFormat, SizedSample, StreamConfig,
    SupportedStreamConfig, SupportedStreamConfigRange,
};

/// Time of sound that waits for the localizer, in seconds; more is lost, and counted.
const WAITING_S: u64 = 60;

/// Formats that are used, the best first.
const FORMATS: [SampleFormat; 4] = [
    SampleFormat::F32,
    SampleFormat::I32,
    SampleFormat::I24,
    SampleFormat::I16,
];

/// What is wanted of the devices.
#[derive(Debug, Clone, Copy)]
pub struct Wanted<'a> {
    /// Name of the microphone's device; the system's default unless given.
    pub microphone: Option<&'a str>,
    /// Name of the loudspeaker's device; the system's default unless given.
    pub loudspeaker: Option<&'a str>,
    /// Sample rate of both, Hz.
    pub rate_hz: u32,
    /// Channels of the microphone's device; the fewest it has unless given.
    pub channels: Option<u16>,
    /// Time after which the recording ends, in seconds; it does not unless given.
    pub seconds: Option<f64>,
}

/// Samples of all channels, frame by frame, as the device gives them.
#[derive(Debug)]
pub struct Pieces {
    /// The pieces.
    pub receiver: Receiver<std::io::Result<Vec<f32>>>,
    /// Samples that wait: who takes a piece takes its length off.
    pub waiting: Arc<AtomicU64>,
}

/// Both devices at work, until it is dropped.
pub struct Audio {
    _recording: cpal::Stream,
    _playing: cpal::Stream,
    line: Arc<Line>,
    /// Channels of the recording.
    pub channels: usize,
}

impl Audio {
    /// Plays the samples, of full scale 1, over and over on all channels of the loudspeaker, and records.
    ///
    /// # Errors
    /// When there is no such device, or one cannot do what is wanted; the error names the devices there are, or what
    /// the one can do.
    pub fn start(played: Vec<f32>, wanted: Wanted) -> Result<(Self, Pieces)> {
        if played.is_empty() {
            bail!("--audio: has nothing to play");
        }
        let host = cpal::default_host();
        let loudspeaker = match wanted.loudspeaker {
            Some(name) => named(&host, name, "--loudspeaker")?,
            None => (host.default_output_device())
                .context("--loudspeaker: the system has no default device; name one")?,
        };
        let microphone = match wanted.microphone {
            Some(name) => named(&host, name, "--microphone")?,
            None => (host.default_input_device())
                .context("--microphone: the system has no default device; name one")?,
        };
        let of = |option: &str, device: &Device| format!("{option}: {device}");
        let out = supported(
            loudspeaker.supported_output_configs(),
            wanted.rate_hz,
            None,
            &of("--loudspeaker", &loudspeaker),
        )?;
        let into = supported(
            microphone.supported_input_configs(),
            wanted.rate_hz,
            wanted.channels,
            &of("--microphone", &microphone),
        )?;
        let (line, pieces) =
            Line::of(WAITING_S * u64::from(wanted.rate_hz) * u64::from(into.channels()));
        // The loudspeaker first: the search for the code then has it from the first sample.
        let playing = match out.sample_format() {
            SampleFormat::F32 => play::<f32>(&loudspeaker, out.config(), played, &line),
            SampleFormat::I32 => play::<i32>(&loudspeaker, out.config(), played, &line),
            SampleFormat::I24 => play::<I24>(&loudspeaker, out.config(), played, &line),
            _ => play::<i16>(&loudspeaker, out.config(), played, &line),
        };
        let playing = playing.with_context(|| of("--loudspeaker", &loudspeaker))?;
        let frames = wanted
            .seconds
            .map(|seconds| (seconds * f64::from(wanted.rate_hz)) as u64);
        let left = frames.map(|frames| frames.saturating_mul(u64::from(into.channels())));
        let recording = match into.sample_format() {
            SampleFormat::F32 => record::<f32>(&microphone, into.config(), &line, left),
            SampleFormat::I32 => record::<i32>(&microphone, into.config(), &line, left),
            SampleFormat::I24 => record::<I24>(&microphone, into.config(), &line, left),
            _ => record::<i16>(&microphone, into.config(), &line, left),
        };
        let recording = recording.with_context(|| of("--microphone", &microphone))?;
        eprintln!(
            "sound: plays on {loudspeaker}, records {} channel(s) of {microphone}, {} Hz",
            into.channels(),
            wanted.rate_hz
        );
        let audio = Self {
            _recording: recording,
            _playing: playing,
            line,
            channels: usize::from(into.channels()),
        };
        Ok((audio, pieces))
    }

    /// Samples that were lost because nobody took them in time.
    pub fn lost(&self) -> u64 {
        self.line.lost.load(Ordering::Relaxed)
    }
}

/// The device of a name or identifier.
fn named(host: &Host, name: &str, option: &str) -> Result<Device> {
    let devices: Vec<Device> = host
        .devices()
        .map(|devices| devices.collect())
        .unwrap_or_default();
    let id = |device: &Device| device.id().map(|id| id.id().to_string()).ok();
    let found = (devices.iter())
        .find(|device| id(device).as_deref() == Some(name) || device.to_string() == name);
    if let Some(found) = found {
        return Ok(found.clone());
    }
    // Names that a system knows and does not list, such as those of a configuration file.
    if let Some(device) = host.device_by_id(&cpal::DeviceId::new(host.id(), name)) {
        return Ok(device);
    }
    let names: Vec<String> = devices.iter().filter_map(id).collect();
    match names.is_empty() {
        true => bail!("{option}: `{name}` is no device; there is none"),
        false => bail!(
            "{option}: `{name}` is no device; there are {}",
            names.join(", ")
        ),
    }
}

/// A configuration at the rate: of the wanted channels, or the fewest, in the best format.
fn supported(
    ranges: Result<impl Iterator<Item = SupportedStreamConfigRange>, cpal::Error>,
    rate_hz: u32,
    channels: Option<u16>,
    origin: &str,
) -> Result<SupportedStreamConfig> {
    let ranges: Vec<_> = ranges.with_context(|| origin.to_string())?.collect();
    let place = |range: &SupportedStreamConfigRange| {
        let format = range.sample_format();
        FORMATS.iter().position(|own| *own == format)
    };
    let fitting = ranges.iter().filter(|range| {
        place(range).is_some()
            && channels.is_none_or(|channels| channels == range.channels())
            && (range.min_sample_rate()..=range.max_sample_rate()).contains(&rate_hz)
    });
    let best = fitting.min_by_key(|range| (range.channels(), place(range)));
    best.map(|range| range.with_sample_rate(rate_hz))
        .ok_or_else(|| {
            let can: Vec<String> = ranges
                .iter()
                .map(|range| {
                    format!(
                        "{} channel(s) of {} at {} to {} Hz",
                        range.channels(),
                        range.sample_format(),
                        range.min_sample_rate(),
                        range.max_sample_rate()
                    )
                })
                .collect();
            let wanted = channels.map_or(String::new(), |channels| format!("{channels} channel(s) at "));
            anyhow!(
                "{origin}: cannot do {wanted}{rate_hz} Hz in 16 bits or more; give another --rate or --channels; it \
                 can do {}",
                can.join(", ")
            )
        })
}

/// Where recorded samples go, until the end or an error.
struct Line {
    sender: Mutex<Option<Sender<std::io::Result<Vec<f32>>>>>,
    waiting: Arc<AtomicU64>,
    most: u64,
    lost: AtomicU64,
}

impl Line {
    /// A line in which so many samples may wait.
    fn of(most: u64) -> (Arc<Self>, Pieces) {
        let (sender, receiver) = channel();
        let waiting = Arc::new(AtomicU64::new(0));
        let line = Self {
            sender: Mutex::new(Some(sender)),
            waiting: Arc::clone(&waiting),
            most,
            lost: AtomicU64::new(0),
        };
        (Arc::new(line), Pieces { receiver, waiting })
    }

    /// Hands samples on; the device does not wait for those who take them.
    fn hand(&self, piece: Vec<f32>) {
        let count = piece.len() as u64;
        let sender = self.sender.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(sender) = sender.as_ref() else {
            return;
        };
        let fits = self.waiting.load(Ordering::Relaxed) + count <= self.most;
        // Counted before it is sent, so that who takes it finds it counted.
        self.waiting
            .fetch_add(if fits { count } else { 0 }, Ordering::Relaxed);
        if !fits || sender.send(Ok(piece)).is_err() {
            self.lost.fetch_add(count, Ordering::Relaxed);
        }
    }

    /// Ends it, with what went wrong if something did.
    fn end(&self, trouble: Option<String>) {
        let sender = self
            .sender
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let (Some(sender), Some(trouble)) = (sender, trouble) {
            // Where nobody takes what was recorded, nobody hears of this either.
            let _ = sender.send(Err(std::io::Error::other(trouble)));
        }
    }

    /// What an error of a running device means: lost samples are told and survived, others end the recording.
    fn trouble(&self, what: &str, error: &cpal::Error) {
        match error.kind() {
            ErrorKind::Xrun => eprintln!("sound: the {what} lost samples"),
            ErrorKind::DeviceChanged | ErrorKind::RealtimeDenied => {}
            _ => self.end(Some(format!("{what}: {error}"))),
        }
    }
}

fn record<T>(
    device: &Device,
    config: StreamConfig,
    line: &Arc<Line>,
    mut left: Option<u64>,
) -> Result<cpal::Stream, cpal::Error>
where
    T: SizedSample,
    f32: FromSample<T>,
{
    let (own, told) = (Arc::clone(line), Arc::clone(line));
    let stream = device.build_input_stream::<T, _, _>(
        config,
        move |samples, _| {
            let most = left.map_or(samples.len(), |left| samples.len().min(left as usize));
            let piece = samples[..most]
                .iter()
                .map(|sample| f32::from_sample(*sample));
            own.hand(piece.collect());
            if let Some(left) = &mut left {
                *left -= most as u64;
                if *left == 0 {
                    own.end(None);
                }
            }
        },
        move |error| told.trouble("microphone", &error),
        None,
    )?;
    stream.play()?;
    Ok(stream)
}

fn play<T>(
    device: &Device,
    config: StreamConfig,
    played: Vec<f32>,
    line: &Arc<Line>,
) -> Result<cpal::Stream, cpal::Error>
where
    T: SizedSample + FromSample<f32>,
{
    let channels = usize::from(config.channels).max(1);
    let (told, mut place) = (Arc::clone(line), 0);
    let stream = device.build_output_stream::<T, _, _>(
        config,
        move |samples, _| fill(samples, channels, &played, &mut place),
        move |error| told.trouble("loudspeaker", &error),
        None,
    )?;
    stream.play()?;
    Ok(stream)
}

/// The next frames of what is played over and over, the same on all channels.
fn fill<T: Sample + FromSample<f32>>(
    samples: &mut [T],
    channels: usize,
    played: &[f32],
    place: &mut usize,
) {
    for frame in samples.chunks_mut(channels) {
        frame.fill(T::from_sample(played[*place]));
        *place = (*place + 1) % played.len();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_played_goes_on_over_pieces_of_any_length_on_all_channels() {
        let played: Vec<f32> = (0..7).map(|k| k as f32 / 8.0).collect();
        let (mut place, mut heard) = (0, Vec::new());
        for frames in [1, 6, 7, 20, 3] {
            let mut piece = vec![0_i16; 2 * frames];
            fill(&mut piece, 2, &played, &mut place);
            heard.extend(piece);
        }
        for (k, frame) in heard.chunks(2).enumerate() {
            assert_eq!(frame, [i16::from_sample(played[k % 7]); 2], "{k}");
        }
    }

    #[test]
    fn a_line_that_nobody_reads_loses_samples_and_counts_them() {
        let (line, pieces) = Line::of(25);
        for _ in 0..5 {
            line.hand(vec![0.0; 10]);
        }
        assert_eq!(line.lost.load(Ordering::Relaxed), 30);
        let taken = pieces.receiver.recv().unwrap().unwrap().len();
        pieces.waiting.fetch_sub(taken as u64, Ordering::Relaxed);
        line.hand(vec![0.0; 10]);
        line.end(None);
        line.hand(vec![1.0]);
        let left: usize = pieces
            .receiver
            .iter()
            .map(|piece| piece.unwrap().len())
            .sum();
        assert_eq!((left, line.lost.load(Ordering::Relaxed)), (20, 30));
    }
}
