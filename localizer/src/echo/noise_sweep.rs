//! Echoes of one recording under several noises at several levels each, some blocks at a time.

use rayon::prelude::*;

use crate::echo::doppler_bank::{DopplerBank, DopplerScratch};
use crate::echo::echo_blocks::EchoBlock;
use crate::echo::recording_blocks::RecordingBlocks;
use crate::error::Error;
use crate::odometry::Odometry;
use crate::parameters::Parameters;
use crate::recording::Recording;

/// Noise to be added to a recording, at several levels.
#[derive(Debug, Clone, PartialEq)]
pub struct AddedNoise {
    /// As many samples as the recording has.
    pub samples: Vec<f32>,
    /// Factors of the samples.
    pub levels: Vec<f32>,
}

/// A recording to whose signal noises are added, `signal + level noise`, measured some blocks at a time.
///
/// All of eqs. (1)-(3) but the envelope is linear: the signal and each noise are correlated once for all levels. The
/// caller takes some blocks at a time, because the echoes of a whole drive at all levels do not fit into memory.
pub struct NoiseSweep<'a> {
    recorded: RecordingBlocks<'a>,
    parameters: &'a Parameters,
    noises: &'a [AddedNoise],
    /// Estimates of the direct wave at the end of every block: those in the signal, and below those in each noise.
    direct_waves: Vec<Vec<f32>>,
    noise_direct_waves: Vec<Vec<Vec<f32>>>,
}

/// Buffers of one thread.
struct Scratch {
    signal: DopplerScratch,
    noises: Vec<DopplerScratch>,
    clean: Vec<f32>,
}

impl<'a> NoiseSweep<'a> {
    /// Checks a recording and noises for it. A free-field direct wave is subtracted from the signal alone.
    ///
    /// # Errors
    /// As [`crate::echo::measure`], and [`Error::Invalid`] when a noise has another length than the signal.
    pub fn new(
        recording: &'a Recording,
        noises: &'a [AddedNoise],
        parameters: &'a Parameters,
    ) -> Result<Self, Error> {
        let recorded = RecordingBlocks::new(recording, parameters)?;
        let length = recorded.signal.len();
        if let Some(noise) = noises.iter().find(|noise| noise.samples.len() != length) {
            let problem = format!(
                "{} samples of noise for {length} of the signal",
                noise.samples.len()
            );
            return Err(Error::invalid("noise", "length", problem, "give as many"));
        }
        Ok(Self {
            direct_waves: recorded.direct_waves(&recorded.signal),
            noise_direct_waves: noises
                .iter()
                .map(|noise| recorded.direct_waves(&noise.samples))
                .collect(),
            recorded,
            parameters,
            noises,
        })
    }

    /// Number of blocks of the recording.
    pub fn blocks(&self) -> usize {
        self.direct_waves.len()
    }

    /// Odometry for the filter at a block, see [`crate::EchoSequence::recent_odometry`].
    pub fn recent_odometry(&self, block: usize) -> &[Odometry] {
        self.recorded.recent_odometry(block)
    }

    /// Buffers for `count` blocks: for each, one block of echoes per noise and level, noise by noise.
    pub fn buffers(&self, count: usize) -> Vec<Vec<EchoBlock>> {
        let levels = self.noises.iter().map(|noise| noise.levels.len()).sum();
        let block = EchoBlock::empty(&self.recorded.bank);
        vec![vec![block; levels]; count]
    }

    /// Measures block `first` and those after it into [`Self::buffers`], in parallel over the blocks. Up to rounding,
    /// the result is that of [`crate::echo::measure`] for each of the sums.
    ///
    /// # Panics
    /// If the recording has fewer blocks, or the buffers are another sweep's.
    pub fn measure(&self, first: usize, blocks: &mut [Vec<EchoBlock>]) {
        assert!(first + blocks.len() <= self.blocks(), "no such blocks");
        let scratch = || Scratch {
            signal: self.recorded.bank.scratch(),
            noises: self
                .noises
                .iter()
                .map(|_| self.recorded.bank.scratch())
                .collect(),
            clean: vec![0.0; self.recorded.bank.block_length()],
        };
        blocks
            .par_iter_mut()
            .with_max_len(2)
            .enumerate()
            .for_each_init(scratch, |scratch, (offset, noisy)| {
                self.measure_block(first + offset, scratch, noisy)
            });
    }

    /// Measures one block under all noises.
    fn measure_block(&self, index: usize, scratch: &mut Scratch, noisy: &mut [EchoBlock]) {
        let (recorded, bank) = (&self.recorded, &self.recorded.bank);
        let Scratch {
            signal,
            noises,
            clean,
        } = scratch;
        recorded.clean_block(&recorded.signal, &self.direct_waves, index, clean);
        bank.prepare(clean, signal);
        for ((noise, direct_waves), scratch) in self
            .noises
            .iter()
            .zip(&self.noise_direct_waves)
            .zip(&mut *noises)
        {
            recorded.clean_block(&noise.samples, direct_waves, index, clean);
            bank.prepare(clean, scratch);
        }
        for block in &mut *noisy {
            block.set_motion(self.parameters, index, recorded.odometry_of(index));
        }
        let v_mps = noisy.first().map_or(0.0, |block| block.odometry.v_mps);
        for pair in DopplerBank::pairs(self.parameters.measurement.directions) {
            bank.correlate(pair, v_mps, signal);
            let mut blocks = noisy.iter_mut();
            for (noise, scratch) in self.noises.iter().zip(&mut *noises) {
                bank.correlate(pair, v_mps, scratch);
                for (&level, block) in noise.levels.iter().zip(&mut blocks) {
                    bank.store_sum(pair, signal, scratch, level, &mut block.intensity);
                }
            }
        }
        for block in noisy {
            block.set_toa(self.parameters.measurement.toa_image);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::echo::measure;
    use crate::odometry::OdometrySample;
    use crate::parameters::{DirectWave, MeasurementParameters};
    use crate::recording::RecordingMeta;

    /// Two noises of several levels, against the sums measured one by one, for every way of removing the direct wave.
    #[test]
    fn noisy_echoes_are_those_of_the_sums() {
        for direct_wave in [
            DirectWave::Keep,
            DirectWave::RunningMean,
            DirectWave::GatedMean,
            DirectWave::FreeField,
        ] {
            let parameters = Parameters {
                measurement: MeasurementParameters {
                    periods: 2,
                    directions: 4,
                    direct_wave,
                    range_pool_m: 0.01,
                    ..MeasurementParameters::default()
                },
                ..Parameters::default()
            };
            let length = 5 * parameters.samples_per_period();
            let wave = |a: f32| -> Vec<f32> {
                (0..length)
                    .map(|k| (k as f32 * a).sin() + (((k * k) % 8191) as f32 * 0.7).cos())
                    .collect()
            };
            let signal = wave(0.31);
            let noises = [
                AddedNoise {
                    samples: wave(1.13),
                    levels: vec![0.0, 0.4, 3.0],
                },
                AddedNoise {
                    samples: wave(0.83),
                    levels: vec![0.9],
                },
            ];
            let mut recording = Recording {
                unheard: Vec::new(),
                signal: signal.clone(),
                direct: Some(wave(0.31)),
                odometry: [0.0, 1.0]
                    .map(|t_s| OdometrySample {
                        t_s,
                        v_mps: 0.3 + 0.1 * t_s,
                        omega_radps: 0.1,
                    })
                    .to_vec(),
                truth: None,
                meta: RecordingMeta::from_parameters(&parameters),
            };
            let noisy: Vec<Vec<EchoBlock>> = {
                let echoes = NoiseSweep::new(&recording, &noises, &parameters).expect("valid");
                assert_eq!(echoes.blocks(), 4);
                // In two parts, the buffers of the first used again.
                let mut buffers = echoes.buffers(3);
                echoes.measure(0, &mut buffers);
                let mut all = buffers.clone();
                echoes.measure(3, &mut buffers[..1]);
                all.push(buffers.swap_remove(0));
                all
            };
            let drives = noises
                .iter()
                .flat_map(|noise| noise.levels.iter().map(move |&level| (noise, level)));
            for (recorded, (noise, level)) in drives.enumerate() {
                for ((sum, signal), noise) in
                    recording.signal.iter_mut().zip(&signal).zip(&noise.samples)
                {
                    *sum = signal + level * noise;
                }
                let plain = measure(&recording, &parameters).expect("valid");
                assert_eq!(plain.blocks.len(), noisy.len());
                for (fast, plain) in noisy
                    .iter()
                    .map(|block| &block[recorded])
                    .zip(&plain.blocks)
                {
                    let largest = plain.intensity.iter().fold(0.0_f32, |a, &b| a.max(b));
                    let both = |fast: f32, plain: f32| {
                        assert!(
                            (fast - plain).abs() < 3e-6 * (largest + 1.0),
                            "{fast} is not {plain} at {level}"
                        );
                    };
                    for (&fast, &plain) in fast.intensity.iter().zip(&plain.intensity) {
                        both(fast, plain);
                    }
                    for (&fast, &plain) in fast.toa_intensity.iter().zip(&plain.toa_intensity) {
                        both(fast, plain);
                    }
                    assert_eq!((fast.t_s, fast.odometry), (plain.t_s, plain.odometry));
                    assert_eq!(
                        (fast.index, fast.stationary),
                        (plain.index, plain.stationary)
                    );
                }
            }
            let short = [AddedNoise {
                samples: vec![0.0; length - 1],
                levels: vec![1.0],
            }];
            assert!(NoiseSweep::new(&recording, &short, &parameters).is_err());
        }
    }
}
