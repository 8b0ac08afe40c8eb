//! Blocks of M periods of a whole recording, without the direct wave.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::echo::doppler_bank::DopplerBank;
use crate::error::Error;
use crate::odometry::Odometry;
use crate::parameters::{DirectWave, Parameters};
use crate::recording::Recording;
use crate::signal::direct_wave::{self, DirectWaveEstimate};

/// Blocks of one parallel task: few, so that all threads end at about the same time.
const BLOCKS_PER_TASK: usize = 8;

/// A checked recording and the bank for its blocks.
pub(crate) struct RecordingBlocks<'a> {
    parameters: &'a Parameters,
    /// The bank for its blocks.
    pub(crate) bank: DopplerBank,
    /// The signal; with [`DirectWave::FreeField`] less the samples of `direct.wav`.
    pub(crate) signal: Cow<'a, [f32]>,
    /// Mean odometry of every period.
    pub(crate) odometry: Vec<Odometry>,
    /// Periods that were not heard.
    unheard: &'a [usize],
}

impl<'a> RecordingBlocks<'a> {
    /// Checks a recording.
    ///
    /// # Errors
    /// As [`crate::echo::measure`].
    pub(crate) fn new(recording: &'a Recording, parameters: &'a Parameters) -> Result<Self, Error> {
        parameters.check()?;
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
        // Its size is the recording's from here on.
        parameters.check_memory_of_echoes(count + 1 - parameters.measurement.periods)?;
        let bank = DopplerBank::new(parameters)?;
        let signal = match parameters.measurement.direct_wave {
            DirectWave::FreeField => Cow::Owned(direct_wave::subtract_free_field(
                &recording.signal,
                recording.direct.as_deref(),
            )?),
            _ => Cow::Borrowed(recording.signal.as_slice()),
        };
        Ok(Self {
            odometry: recording.odometry_per_period(parameters.period_s(), count),
            unheard: &recording.unheard,
            parameters,
            bank,
            signal,
        })
    }

    /// One period of the direct wave as estimated at the end of every block, sequentially.
    pub(crate) fn direct_waves(&self, signal: &[f32]) -> Vec<Vec<f32>> {
        let (period, periods) = (
            self.parameters.samples_per_period(),
            self.parameters.measurement.periods,
        );
        let mut estimate = DirectWaveEstimate::new(self.parameters);
        let mut direct_waves = Vec::with_capacity(self.odometry.len() + 1 - periods);
        for (index, samples) in signal.chunks_exact(period).enumerate() {
            if self.unheard.binary_search(&index).is_err() {
                estimate.push(samples);
            }
            if index + 1 >= periods {
                let mut direct = vec![0.0; period];
                estimate.write(&mut direct);
                direct_waves.push(direct);
            }
        }
        direct_waves
    }

    /// Writes block `index` of a signal, less its direct wave, to `clean`.
    pub(crate) fn clean_block(
        &self,
        signal: &[f32],
        direct_waves: &[Vec<f32>],
        index: usize,
        clean: &mut [f32],
    ) {
        let start = index * self.parameters.samples_per_period();
        let received = &signal[start..start + clean.len()];
        direct_wave::subtract_period(received, &direct_waves[index], clean);
    }

    /// Odometry of the periods of block `index`, preceded by that of the period before if there is one.
    pub(crate) fn recent_odometry(&self, index: usize) -> &[Odometry] {
        &self.odometry[index.saturating_sub(1)..index + self.parameters.measurement.periods]
    }

    /// Mean odometry of each period of block `index`.
    pub(crate) fn odometry_of(&self, index: usize) -> &[Odometry] {
        &self.odometry[index..index + self.parameters.measurement.periods]
    }
}

/// Applies `each` to every block of a recording: its number, its samples without the direct wave, and the odometry of
/// its periods. Blocks run in parallel, each thread with its own buffers from `buffers`. Returns the results in order
/// and the mean odometry of every period.
///
/// # Errors
/// As [`crate::echo::measure`].
pub(crate) fn map_blocks<B, T: Send>(
    recording: &Recording,
    parameters: &Parameters,
    buffers: impl Fn(&DopplerBank) -> B + Sync,
    each: impl Fn(&DopplerBank, &mut B, usize, &[f32], &[Odometry]) -> T + Sync,
) -> Result<(Vec<T>, Vec<Odometry>), Error> {
    let recorded = RecordingBlocks::new(recording, parameters)?;
    let bank = &recorded.bank;
    let direct_waves = recorded.direct_waves(&recorded.signal);
    let blocks = (0..direct_waves.len())
        .into_par_iter()
        .with_max_len(BLOCKS_PER_TASK)
        .map_init(
            || (buffers(bank), vec![0.0; bank.block_length()]),
            |(own, clean), index| {
                recorded.clean_block(&recorded.signal, &direct_waves, index, clean);
                each(bank, own, index, clean, recorded.odometry_of(index))
            },
        )
        .collect();
    Ok((blocks, recorded.odometry))
}
