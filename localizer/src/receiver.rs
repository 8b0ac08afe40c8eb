//! From periods of samples to blocks of M periods, one block per period: the front end of the streaming localizer.

use crate::direct_wave::DirectWaveEstimate;
use crate::error::Error;
use crate::parameters::Parameters;
use crate::pose::Odometry;

/// The last M periods of the received signal and the odometry that goes with them.
pub struct Receiver {
    period: usize,
    periods: usize,
    fastest_mps: f64,
    direct: DirectWaveEstimate,
    direct_period: Vec<f32>,
    /// The last M periods as received, oldest first.
    received: Vec<f32>,
    /// The same less the direct wave.
    block: Vec<f32>,
    /// One mean per period: the last M + 1 of them, oldest first.
    odometry: Vec<Odometry>,
    count: usize,
}

impl Receiver {
    /// A receiver that has heard nothing yet. `parameters` are checked ones.
    pub fn new(parameters: &Parameters) -> Self {
        let (period, periods) = (parameters.samples_per_period(), parameters.periods);
        Self {
            period,
            periods,
            fastest_mps: 0.1 * parameters.speed_of_sound_mps,
            direct: DirectWaveEstimate::new(parameters),
            direct_period: vec![0.0; period],
            received: vec![0.0; period * periods],
            block: vec![0.0; period * periods],
            odometry: Vec::with_capacity(periods + 2),
            count: 0,
        }
    }

    /// Takes in one period of samples and the mean odometry during it.
    ///
    /// # Errors
    /// [`Error::Invalid`] for another number of samples than L_s, a sample that is not finite, or an impossible speed.
    /// The receiver is then unchanged.
    pub fn push(&mut self, samples: &[f32], odometry: Odometry) -> Result<(), Error> {
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
        check_odometry("step", "odometry", odometry, self.fastest_mps)?;
        self.received.copy_within(self.period.., 0);
        let start = self.received.len() - self.period;
        self.received[start..].copy_from_slice(samples);
        self.direct.push(samples);
        if self.odometry.len() > self.periods {
            self.odometry.remove(0);
        }
        self.odometry.push(odometry);
        self.count += 1;
        Ok(())
    }

    /// The newest block without its direct wave, once M periods have come in, and the odometry of its M periods, preceded
    /// by that of the period before if there is one.
    pub fn block(&mut self) -> Option<(&[f32], &[Odometry])> {
        if self.count < self.periods {
            return None;
        }
        self.direct.write(&mut self.direct_period);
        remove_direct(&self.received, &self.direct_period, &mut self.block);
        Some((&self.block, &self.odometry))
    }

    /// Number of the newest block, 0 for the one that starts at time 0.
    pub fn block_index(&self) -> usize {
        self.count.saturating_sub(self.periods)
    }
}

/// A block less a periodic signal.
pub(crate) fn remove_direct(received: &[f32], direct: &[f32], block: &mut [f32]) {
    for (block, received) in block
        .chunks_mut(direct.len())
        .zip(received.chunks(direct.len()))
    {
        for ((block, received), direct) in block.iter_mut().zip(received).zip(direct) {
            *block = received - direct;
        }
    }
}

/// Refuses speeds that are not finite or not small against the speed of sound.
pub(crate) fn check_odometry(
    origin: impl std::fmt::Display,
    field: impl std::fmt::Display,
    odometry: Odometry,
    fastest_mps: f64,
) -> Result<(), Error> {
    if odometry.v_mps.abs() <= fastest_mps && odometry.omega_radps.is_finite() {
        return Ok(());
    }
    let problem = format!(
        "v {} m/s and omega {} rad/s cannot be used",
        odometry.v_mps, odometry.omega_radps
    );
    let remedy = format!("give finite speeds, v within {fastest_mps} m/s");
    Err(Error::invalid(origin, field, problem, remedy))
}

/// Mean odometry between two instants given in periods from the start of `odometry[0]`, each entry lasting one period.
///
/// Beyond the ends the first and last entry continue. An empty slice is a robot at rest.
pub fn mean_odometry(odometry: &[Odometry], from_periods: f64, to_periods: f64) -> Odometry {
    let Some(last) = odometry.len().checked_sub(1) else {
        return Odometry::default();
    };
    let length = to_periods - from_periods;
    if length <= 0.0 {
        return odometry[(from_periods.max(0.0) as usize).min(last)];
    }
    let mut mean = Odometry::default();
    let mut start = from_periods;
    while start < to_periods {
        let end = (start.floor() + 1.0).min(to_periods);
        let entry = odometry[(start.floor().max(0.0) as usize).min(last)];
        let share = (end - start) / length;
        mean.v_mps += share * entry.v_mps;
        mean.omega_radps += share * entry.omega_radps;
        start = end;
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_take_shares_of_periods() {
        let entry = |v_mps: f64| Odometry {
            v_mps,
            omega_radps: -v_mps,
        };
        let odometry = [entry(1.0), entry(2.0), entry(4.0)];
        assert_eq!(mean_odometry(&odometry, 1.0, 2.0), entry(2.0));
        assert_eq!(mean_odometry(&odometry, 0.5, 1.5), entry(1.5));
        assert_eq!(mean_odometry(&odometry, 2.5, 4.5), entry(4.0));
        assert_eq!(mean_odometry(&[], 0.0, 1.0), entry(0.0));
    }

    #[test]
    fn a_block_comes_with_the_last_of_its_periods_and_bad_input_changes_nothing() {
        let parameters = Parameters {
            periods: 2,
            ..Parameters::default()
        };
        let mut receiver = Receiver::new(&parameters);
        let period = vec![0.5; 4092];
        assert!(receiver.push(&period[1..], Odometry::default()).is_err());
        assert!(
            receiver
                .push(&vec![f32::NAN; 4092], Odometry::default())
                .is_err()
        );
        assert!(
            receiver
                .push(
                    &period,
                    Odometry {
                        v_mps: 100.0,
                        omega_radps: 0.0
                    }
                )
                .is_err()
        );
        assert!(receiver.push(&period, Odometry::default()).is_ok());
        assert!(receiver.block().is_none());
        assert!(receiver.push(&period, Odometry::default()).is_ok());
        assert!(
            receiver.block().is_some_and(
                |(block, _)| block.len() == 8184 && block.iter().all(|&s| s.abs() < 1e-6)
            )
        );
        assert_eq!(receiver.block_index(), 0);
    }
}
