//! Blocks of the last M periods of a stream of samples, one block per period (section II-A).

use crate::error::Error;
use crate::odometry::{Odometry, check_speeds};
use crate::parameters::Parameters;
use crate::signal::direct_wave::{self, DirectWaveEstimate};

/// The last M periods of the received signal and the odometry that goes with them.
pub struct BlockBuffer {
    period: usize,
    periods: usize,
    fastest_mps: f64,
    direct: DirectWaveEstimate,
    direct_period: Vec<f32>,
    /// The last M periods as received, oldest first.
    received: Vec<f32>,
    /// `received` less the direct wave.
    block: Vec<f32>,
    /// One mean per period: the last M + 1 of them, oldest first.
    odometry: Vec<Odometry>,
    count: usize,
    /// Periods since the last that was not heard.
    since_deaf: usize,
}

impl BlockBuffer {
    /// An empty buffer. `parameters` must pass [`Parameters::check`].
    pub fn new(parameters: &Parameters) -> Self {
        let (period, periods) = (
            parameters.samples_per_period(),
            parameters.measurement.periods,
        );
        Self {
            period,
            periods,
            fastest_mps: 0.1 * parameters.signal.speed_of_sound_mps,
            direct: DirectWaveEstimate::new(parameters),
            direct_period: vec![0.0; period],
            received: vec![0.0; period * periods],
            block: vec![0.0; period * periods],
            odometry: Vec::with_capacity(periods + 2),
            count: 0,
            since_deaf: periods,
        }
    }

    /// Appends one period of samples and the mean odometry during it.
    ///
    /// # Errors
    /// [`Error::Invalid`] for another number of samples than L_s, a sample that is not finite, or a speed that is not
    /// finite or above a tenth of that of sound. The buffer is then unchanged.
    pub fn push(&mut self, samples: &[f32], odometry: Odometry) -> Result<(), Error> {
        self.push_period(samples, true, odometry)
    }

    /// As [`Self::push`]; with `heard` false the samples are no sound of this drive (a gap): they do not count for the
    /// direct wave, and blocks with them are [deaf](Self::is_deaf).
    ///
    /// # Errors
    /// As [`Self::push`].
    pub fn push_period(
        &mut self,
        samples: &[f32],
        heard: bool,
        odometry: Odometry,
    ) -> Result<(), Error> {
        if samples.len() != self.period {
            let problem = format!("{} samples were given", samples.len());
            return Err(Error::invalid(
                "step",
                "samples",
                problem,
                format!("give one period of {}", self.period),
            ));
        }
        if let Some(place) = samples.iter().position(|sample| !sample.is_finite()) {
            let problem = format!("sample {place} of period {} is not finite", self.count);
            return Err(Error::invalid(
                "step",
                "samples",
                problem,
                "give finite samples",
            ));
        }
        check_speeds("step", "odometry", odometry, self.fastest_mps)?;
        self.received.copy_within(self.period.., 0);
        let start = self.received.len() - self.period;
        self.received[start..].copy_from_slice(samples);
        if heard {
            self.direct.push(samples);
            self.since_deaf += 1;
        } else {
            self.since_deaf = 0;
        }
        if self.odometry.len() > self.periods {
            self.odometry.remove(0);
        }
        self.odometry.push(odometry);
        self.count += 1;
        Ok(())
    }

    /// The newest block without its direct wave, and the odometry of its M periods, preceded by that of the period
    /// before if there is one. `None` before M periods have been appended.
    pub fn block(&mut self) -> Option<(&[f32], &[Odometry])> {
        if self.count < self.periods {
            return None;
        }
        self.direct.write(&mut self.direct_period);
        direct_wave::subtract_period(&self.received, &self.direct_period, &mut self.block);
        Some((&self.block, &self.odometry))
    }

    /// Whether a period of the newest block was not heard.
    pub fn is_deaf(&self) -> bool {
        self.since_deaf < self.periods
    }

    /// Index of the newest block, 0 for the one that starts at time 0.
    pub fn block_index(&self) -> usize {
        self.count.saturating_sub(self.periods)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::MeasurementParameters;

    #[test]
    fn a_block_comes_with_the_last_of_its_periods_and_bad_input_changes_nothing() {
        let parameters = Parameters {
            measurement: MeasurementParameters {
                periods: 2,
                ..MeasurementParameters::default()
            },
            ..Parameters::default()
        };
        let mut buffer = BlockBuffer::new(&parameters);
        let period = vec![0.5; 4092];
        assert!(buffer.push(&period[1..], Odometry::default()).is_err());
        assert!(
            buffer
                .push(&vec![f32::NAN; 4092], Odometry::default())
                .is_err()
        );
        assert!(
            buffer
                .push(
                    &period,
                    Odometry {
                        v_mps: 100.0,
                        omega_radps: 0.0
                    }
                )
                .is_err()
        );
        assert!(buffer.push(&period, Odometry::default()).is_ok());
        assert!(buffer.block().is_none());
        assert!(buffer.push(&period, Odometry::default()).is_ok());
        assert!(
            buffer.block().is_some_and(
                |(block, _)| block.len() == 8184 && block.iter().all(|&s| s.abs() < 1e-6)
            )
        );
        assert_eq!(buffer.block_index(), 0);
    }
}
