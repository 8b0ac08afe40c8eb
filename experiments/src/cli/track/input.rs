//! Where the sound of `track` comes from: standard input, or a sound device that plays the code too.

use std::io::BufReader;

use anyhow::{Result, bail};
use localizer::Parameters;
use localizer::align::SoundClock;

use super::Arguments;
use super::sound::Sound;
use super::stream::Stream;
use crate::live::pcm::{self, Format, Layout};
use crate::localization::Stream as Engine;

/// A sound device at work, until it is dropped.
#[cfg(feature = "audio")]
pub(super) type Device = crate::live::audio::Audio;

/// No device.
#[cfg(not(feature = "audio"))]
pub(super) enum Device {}

#[cfg(not(feature = "audio"))]
impl Device {
    pub(super) fn lost(&self) -> u64 {
        match *self {}
    }
}

/// What a run reads and computes with.
pub(super) struct Input {
    pub(super) engine: Engine,
    pub(super) parameters: Parameters,
    pub(super) sound: Sound,
    pub(super) device: Option<Device>,
}

impl Arguments {
    /// Opens the sound and sets the localizer up for its rate.
    pub(super) fn open(&self) -> Result<Input> {
        if self.audio {
            return self.of_device();
        }
        let mut input = BufReader::with_capacity(1 << 16, std::io::stdin());
        let layout = match self.format {
            Format::Wav => pcm::header(&mut input, self.channel)?,
            _ => self.layout(self.format, self.channels.unwrap_or(1))?,
        };
        let (engine, parameters) = self.engine(layout.rate_hz)?;
        let stream = Stream::start(input, layout);
        let sound = Sound::start(stream, layout, &parameters, self.sound_clock())?;
        Ok(Input {
            engine,
            parameters,
            sound,
            device: None,
        })
    }

    fn layout(&self, format: Format, channels: usize) -> Result<Layout> {
        Layout {
            format,
            rate_hz: self.rate,
            channels,
            channel: self.channel,
        }
        .checked()
    }

    fn sound_clock(&self) -> SoundClock {
        SoundClock {
            late_s: self.late.map(|late_ms| 1e-3 * late_ms),
            drift_ppm: self.drift,
        }
    }

    #[cfg(not(feature = "audio"))]
    fn of_device(&self) -> Result<Input> {
        bail!(
            "--audio: this build has no sound devices; build one with cargo build --release -p experiments --features \
             audio (on Linux it needs ALSA's headers, libasound2-dev), or pipe the sound in"
        )
    }

    #[cfg(feature = "audio")]
    fn of_device(&self) -> Result<Input> {
        use crate::live::audio::{Audio, Wanted};

        let layout = self.layout(Format::F32, self.channels.unwrap_or(1))?;
        if self.rate.fract() != 0.0 {
            bail!(
                "--rate: {} Hz; give whole hertz to a sound device",
                self.rate
            );
        }
        if !(self.level <= 0.0 && self.level >= -120.0) {
            bail!("--level: {} dB; give -120 to 0", self.level);
        }
        if let Some(seconds) = self.seconds
            && !(seconds > 0.0 && seconds <= 1e6)
        {
            bail!("--seconds: {seconds}; give more than 0 and at most 1000000");
        }
        let (engine, parameters) = self.engine(layout.rate_hz)?;
        let wanted = Wanted {
            microphone: self.microphone.as_deref(),
            loudspeaker: self.loudspeaker.as_deref(),
            rate_hz: self.rate as u32,
            channels: self.channels.map(|channels| channels as u16),
            seconds: self.seconds,
        };
        let (device, pieces) = Audio::start(self.played(&parameters)?, wanted)?;
        let layout = self.layout(Format::F32, device.channels)?;
        let stream = Stream::of_device(pieces);
        let sound = Sound::start(stream, layout, &parameters, self.sound_clock())?;
        Ok(Input {
            engine,
            parameters,
            sound,
            device: Some(device),
        })
    }

    /// What is played over and over: whole periods that are whole samples of the device.
    #[cfg(feature = "audio")]
    fn played(&self, parameters: &Parameters) -> Result<Vec<f32>> {
        use localizer::io::description::PeriodicSpectrum;

        use crate::transmission::Transmission;

        let is_wav = |path: &&std::path::PathBuf| path.extension().is_none_or(|end| end != "json");
        let seam = || {
            format!(
                "--rate: no number of periods up to a thousand is a whole number of samples at {} Hz: the device \
                 cannot repeat it without a seam; give another rate",
                self.rate
            )
        };
        if let Some(path) = self.transmitted.as_ref().filter(is_wav) {
            let spectrum = PeriodicSpectrum::read(path, None)?;
            let samples = spectrum.period_s * self.rate;
            if (samples - samples.round()).abs() > 1e-6 {
                bail!(seam());
            }
            let period = spectrum.samples(samples.round() as usize);
            let peak = period
                .iter()
                .fold(f32::MIN_POSITIVE, |peak, own| peak.max(own.abs()));
            let scale = 10_f64.powf(0.05 * self.level) as f32 / peak;
            return Ok(period.iter().map(|own| own * scale).collect());
        }
        let signal = &parameters.signal;
        let sound = Transmission {
            seconds: parameters.period_s(),
            rate_hz: self.rate as u32,
            level_db: self.level,
            code_length: signal.code_length,
            carrier_hz: signal.carrier_hz,
            chip_rate_hz: signal.chip_rate_hz,
        }
        .sound()?;
        if !sound.seamless {
            bail!(seam());
        }
        Ok(sound.samples.iter().map(|own| own * sound.scale).collect())
    }
}
