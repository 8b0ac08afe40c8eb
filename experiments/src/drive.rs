//! A drive as mapping and localization take it: read from its folder block by block, or whole in memory.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use anyhow::Result;
use localizer::echo::block_stream::EachBlock;
use localizer::io::recording_source::RecordingSource;
use localizer::odometry::OdometrySample;
use localizer::recording::RecordingMeta;
use localizer::{Error, Parameters, Recording, Trajectory, echo, quality};

/// Sound and logs of a drive, and the name under which errors speak of it.
pub struct Drive<'a> {
    /// Its folder, or another name.
    pub name: PathBuf,
    sound: Sound<'a>,
}

enum Sound<'a> {
    Folder(&'a RecordingSource),
    Loaded(&'a Recording),
}

impl<'a> Drive<'a> {
    /// A drive that is read block by block, so that memory does not grow with the sound.
    pub fn of_folder(source: &'a RecordingSource, folder: &Path) -> Self {
        Self {
            name: folder.to_path_buf(),
            sound: Sound::Folder(source),
        }
    }

    /// A drive in memory.
    pub fn loaded(recording: &'a Recording, name: impl Into<PathBuf>) -> Self {
        Self {
            name: name.into(),
            sound: Sound::Loaded(recording),
        }
    }

    /// Waveform, rates and places of the sensors.
    pub fn meta(&self) -> &RecordingMeta {
        match self.sound {
            Sound::Folder(source) => &source.meta,
            Sound::Loaded(recording) => &recording.meta,
        }
    }

    /// True poses.
    pub fn truth(&self) -> Option<&Trajectory> {
        match self.sound {
            Sound::Folder(source) => source.truth.as_ref(),
            Sound::Loaded(recording) => recording.truth.as_ref(),
        }
    }

    /// Speeds over time.
    pub fn odometry(&self) -> &[OdometrySample] {
        match self.sound {
            Sound::Folder(source) => &source.odometry,
            Sound::Loaded(recording) => &recording.odometry,
        }
    }

    /// Duration of the sound in seconds.
    pub fn duration_s(&self) -> f64 {
        match self.sound {
            Sound::Folder(source) => source.duration_s(),
            Sound::Loaded(recording) => recording.duration_s(),
        }
    }

    /// Refuses a dead microphone, see [`quality::check_signal`].
    ///
    /// # Errors
    /// [`Error::Invalid`], or [`Error::Io`] when the sound cannot be read.
    pub fn check_signal(&self) -> Result<(), Error> {
        match self.sound {
            Sound::Folder(source) => source.check_signal(),
            Sound::Loaded(recording) => {
                quality::check_signal(&recording.signal, &self.name.display().to_string())
            }
        }
    }

    /// Measures the echoes of every block and hands them on in order.
    ///
    /// # Errors
    /// As [`echo::measure`].
    pub fn measure_each(
        &self,
        parameters: &Parameters,
        each: &mut EachBlock<'_>,
    ) -> Result<(), Error> {
        let recording = match self.sound {
            Sound::Folder(source) => return source.measure_each(parameters, each),
            Sound::Loaded(recording) => recording,
        };
        let echoes = echo::measure(recording, parameters)?;
        for (index, block) in echoes.blocks.iter().enumerate() {
            if !each(block, echoes.recent_odometry(index))? {
                break;
            }
        }
        Ok(())
    }

    /// The drive with its sound in memory.
    ///
    /// # Errors
    /// When the sound cannot be read.
    pub fn load(&self) -> Result<Cow<'a, Recording>, Error> {
        match self.sound {
            Sound::Folder(source) => Ok(Cow::Owned(source.clone().load()?)),
            Sound::Loaded(recording) => Ok(Cow::Borrowed(recording)),
        }
    }
}
