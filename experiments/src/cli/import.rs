//! `echolot import`.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use localizer::Trajectory;
use localizer::io::odometry_csv;
use localizer::io::wav::WavStream;

use super::arguments::ForceArgument;
use super::output::print_json;
use crate::bag::{self, Imported, Topics, folder};
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

/// Unit of times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TimeUnit {
    /// Seconds.
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
    /// Nanoseconds.
    Ns,
}

impl TimeUnit {
    fn seconds(self) -> f64 {
        match self {
            Self::S => 1.0,
            Self::Ms => 1e-3,
            Self::Us => 1e-6,
            Self::Ns => 1e-9,
        }
    }
}

/// Where a recording's sound comes from.
enum Sound {
    /// Samples of messages, at a rate.
    Messages(Vec<u8>, u32),
    /// A WAV file.
    File(PathBuf),
}

/// Arguments of `import`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  echolot import drive.mcap -o recordings/drive --transmitted tx.json --rate 48000\n\n\
    Topics are nav_msgs/Odometry, geometry_msgs/PoseStamped or TransformStamped, and audio_common_msgs/AudioData; name \
    them where there are several. Times stay those of the messages. A bag that is cut off gives what it has.\n\n\
    A folder of a WAV and a table of poses (a CSV with columns such as t, x, y, yaw, or qx to qw) is imported too, as \
    public data sets lay them out:\n  \
    echolot import trajectoRIR -o recordings/t --sound audio/MOV/S1/SL1/MC1/V1/M1.wav --poses meta/cart_pose.csv\n\
    Its wheels are the table's speeds and turn rates (columns such as vx, yaw_rate_deg) or else made of the poses, \
    unless you replace odometry.csv."
)]
pub(crate) struct Arguments {
    /// ROS 2 bag (an MCAP file, or the folder of one), or a folder of a WAV and a table of poses.
    #[arg(value_name = "BAG|FOLDER")]
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
    /// Sample rate of a bag's sound, whole hertz.
    #[arg(long, value_name = "F")]
    rate: Option<u32>,
    /// Channels of a bag's sound.
    #[arg(long, value_name = "N", default_value_t = 1)]
    channels: u16,
    /// WAV of a folder, below it; the only one unless given.
    #[arg(long, value_name = "WAV")]
    sound: Option<PathBuf>,
    /// Table of a folder's poses, below it; the only CSV unless given.
    #[arg(long, value_name = "CSV")]
    poses: Option<PathBuf>,
    /// Unit of the times of a folder's poses.
    #[arg(long, value_enum, default_value_t = TimeUnit::S)]
    time_unit: TimeUnit,
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
    fn wav(&self, samples: &[u8], rate: u32) -> Result<Vec<u8>> {
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
        wav.extend(rate.to_le_bytes());
        wav.extend((rate * frame).to_le_bytes());
        wav.extend((frame as u16).to_le_bytes());
        wav.extend((8 * bytes as u16).to_le_bytes());
        wav.extend(b"data");
        wav.extend(length.to_le_bytes());
        wav.extend(&samples[..length as usize]);
        Ok(wav)
    }

    /// Whether the folder holds files and no bag.
    fn is_folder(&self) -> bool {
        let has = |end: &str| {
            let entries = std::fs::read_dir(&self.bag).into_iter().flatten().flatten();
            entries
                .map(|entry| entry.path())
                .any(|path| path.extension().is_some_and(|own| own == end))
        };
        self.bag.is_dir() && !has("mcap") && !has("db3")
    }

    /// A folder of a WAV and a table of poses.
    fn of_folder(&self) -> Result<(Imported, Sound)> {
        let named = |given: &Option<PathBuf>, end: &str, option: &str| match given {
            Some(name) => Ok(self.bag.join(name)),
            None => folder::only(&self.bag, end, option),
        };
        let sound = named(&self.sound, "wav", "--sound")?;
        let table = folder::poses(
            &named(&self.poses, "csv", "--poses")?,
            self.time_unit.seconds(),
        )?;
        WavStream::open(&sound)?;
        let imported = Imported {
            odometry: table.odometry(),
            truth: Some(table.path.to_tum()),
            warnings: table.warnings(),
            ..Imported::default()
        };
        Ok((imported, Sound::File(sound)))
    }

    /// A bag.
    fn of_bag(&self) -> Result<(Imported, Sound)> {
        let Some(rate) = self.rate.filter(|rate| (1000..=1_000_000).contains(rate)) else {
            bail!(
                "--rate: is missing or no rate of sound; give 1000 to 1000000 Hz, that of the bag's sound"
            );
        };
        if !(1..=64).contains(&self.channels) {
            bail!("--channels: {}; give 1 to 64", self.channels);
        }
        let topics = Topics {
            odometry: self.odometry.clone(),
            truth: self.truth.clone(),
            audio: self.audio.clone(),
        };
        let mut imported = bag::import(&self.bag, &topics)?;
        if imported.audio.is_empty() {
            bail!("{}: --audio: has no samples", self.bag.display());
        }
        let samples = std::mem::take(&mut imported.audio);
        Ok((imported, Sound::Messages(samples, rate)))
    }

    /// Runs the command.
    pub(crate) fn run(self, json: bool) -> Result<()> {
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
        let (imported, sound) = match self.is_folder() {
            true => self.of_folder()?,
            false => self.of_bag()?,
        };
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
        let name = self.bag.file_name().map(|name| name.to_string_lossy());
        let mut meta = match &sound {
            Sound::Messages(_, rate) => serde_json::json!({
                "sample_rate_hz": rate,
                "provenance": {"bag": name, "first_sound_s": imported.audio_s},
            }),
            Sound::File(_) => serde_json::json!({"provenance": {"folder": name}}),
        };
        if let Some(speed) = self.speed_of_sound {
            meta["speed_of_sound_mps"] = speed.into();
        }
        let description = self
            .transmitted
            .as_ref()
            .map(|path| std::fs::read(path).with_context(|| path.display().to_string()));
        let description = description.transpose()?;
        atomic::write_folder(&self.output, |folder| {
            let wav = folder.join("signal.wav");
            match &sound {
                Sound::Messages(samples, rate) => std::fs::write(wav, self.wav(samples, *rate)?)?,
                Sound::File(file) => drop(std::fs::copy(file, wav)?),
            }
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
