//! `echolot import`.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use localizer::Trajectory;
use localizer::io::odometry_csv;

use super::arguments::ForceArgument;
use super::output::print_json;
use crate::bag::{self, Topics};
use crate::data::atomic;
use crate::data::manifest::Manifest;
use crate::data::place::Place;

/// Format of the samples in the messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum AudioFormat {
    /// 16-bit integers, little endian.
    S16,
    /// 32-bit float, little endian.
    F32,
}

/// Arguments of `import`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot import drive.mcap -o recordings/drive --transmitted tx.json --rate 48000\n\n\
    Topics are nav_msgs/Odometry, geometry_msgs/PoseStamped or TransformStamped, and audio_common_msgs/AudioData; name \
    them where there are several. Times stay those of the messages. A bag that is cut off gives what it has."
)]
pub(crate) struct Arguments {
    /// ROS 2 bag: an MCAP file, or the folder of one.
    bag: PathBuf,
    /// Folder of the recording.
    #[arg(short, long, value_name = "RECORDING")]
    output: PathBuf,
    /// Topic of the wheels' odometry.
    #[arg(long, value_name = "TOPIC")]
    odometry: Option<String>,
    /// Topic of the true poses.
    #[arg(long, value_name = "TOPIC")]
    truth: Option<String>,
    /// Topic of the sound.
    #[arg(long, value_name = "TOPIC")]
    audio: Option<String>,
    /// Format of the sound.
    #[arg(long, value_enum, default_value_t = AudioFormat::S16)]
    format: AudioFormat,
    /// Sample rate of the sound, whole hertz.
    #[arg(long, value_name = "F")]
    rate: u32,
    /// Channels of the sound.
    #[arg(long, value_name = "N", default_value_t = 1)]
    channels: u16,
    /// Speed of sound, m/s.
    #[arg(long, value_name = "MPS")]
    speed_of_sound: Option<f64>,
    /// Description that `transmit` wrote; it is copied into the recording.
    #[arg(long, value_name = "TX.json")]
    transmitted: Option<PathBuf>,
    #[command(flatten)]
    force: ForceArgument,
}

impl Arguments {
    /// The WAV of the samples: a header before them.
    fn wav(&self, samples: &[u8]) -> Result<Vec<u8>> {
        let (tag, bytes) = match self.format {
            AudioFormat::S16 => (1_u16, 2_u32),
            AudioFormat::F32 => (3, 4),
        };
        let frame = bytes * u32::from(self.channels);
        let length = samples.len() as u64 - samples.len() as u64 % u64::from(frame);
        let length = u32::try_from(length)
            .ok()
            .filter(|length| *length < u32::MAX - 36);
        let Some(length) = length else {
            bail!(
                "--audio: has more than 4 GB of samples, which no WAV holds; import a part of the bag"
            );
        };
        let mut wav = Vec::with_capacity(44 + length as usize);
        wav.extend(b"RIFF");
        wav.extend((36 + length).to_le_bytes());
        wav.extend(b"WAVEfmt ");
        wav.extend(16_u32.to_le_bytes());
        wav.extend(tag.to_le_bytes());
        wav.extend(self.channels.to_le_bytes());
        wav.extend(self.rate.to_le_bytes());
        wav.extend((self.rate * frame).to_le_bytes());
        wav.extend((frame as u16).to_le_bytes());
        wav.extend((8 * bytes as u16).to_le_bytes());
        wav.extend(b"data");
        wav.extend(length.to_le_bytes());
        wav.extend(&samples[..length as usize]);
        Ok(wav)
    }

    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
        if !(1000..=1_000_000).contains(&self.rate) {
            bail!("--rate: {} Hz; give 1000 to 1000000", self.rate);
        }
        if !(1..=64).contains(&self.channels) {
            bail!("--channels: {}; give 1 to 64", self.channels);
        }
        let bytes = std::fs::metadata(&self.bag).map_or(0, |data| data.len());
        let place = Place {
            inputs: [Some(self.bag.clone()), self.transmitted.clone()]
                .into_iter()
                .flatten()
                .collect(),
            bytes,
            ..Place::of(&self.output, self.force.force)
        };
        place.whole_folder()?;
        let topics = Topics {
            odometry: self.odometry.clone(),
            truth: self.truth.clone(),
            audio: self.audio.clone(),
        };
        let imported = bag::import(&self.bag, &topics)?;
        for warning in &imported.warnings {
            eprintln!("{}: warning: {warning}", self.bag.display());
        }
        let origin = |name: &str| format!("{}: {name}", self.bag.display());
        // What cannot be read again is refused now.
        let wheels = odometry_csv::parse(&imported.odometry, &origin("odometry"))?;
        let poses = match &imported.truth {
            Some(text) => Trajectory::from_tum(text, &origin("truth"))?.len(),
            None => 0,
        };
        if imported.audio.is_empty() {
            bail!("{}: --audio: has no samples", self.bag.display());
        }
        let wav = self.wav(&imported.audio)?;
        let mut meta = serde_json::json!({
            "sample_rate_hz": self.rate,
            "provenance": {
                "bag": self.bag.file_name().map(|name| name.to_string_lossy()),
                "first_sound_s": imported.audio_s,
            },
        });
        if let Some(speed) = self.speed_of_sound {
            meta["speed_of_sound_mps"] = speed.into();
        }
        let description = self
            .transmitted
            .as_ref()
            .map(|path| std::fs::read(path).with_context(|| path.display().to_string()));
        let description = description.transpose()?;
        atomic::write_folder(&self.output, |folder| {
            std::fs::write(folder.join("signal.wav"), &wav)?;
            std::fs::write(folder.join("odometry.csv"), &imported.odometry)?;
            if let Some(truth) = &imported.truth {
                std::fs::write(folder.join("truth.tum"), truth)?;
            }
            if let Some(description) = &description {
                std::fs::write(folder.join("transmitted.json"), description)?;
            }
            let text = serde_json::to_string_pretty(&meta)? + "\n";
            std::fs::write(folder.join("recording.json"), text)?;
            Manifest::of(folder)?.write(folder)
        })?;
        if json {
            return print_json(&serde_json::json!({
                "recording": self.output,
                "odometry": wheels.len(),
                "poses": poses,
                "audio_bytes": imported.audio.len(),
                "warnings": imported.warnings,
            }));
        }
        eprintln!(
            "wrote {} ({} lines of odometry, {poses} true poses); look at it: echolot record check {}",
            self.output.display(),
            wheels.len(),
            self.output.display()
        );
        Ok(())
    }
}
