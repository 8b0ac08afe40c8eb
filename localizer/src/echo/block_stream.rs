//! Echoes of a sound that comes period by period: blocks are measured in parallel, a few at a time, so that memory does
//! not grow with the drive.

use rayon::prelude::*;

use super::block_buffer::BlockBuffer;
use super::doppler_bank::{DopplerBank, DopplerScratch};
use super::echo_blocks::EchoBlock;
use crate::error::Error;
use crate::odometry::Odometry;
use crate::parameters::Parameters;

/// Blocks that are measured together.
const BATCH: usize = 16;

/// One period of samples and whether the direct wave was heard in it; none at the end.
pub type NextPeriod<'a> = dyn FnMut() -> Result<Option<(Vec<f32>, bool)>, Error> + 'a;

/// Takes a block and the odometry that a filter needs; returns whether it wants more.
pub type EachBlock<'a> = dyn FnMut(&EchoBlock, &[Odometry]) -> Result<bool, Error> + 'a;

/// A block that waits for its measurement.
struct Waiting {
    samples: Vec<f32>,
    recent: Vec<Odometry>,
    block: EchoBlock,
    scratch: DopplerScratch,
}

/// Measures every block of a sound as [`crate::echo::measure`] does and hands it on, in order, with the odometry that a
/// filter needs ([`crate::EchoSequence::recent_odometry`]). `odometry` gives the mean of a period by its number.
/// `each` returns whether it wants more.
///
/// # Errors
/// Those of `next`, `each`, and of [`crate::Localizer::step`].
pub fn measure_each(
    parameters: &Parameters,
    next: &mut NextPeriod<'_>,
    odometry: &dyn Fn(usize) -> Odometry,
    each: &mut EachBlock<'_>,
) -> Result<(), Error> {
    parameters.check()?;
    parameters.check_memory_of_echoes(BATCH)?;
    let bank = DopplerBank::new(parameters)?;
    let mut buffer = BlockBuffer::new(parameters);
    let mut waiting: Vec<Waiting> = Vec::new();
    let (mut filled, mut period) = (0, 0);
    loop {
        let came = next()?;
        if let Some((samples, heard)) = &came {
            buffer.push_period(samples, *heard, odometry(period))?;
            period += 1;
            let (index, deaf) = (buffer.block_index(), buffer.is_deaf());
            if let Some((block, recent)) = buffer.block() {
                if filled == waiting.len() {
                    waiting.push(Waiting {
                        samples: vec![0.0; bank.block_length()],
                        recent: Vec::new(),
                        block: EchoBlock::empty(&bank),
                        scratch: bank.scratch(),
                    });
                }
                let place = &mut waiting[filled];
                place.samples.copy_from_slice(block);
                place.recent.clear();
                place.recent.extend_from_slice(recent);
                let own = &recent[recent.len() - parameters.measurement.periods..];
                place.block.set_motion(parameters, index, own);
                place.block.stationary |= deaf;
                filled += 1;
            }
        }
        if filled == BATCH || (came.is_none() && filled > 0) {
            waiting[..filled]
                .par_iter_mut()
                .with_max_len(1)
                .for_each(|place| {
                    let v_mps = place.block.odometry.v_mps;
                    let intensity = &mut place.block.intensity;
                    bank.measure(&place.samples, v_mps, &mut place.scratch, intensity);
                    place.block.set_toa(parameters.measurement.toa_image);
                });
            for place in &waiting[..filled] {
                if !each(&place.block, &place.recent)? {
                    return Ok(());
                }
            }
            filled = 0;
        }
        if came.is_none() {
            return Ok(());
        }
    }
}
