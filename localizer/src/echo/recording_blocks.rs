//! A recording cut into blocks of M periods, freed from the direct wave.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::echo::block_buffer::remove_direct;
use crate::echo::doppler_bank::DopplerBank;
use crate::error::Error;
use crate::odometry::Odometry;
use crate::parameters::{DirectWave, Parameters};
use crate::recording::Recording;
use crate::signal::direct_wave::{self, DirectWaveEstimate};

/// Blocks that one thread takes at a time: few, so that no thread waits long for another at the end.
const TOGETHER: usize = 8;

/// A recording that was checked, and how it is cut into blocks.
pub(crate) struct Drive<'a> {
    parameters: &'a Parameters,
    /// The bank for its blocks.
    pub(crate) bank: DopplerBank,
    /// The signal, without the direct wave of `direct.wav` if that is to be subtracted.
    pub(crate) signal: Cow<'a, [f32]>,
    /// Mean odometry of every period.
    pub(crate) odometry: Vec<Odometry>,
}

impl<'a> Drive<'a> {
    /// Checks a recording.
    ///
    /// # Errors
    /// As [`crate::echo::measure`].
    pub(crate) fn new(recording: &'a Recording, parameters: &'a Parameters) -> Result<Self, Error> {
        let bank = DopplerBank::new(parameters)?;
        if parameters.for_recording(&recording.meta) != *parameters {
            let problem = "waveform, sample rate or speed of sound differ from recording.json";
            return Err(Error::invalid(
                "parameters",
                "waveform",
                problem,
                "take those of the recording",
            ));
        }
        recording.check("recording")?;
        let count = recording.signal.len() / parameters.samples_per_period();
        if count < parameters.measurement.periods {
            let problem = format!(
                "holds {count} whole periods, one block needs {}",
                parameters.measurement.periods
            );
            return Err(Error::invalid(
                "recording",
                "signal.wav",
                problem,
                "record longer or choose fewer periods",
            ));
        }
        let signal = match parameters.measurement.direct_wave {
            DirectWave::FreeField => Cow::Owned(direct_wave::subtract_free_field(
                &recording.signal,
                recording.direct.as_deref(),
            )?),
            _ => Cow::Borrowed(recording.signal.as_slice()),
        };
        Ok(Self {
            odometry: recording.odometry_per_period(parameters.period_s(), count),
            parameters,
            bank,
            signal,
        })
    }

    /// The direct wave's estimate in a signal at the end of every block. The average is a matter of order and cheap; the bank is neither.
    pub(crate) fn directs(&self, signal: &[f32]) -> Vec<Vec<f32>> {
        let (period, periods) = (
            self.parameters.samples_per_period(),
            self.parameters.measurement.periods,
        );
        let mut estimate = DirectWaveEstimate::new(self.parameters);
        let mut directs = Vec::with_capacity(self.odometry.len() + 1 - periods);
        for (index, samples) in signal.chunks_exact(period).enumerate() {
            estimate.push(samples);
            if index + 1 >= periods {
                let mut direct = vec![0.0; period];
                estimate.write(&mut direct);
                directs.push(direct);
            }
        }
        directs
    }

    /// Writes block `index` of a signal without its direct wave.
    pub(crate) fn free(
        &self,
        signal: &[f32],
        directs: &[Vec<f32>],
        index: usize,
        freed: &mut [f32],
    ) {
        let start = index * self.parameters.samples_per_period();
        let received = &signal[start..start + freed.len()];
        remove_direct(received, &directs[index], freed);
    }

    /// Odometry of the periods of block `index`, preceded by that of the period before if there is one.
    pub(crate) fn recent_odometry(&self, index: usize) -> &[Odometry] {
        &self.odometry[index.saturating_sub(1)..index + self.parameters.measurement.periods]
    }

    /// Mean odometry of the periods of block `index`.
    pub(crate) fn odometry_of(&self, index: usize) -> &[Odometry] {
        &self.odometry[index..index + self.parameters.measurement.periods]
    }
}

/// Applies `each` to every block of a recording (its number, its samples without the direct wave, the odometry of its periods), in parallel, each
/// thread with its own buffers from `buffers`. Returns the results in order and the mean odometry of every period.
///
/// # Errors
/// As [`crate::echo::measure`].
pub(crate) fn map_blocks<B, T: Send>(
    recording: &Recording,
    parameters: &Parameters,
    buffers: impl Fn(&DopplerBank) -> B + Sync,
    each: impl Fn(&DopplerBank, &mut B, usize, &[f32], &[Odometry]) -> T + Sync,
) -> Result<(Vec<T>, Vec<Odometry>), Error> {
    let drive = Drive::new(recording, parameters)?;
    let bank = &drive.bank;
    let directs = drive.directs(&drive.signal);
    let blocks = (0..directs.len())
        .into_par_iter()
        .with_max_len(TOGETHER)
        .map_init(
            || (buffers(bank), vec![0.0; bank.block_length()]),
            |(own, freed), index| {
                drive.free(&drive.signal, &directs, index, freed);
                each(bank, own, index, freed, drive.odometry_of(index))
            },
        )
        .collect();
    Ok((blocks, drive.odometry))
}
