//! The streaming localizer: one period of samples in, one pose out.

use crate::echo::block_buffer::BlockBuffer;
use crate::echo::doppler_bank::{DopplerBank, DopplerScratch};
use crate::echo::echo_blocks::EchoBlock;
use crate::error::Error;
use crate::filter::tracker::{Estimate, Tracker};
use crate::image::map_image::MapImage;
use crate::odometry::Odometry;
use crate::parameters::Parameters;
use crate::pose::Pose;
use crate::signal::direct_wave;

/// Follows a robot in a known map, period by period.
///
/// ```
/// use std::path::Path;
///
/// use localizer::image::map_builder;
/// use localizer::{Localizer, Parameters, Recording, echo};
///
/// let mapping = Recording::read(Path::new("../examples/site_robot/mapping"))?;
/// let parameters = Parameters::default().for_recording(&mapping.meta);
/// let echoes = echo::measure(&mapping, &parameters)?;
/// let truth = mapping.truth.as_ref().ok_or("no truth.tum")?;
/// let map = map_builder::build(&[(&echoes, &echoes.poses(truth))])?;
///
/// let drive = Recording::read(Path::new("../examples/site_robot/drive"))?;
/// let mut localizer = Localizer::new(&parameters, map, drive.start_pose(), 1)?;
/// let period = parameters.samples_per_period();
/// let odometry = drive.odometry_per_period(parameters.period_s(), 10);
/// for (samples, &odometry) in drive.signal.chunks_exact(period).zip(&odometry) {
///     if let Some(estimate) = localizer.step(samples, odometry)? {
///         println!("{:.2} s: {:?}", estimate.t_s, estimate.pose);
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Localizer {
    parameters: Parameters,
    buffer: BlockBuffer,
    bank: DopplerBank,
    scratch: DopplerScratch,
    block: EchoBlock,
    tracker: Tracker,
    map: MapImage,
}

impl Localizer {
    /// A localizer for a robot that stands at `start` at time 0.
    ///
    /// # Errors
    /// [`Error::Invalid`] for parameters that cannot be used, a map with other cells, a start that is not finite, or
    /// `direct_wave` free-field, which needs a second recording and so cannot stream.
    pub fn new(
        parameters: &Parameters,
        map: MapImage,
        start: Pose,
        seed: u64,
    ) -> Result<Self, Error> {
        let bank = DopplerBank::new(parameters)?;
        map.check(parameters)?;
        direct_wave::check_streaming(parameters)?;
        Ok(Self {
            buffer: BlockBuffer::new(parameters),
            scratch: bank.scratch(),
            block: EchoBlock::empty(&bank),
            tracker: Tracker::new(parameters, start, seed)?,
            bank,
            map,
            parameters: parameters.clone(),
        })
    }

    /// One step: takes in one period of samples and the mean odometry during it.
    ///
    /// Returns `None` until M periods have come in, then one estimate a step.
    ///
    /// # Errors
    /// [`Error::Invalid`] for another number of samples than one period, samples or speeds that are not finite, or a
    /// speed above a tenth of that of sound. The step then has not taken place.
    pub fn step(&mut self, samples: &[f32], odometry: Odometry) -> Result<Option<Estimate>, Error> {
        self.step_period(samples, true, odometry)
    }

    /// As [`Self::step`]; with `heard` false the samples are a gap of the sound: the estimate follows from odometry
    /// alone until M whole periods have come in again.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn step_period(
        &mut self,
        samples: &[f32],
        heard: bool,
        odometry: Odometry,
    ) -> Result<Option<Estimate>, Error> {
        // Section II-A: a block of the last M periods, one period later than the previous one.
        self.buffer.push_period(samples, heard, odometry)?;
        let (index, deaf) = (self.buffer.block_index(), self.buffer.is_deaf());
        let Some((received, recent)) = self.buffer.block() else {
            return Ok(None);
        };
        // Eqs. (1)-(3): resample for every direction, add up the periods, correlate, take the envelope.
        self.block.set_motion(
            &self.parameters,
            index,
            &recent[recent.len() - self.parameters.measurement.periods..],
        );
        self.block.stationary |= deaf;
        self.bank.measure(
            received,
            self.block.odometry.v_mps,
            &mut self.scratch,
            &mut self.block.intensity,
        );
        self.block.set_toa(self.parameters.measurement.toa_image);
        // Eqs. (8)-(18): move the particles, weigh them by the map, take their mean, draw the next ones.
        Ok(Some(self.tracker.update(&self.block, recent, &self.map)))
    }

    /// The echoes of the newest block.
    pub fn echoes(&self) -> &EchoBlock {
        &self.block
    }

    /// The particles and the map behind the estimates.
    pub fn tracker(&self) -> &Tracker {
        &self.tracker
    }

    /// The map.
    pub fn map(&self) -> &MapImage {
        &self.map
    }
}
