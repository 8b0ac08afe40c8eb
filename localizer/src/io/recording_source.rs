//! A recording folder that is opened but not yet read: its logs on the sound's clock, and its sound period by period.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::description::PeriodicSpectrum;
use super::odometry_csv;
use super::recording_meta::{at, optional, read_meta, read_waveform};
use super::sound_reader::{SoundReader, begin};
use super::wav::{self, WavStream};
use crate::align::{Alignment, SPEED_OF_SOUND_MPS, SoundAligner, SoundClock};
use crate::echo;
use crate::echo::block_stream::{self, EachBlock};
use crate::error::Error;
use crate::odometry::{self, OdometrySample};
use crate::parameters::{DirectWave, Parameters};
use crate::pose::Pose;
use crate::recording::RecordingMeta;
use crate::trajectory::Trajectory;

pub use super::recording_meta::ReadOptions;

/// The rate at which sound is worked with holds the band of the code so many times.
const RATE_OVER_BAND: f64 = 2.1;

/// An opened recording folder. Times of the logs count from the first sample of the first period.
#[derive(Debug, Clone)]
pub struct RecordingSource {
    /// The content of `recording.json`, complete, of the aligned recording.
    pub meta: RecordingMeta,
    /// Speeds over time.
    pub odometry: Vec<OdometrySample>,
    /// True poses.
    pub truth: Option<Trajectory>,
    /// How the clocks were put together.
    pub alignment: Alignment,
    pub(super) folder: PathBuf,
    pub(super) clock: SoundClock,
    /// Duration of the aligned sound in seconds.
    duration_s: f64,
}

impl RecordingSource {
    /// Opens a recording folder and finds what neither `recording.json` nor `options` give.
    ///
    /// # Errors
    /// [`Error`] with the file and the field that is missing, damaged, does not fit the others, or cannot be found.
    pub fn open(folder: &Path, options: &ReadOptions) -> Result<Self, Error> {
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
        let origin = meta_path.display().to_string();
        let mut meta = read_meta(folder, options)?;
        let spectrum = read_waveform(folder, options, &mut meta)?;
        let speed_of_sound_assumed = meta.speed_of_sound_mps == 0.0;
        if speed_of_sound_assumed {
            meta.speed_of_sound_mps = SPEED_OF_SOUND_MPS;
        }
        let wav_path = folder.join("signal.wav");
        let stream = WavStream::open(&wav_path)?;
        let header_hz = stream.rate_hz();
        if meta.sample_rate_hz == 0.0 {
            meta.sample_rate_hz = header_hz;
        }
        wav::check_rate(
            &wav_path.display().to_string(),
            header_hz,
            meta.sample_rate_hz,
        )?;
        // Before anything is computed of these numbers; the whole samples of a period are made further below.
        meta.check_numbers(&origin, spectrum.is_some())?;
        let file_rate_hz = meta.sample_rate_hz;
        let clock = SoundClock {
            late_s: meta.late_s,
            drift_ppm: meta.drift_ppm,
        };
        let band_hz = spectrum.as_ref().map_or(
            meta.carrier_hz + meta.chip_rate_hz,
            PeriodicSpectrum::highest_hz,
        );
        let given = clock.late_s == Some(0.0) && clock.drift_ppm == Some(0.0);
        let period_s = meta.code_length as f64 / meta.chip_rate_hz;
        meta.sample_rate_hz = working_rate(period_s, file_rate_hz, band_hz, given);
        if let Some(spectrum) = &spectrum {
            let count = (spectrum.period_s * meta.sample_rate_hz).round() as usize;
            meta.transmitted = Some(Arc::from(spectrum.samples(count)));
        }
        meta.check(&origin)?;
        let parameters = aligning_parameters(&meta);
        let frames = stream.length();
        let channels = stream.channels();
        drop(stream);
        let mut source = Self {
            odometry: odometry_csv::read(&folder.join("odometry.csv"))?,
            truth: optional(&folder.join("truth.tum"), Trajectory::read_tum)?,
            alignment: Alignment::given(file_rate_hz, meta.sample_rate_hz, channels),
            folder: folder.to_owned(),
            clock,
            duration_s: frames as f64 / file_rate_hz,
            meta,
        };
        source.alignment.speed_of_sound_assumed = speed_of_sound_assumed;
        source.find_sound(&parameters)?;
        source.find_logs()?;
        let fastest_mps = 0.1 * source.meta.speed_of_sound_mps;
        let name = folder.display().to_string();
        odometry::check_samples(&source.odometry, source.duration_s, fastest_mps, &name)?;
        Ok(source)
    }

    /// Whether the samples of the file are those of the aligned sound.
    pub fn is_aligned(&self) -> bool {
        let zero = Some(0.0);
        self.clock.late_s == zero
            && self.clock.drift_ppm == zero
            && self.alignment.file_rate_hz == self.alignment.rate_hz
    }

    /// Duration of the sound from its first period on, in seconds.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// The pose at time 0: the truth where it covers it, else the start in `recording.json`, else the origin.
    pub fn start_pose(&self) -> Pose {
        self.known_start().unwrap_or_default()
    }

    /// As [`Self::start_pose`], but `None` instead of the origin.
    pub fn known_start(&self) -> Option<Pose> {
        let truth = self.truth.as_ref();
        let truth = truth.and_then(|truth| truth.covered_pose_at(0.0));
        truth.or(self.meta.start)
    }

    /// Refuses a channel without any sound: silent, or constant, as a dead microphone records.
    ///
    /// # Errors
    /// As [`crate::quality::check_signal`], or for a damaged file.
    pub fn check_signal(&self) -> Result<(), Error> {
        let mut stream = WavStream::open(&self.folder.join("signal.wav"))?;
        let (mut first, mut piece) = (None, Vec::new());
        while stream.read(1 << 14, self.alignment.channel, &mut piece)? > 0 {
            let first = *first.get_or_insert(piece[0]);
            if piece.iter().any(|&sample| sample != first) {
                return Ok(());
            }
            piece.clear();
        }
        crate::quality::check_signal(&[first.unwrap_or(0.0)], &self.folder.display().to_string())
    }

    /// The sound, period by period.
    ///
    /// # Errors
    /// [`Error`] when the file cannot be opened.
    pub fn sound(&self) -> Result<SoundReader, Error> {
        let parameters = aligning_parameters(&self.meta);
        let rate_hz = self.alignment.file_rate_hz;
        let aligner = SoundAligner::new(&parameters, rate_hz, self.clock)?;
        SoundReader::open(
            &self.folder.join("signal.wav"),
            self.alignment.channel,
            aligner,
        )
    }

    /// Measures the echoes of every block and hands them on in order: see [`block_stream::measure_each`].
    ///
    /// # Errors
    /// As [`crate::echo::measure`].
    pub fn measure_each(
        &self,
        parameters: &Parameters,
        each: &mut EachBlock<'_>,
    ) -> Result<(), Error> {
        if parameters.measurement.direct_wave == DirectWave::FreeField {
            return self.measure_less_direct(parameters, each);
        }
        let mut sound = self.sound()?;
        let (period_s, mut blocks) = (parameters.period_s(), 0);
        let mean = |n: usize| {
            let start_s = n as f64 * period_s;
            odometry::mean_over_time(&self.odometry, start_s, (n + 1) as f64 * period_s)
        };
        block_stream::measure_each(
            parameters,
            &mut || sound.next_period(),
            &mean,
            &mut |block, recent| {
                blocks += 1;
                each(block, recent)
            },
        )?;
        if blocks == 0 {
            let count = sound.report().periods;
            let problem = format!(
                "holds {count} whole periods, one block needs {}",
                parameters.measurement.periods
            );
            let remedy = "record longer or choose fewer periods";
            return Err(Error::invalid(
                self.folder.display(),
                "signal.wav",
                problem,
                remedy,
            ));
        }
        Ok(())
    }

    /// With a second recording without walls, both are read whole.
    fn measure_less_direct(
        &self,
        parameters: &Parameters,
        each: &mut EachBlock<'_>,
    ) -> Result<(), Error> {
        let echoes = echo::measure(&self.clone().load()?, parameters)?;
        for (index, block) in echoes.blocks.iter().enumerate() {
            if !each(block, echoes.recent_odometry(index))? {
                break;
            }
        }
        Ok(())
    }

    /// Finds channel, first period and drift by the beginning of the sound.
    fn find_sound(&mut self, parameters: &Parameters) -> Result<(), Error> {
        let path = self.folder.join("signal.wav");
        let channels = self.alignment.channels;
        let given = self.meta.channel.or((channels == 1).then_some(1));
        if let Some(channel) = given
            && !(1..=channels).contains(&channel)
        {
            let problem = format!("there is no channel {channel}");
            let remedy = format!("give 1 to {channels}");
            return Err(Error::invalid(path.display(), "channel", problem, remedy));
        }
        let known = self.clock.late_s.is_some() && self.clock.drift_ppm.is_some();
        if known && given.is_some() {
            self.alignment.channel = given.unwrap_or(1);
        } else {
            let mut trouble = None;
            let candidates = given.map_or((1..=channels).collect(), |channel| vec![channel]);
            let found = candidates.into_iter().find_map(|channel| {
                match begin(
                    &path,
                    channel,
                    self.alignment.file_rate_hz,
                    parameters,
                    self.clock,
                ) {
                    Ok(report) => Some((channel, report)),
                    Err(error) => {
                        trouble.get_or_insert(error);
                        None
                    }
                }
            });
            let Some((channel, report)) = found else {
                return Err(at(&path, trouble.unwrap_or_else(|| nothing(&path))));
            };
            self.alignment.channel = channel;
            if !known {
                self.alignment.sound = report;
            }
        }
        if known {
            self.alignment.sound.late_s = self.clock.late_s.unwrap_or(0.0);
            self.alignment.sound.drift_ppm = self.clock.drift_ppm.unwrap_or(0.0);
        }
        self.duration_s -= self.alignment.sound.late_s;
        if !known && self.folder.join("direct.wav").exists() {
            let remedy = "give late_s and drift_ppm in recording.json, or remove it";
            let problem = "cannot be aligned with a sound whose clock is found";
            return Err(Error::invalid(
                self.folder.display(),
                "direct.wav",
                problem,
                remedy,
            ));
        }
        self.meta.late_s = Some(0.0);
        self.meta.drift_ppm = Some(0.0);
        self.meta.channel = None;
        Ok(())
    }
}

/// Parameters by which a sound is aligned: no range counts, so that short codes can have it.
fn aligning_parameters(meta: &RecordingMeta) -> Parameters {
    let mut parameters = Parameters::default().for_recording(meta);
    let longest_m = parameters
        .signal
        .range_of_delay_m(parameters.samples_per_period() as f64 - 1.0);
    let measurement = &mut parameters.measurement;
    measurement.max_range_m = longest_m.min(measurement.min_range_m + 0.01);
    measurement.min_range_m = measurement.min_range_m.min(0.5 * measurement.max_range_m);
    measurement.range_pool_m = measurement.range_pool_m.min(measurement.max_range_m);
    parameters
}

fn nothing(path: &Path) -> Error {
    Error::invalid(
        path.display(),
        "sound",
        "has no channel",
        "export one channel",
    )
}

/// The rate at which a sound is worked with: a period is a whole number of samples, and the band up to `band_hz` is
/// held. That of the file where a period is a whole number of samples already and the sound is `aligned`.
pub fn working_rate(period_s: f64, file_rate_hz: f64, band_hz: f64, aligned: bool) -> f64 {
    let samples = period_s * file_rate_hz;
    if !(samples.is_finite() && samples > 1.0) {
        return file_rate_hz;
    }
    let is_whole = (samples - samples.round()).abs() < 1e-6;
    let fewer = (file_rate_hz / (RATE_OVER_BAND * band_hz)).floor().max(1.0);
    if is_whole && (aligned || fewer == 1.0) {
        return file_rate_hz;
    }
    (samples / fewer - 1e-6).ceil() / period_s
}
