//! Echoes of a whole recording: H of every block, measured once and shared by maps and filters.

use ndarray::{Array2, ArrayView2, aview1};

use crate::echo::doppler_bank::DopplerBank;
use crate::echo::recording_blocks::map_blocks;
use crate::error::Error;
use crate::odometry::{Odometry, mean_over_periods};
use crate::parameters::{Method, Parameters, ToaImage};
use crate::pose::Pose;
use crate::recording::Recording;
use crate::trajectory::Trajectory;

/// The echoes of one block of M periods.
#[derive(Debug, Clone, PartialEq)]
pub struct EchoBlock {
    /// Number of the block; it starts with this period of the recording.
    pub index: usize,
    /// Instant to which the echoes and the pose refer, in seconds.
    pub t_s: f64,
    /// Mean odometry over the block.
    pub odometry: Odometry,
    /// True if the robot is too slow for bearings, or the sound has a gap: the block is neither matched nor mapped.
    pub stationary: bool,
    /// H of eqs. (1)-(3): `[direction, delay in samples]`, 1 for an echo of amplitude 1.
    pub intensity: Array2<f32>,
    /// Intensity that stands for all directions in the range-only method, see [`ToaImage`].
    pub toa_intensity: Vec<f32>,
}

/// The echoes of one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct EchoSequence {
    /// The parameters with which they were measured.
    pub parameters: Parameters,
    /// One block per period, from the one that starts at time 0.
    pub blocks: Vec<EchoBlock>,
    /// Mean odometry of every period.
    pub odometry: Vec<Odometry>,
}

impl EchoBlock {
    /// A block before its measurement.
    pub(crate) fn empty(bank: &DopplerBank) -> Self {
        let intensity = bank.intensity();
        Self {
            index: 0,
            t_s: 0.0,
            odometry: Odometry::default(),
            stationary: true,
            toa_intensity: vec![0.0; intensity.ncols()],
            intensity,
        }
    }

    /// Sets index, time and mean odometry from the block's index and the odometry of its M periods.
    pub(crate) fn set_motion(
        &mut self,
        parameters: &Parameters,
        index: usize,
        odometry: &[Odometry],
    ) {
        self.index = index;
        self.t_s =
            (index as f64 + parameters.measurement.reference_periods()) * parameters.period_s();
        self.odometry = mean_over_periods(odometry, 0.0, parameters.measurement.periods as f64);
        self.stationary = self.odometry.v_mps.abs() < parameters.measurement.min_speed_mps;
    }

    /// Combines the intensity of all directions into `toa_intensity`.
    pub(crate) fn set_toa(&mut self, image: ToaImage) {
        self.toa_intensity.fill(0.0);
        let scale = 1.0 / self.intensity.nrows() as f32;
        for row in self.intensity.rows() {
            for (toa, value) in self.toa_intensity.iter_mut().zip(row) {
                match image {
                    ToaImage::Mean => *toa += scale * value,
                    ToaImage::Strongest => *toa = toa.max(*value),
                }
            }
        }
    }

    /// The intensity `[direction, delay]` that a method uses: all directions, or one row that stands for all.
    pub fn polar(&self, method: Method) -> ArrayView2<'_, f32> {
        match method {
            Method::ToaOnly => aview1(&self.toa_intensity).insert_axis(ndarray::Axis(0)),
            Method::Doppler | Method::Odometry => self.intensity.view(),
        }
    }
}

impl EchoSequence {
    /// The poses of a trajectory at the blocks' instants. Empty for an empty trajectory.
    pub fn poses(&self, trajectory: &Trajectory) -> Vec<Pose> {
        trajectory.poses_at(self.blocks.iter().map(|block| block.t_s))
    }

    /// The odometry that a filter needs for a block: that of its M periods, preceded by the period before if there is
    /// one.
    pub fn recent_odometry(&self, block: usize) -> &[Odometry] {
        let end = (block + self.parameters.measurement.periods).min(self.odometry.len());
        &self.odometry[block.saturating_sub(1).min(end)..end]
    }
}

/// Measures the echoes of every block of a recording, in parallel over the blocks, with the same result as one by one.
///
/// # Errors
/// [`Error::Invalid`] when the parameters cannot be used, the recording has another waveform, rate or speed of sound
/// than they say (see [`Parameters::for_recording`]), is shorter than M periods, does not pass [`Recording::check`],
/// or has no `direct.wav` although `direct_wave` is free-field.
pub fn measure(recording: &Recording, parameters: &Parameters) -> Result<EchoSequence, Error> {
    let (blocks, odometry) = map_blocks(
        recording,
        parameters,
        DopplerBank::scratch,
        |bank, scratch, index, samples, odometry| {
            let mut block = EchoBlock::empty(bank);
            block.set_motion(parameters, index, odometry);
            let own = index..index + parameters.measurement.periods;
            let next = recording.unheard.partition_point(|&period| period < index);
            block.stationary |= recording
                .unheard
                .get(next)
                .is_some_and(|period| own.contains(period));
            bank.measure(samples, block.odometry.v_mps, scratch, &mut block.intensity);
            block.set_toa(parameters.measurement.toa_image);
            block
        },
    )?;
    Ok(EchoSequence {
        parameters: parameters.clone(),
        blocks,
        odometry,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::MeasurementParameters;

    #[test]
    fn a_range_only_image_is_the_mean_or_the_strongest_of_the_directions() {
        let parameters = Parameters {
            measurement: MeasurementParameters {
                directions: 3,
                ..MeasurementParameters::default()
            },
            ..Parameters::default()
        };
        let bank = DopplerBank::new(&parameters).expect("valid parameters");
        let mut block = EchoBlock::empty(&bank);
        for (direction, value) in [1.0, 3.0, 0.0, 4.0].into_iter().enumerate() {
            block.intensity[[direction, 7]] = value;
        }
        block.set_toa(ToaImage::Strongest);
        assert_eq!(block.toa_intensity[7], 4.0);
        block.set_toa(ToaImage::Mean);
        assert_eq!(block.toa_intensity[7], 2.0);
        assert_eq!(block.toa_intensity[8], 0.0);
    }
}
