//! Removal of the direct wave: the sound that reaches the microphone without a wall, and the coupling of loudspeaker
//! and microphone.
//!
//! The direct wave does not depend on the pose, so it repeats from period to period, while the delays of echoes
//! change. The mean over many periods is therefore the direct wave, plus the echoes whose delay did not change. The
//! mean is exponential and causal; all M periods of a block are freed from the newest mean.

use std::f64::consts::PI;
use std::sync::Arc;

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use crate::error::Error;
use crate::parameters::{DirectWave, Parameters};
use crate::signal::waveform;

/// Running estimate of one period of the direct wave.
pub struct DirectWaveEstimate {
    mean: Vec<f32>,
    /// Weight of the past after one period: exp(-T / time constant).
    memory: f64,
    /// memory to the power of the periods so far, for the bias correction at the start.
    forgotten: f64,
    gate: Option<Gate>,
    removes: bool,
}

/// Limits a periodic signal to the part that an impulse response shorter than `min_range_m` makes of the transmitted
/// one.
struct Gate {
    forward: Arc<dyn Fft<f32>>,
    inverse: Arc<dyn Fft<f32>>,
    replica: Vec<Complex<f32>>,
    /// Regularized 1 / S per line.
    deconvolution: Vec<Complex<f32>>,
    /// Weight per delay, 1 at zero, 0 from `min_range_m` on, the same for negative delays.
    weights: Vec<f32>,
    spectrum: Vec<Complex<f32>>,
    work: Vec<Complex<f32>>,
}

impl DirectWaveEstimate {
    /// An estimate before the first period. `parameters` must pass [`Parameters::check`].
    pub fn new(parameters: &Parameters) -> Self {
        let gated = parameters.measurement.direct_wave == DirectWave::GatedMean;
        Self {
            mean: vec![0.0; parameters.samples_per_period()],
            memory: (-parameters.period_s() / parameters.measurement.direct_wave_time_s).exp(),
            forgotten: 1.0,
            gate: gated.then(|| Gate::new(parameters)),
            removes: gated || parameters.measurement.direct_wave == DirectWave::RunningMean,
        }
    }

    /// Takes one more received period into the average.
    pub fn push(&mut self, period: &[f32]) {
        if !self.removes {
            return;
        }
        self.forgotten *= self.memory;
        // An arithmetic mean at first, an exponential one in the long run.
        let gain = ((1.0 - self.memory) / (1.0 - self.forgotten)) as f32;
        for (mean, sample) in self.mean.iter_mut().zip(period) {
            *mean += gain * (sample - *mean);
        }
    }

    /// Writes the current estimate of one period; zero if none is to be removed.
    pub fn write(&mut self, period: &mut [f32]) {
        period.copy_from_slice(&self.mean);
        if let Some(gate) = &mut self.gate {
            gate.apply(period);
        }
    }
}

impl Gate {
    fn new(parameters: &Parameters) -> Self {
        let transmitted = waveform::transmitted(parameters);
        let length = transmitted.len();
        let mut spectrum: Vec<Complex<f64>> = transmitted
            .iter()
            .map(|&sample| Complex::new(sample, 0.0))
            .collect();
        FftPlanner::new()
            .plan_fft_forward(length)
            .process(&mut spectrum);
        let mean_power = spectrum.iter().map(Complex::norm_sqr).sum::<f64>() / length as f64;
        let reach = parameters
            .signal
            .delay_of_range(parameters.measurement.min_range_m)
            .max(1) as f64;
        let mut planner = FftPlanner::<f32>::new();
        let forward = planner.plan_fft_forward(length);
        let inverse = planner.plan_fft_inverse(length);
        let zero = Complex::new(0.0, 0.0);
        let work = forward
            .get_inplace_scratch_len()
            .max(inverse.get_inplace_scratch_len());
        let narrow = |value: Complex<f64>| Complex::new(value.re as f32, value.im as f32);
        Self {
            replica: spectrum.iter().map(|&line| narrow(line)).collect(),
            deconvolution: spectrum
                .iter()
                .map(|line| {
                    narrow(line.conj() / ((line.norm_sqr() + 1e-4 * mean_power) * length as f64))
                })
                .collect(),
            weights: (0..length)
                .map(|k| {
                    let delay = k.min(length - k) as f64 / reach;
                    // Flat over the first half, then a raised cosine.
                    (0.5 + 0.5 * (PI * (2.0 * delay - 1.0).clamp(0.0, 1.0)).cos()) as f32
                })
                .collect(),
            spectrum: vec![zero; length],
            work: vec![zero; work],
            forward,
            inverse,
        }
    }

    fn apply(&mut self, period: &mut [f32]) {
        for (line, &sample) in self.spectrum.iter_mut().zip(period.iter()) {
            *line = Complex::new(sample, 0.0);
        }
        self.forward
            .process_with_scratch(&mut self.spectrum, &mut self.work);
        for (line, weight) in self.spectrum.iter_mut().zip(&self.deconvolution) {
            *line *= weight;
        }
        self.inverse
            .process_with_scratch(&mut self.spectrum, &mut self.work);
        for (value, weight) in self.spectrum.iter_mut().zip(&self.weights) {
            *value *= weight;
        }
        self.forward
            .process_with_scratch(&mut self.spectrum, &mut self.work);
        let scale = 1.0 / period.len() as f32;
        for (line, weight) in self.spectrum.iter_mut().zip(&self.replica) {
            *line *= weight * scale;
        }
        self.inverse
            .process_with_scratch(&mut self.spectrum, &mut self.work);
        for (sample, value) in period.iter_mut().zip(&self.spectrum) {
            *sample = value.re;
        }
    }
}

/// Subtracts a periodic signal, given by one period, from a block.
pub(crate) fn subtract_period(received: &[f32], direct: &[f32], block: &mut [f32]) {
    for (block, received) in block
        .chunks_mut(direct.len())
        .zip(received.chunks(direct.len()))
    {
        for ((block, received), direct) in block.iter_mut().zip(received).zip(direct) {
            *block = received - direct;
        }
    }
}

/// The signal minus the direct wave of a recording without walls.
///
/// # Errors
/// [`Error::Invalid`] when there is no such recording or it has another length.
pub fn subtract_free_field(signal: &[f32], direct: Option<&[f32]>) -> Result<Vec<f32>, Error> {
    let remedy = "record the same drive without walls, or choose another direct_wave";
    let Some(direct) = direct else {
        return Err(Error::invalid(
            "recording",
            "direct.wav",
            "is missing, but direct_wave is free-field",
            remedy,
        ));
    };
    if direct.len() != signal.len() {
        let problem = format!(
            "has {} samples, signal.wav has {}",
            direct.len(),
            signal.len()
        );
        return Err(Error::invalid("recording", "direct.wav", problem, remedy));
    }
    Ok(signal
        .iter()
        .zip(direct)
        .map(|(signal, direct)| signal - direct)
        .collect())
}

/// Refuses a removal of the direct wave that needs a second recording, and so cannot stream.
pub(crate) fn check_streaming(parameters: &Parameters) -> Result<(), Error> {
    if parameters.measurement.direct_wave != DirectWave::FreeField {
        return Ok(());
    }
    let remedy = "subtract the free field from the samples and choose keep, or choose running-mean";
    Err(Error::invalid(
        "parameters",
        "direct_wave",
        "free-field cannot stream",
        remedy,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::MeasurementParameters;
    use crate::signal::waveform::transmit_period;

    fn parameters(direct_wave: DirectWave) -> Parameters {
        Parameters {
            measurement: MeasurementParameters {
                direct_wave,
                ..MeasurementParameters::default()
            },
            ..Parameters::default()
        }
    }

    #[test]
    fn the_mean_of_equal_periods_is_the_period_from_the_start() {
        let parameters = parameters(DirectWave::RunningMean);
        let period: Vec<f32> = transmit_period(&parameters.signal)
            .iter()
            .map(|&sample| sample as f32)
            .collect();
        let mut estimate = DirectWaveEstimate::new(&parameters);
        let mut mean = vec![0.0; period.len()];
        for _ in 0..3 {
            estimate.push(&period);
            estimate.write(&mut mean);
            assert!(
                mean.iter()
                    .zip(&period)
                    .all(|(mean, sample)| (mean - sample).abs() < 1e-6)
            );
        }
    }

    #[test]
    fn the_gate_passes_the_direct_wave_and_stops_a_far_echo() {
        let parameters = parameters(DirectWave::GatedMean);
        let period: Vec<f32> = transmit_period(&parameters.signal)
            .iter()
            .map(|&sample| sample as f32)
            .collect();
        let far: Vec<f32> = (0..period.len())
            .map(|k| period[(k + period.len() - 400) % period.len()])
            .collect();
        let power = |signal: &[f32]| signal.iter().map(|sample| sample * sample).sum::<f32>();
        let mut estimate = DirectWaveEstimate::new(&parameters);
        let mut mean = vec![0.0; period.len()];
        estimate.push(&period);
        estimate.write(&mut mean);
        let rest: Vec<f32> = mean
            .iter()
            .zip(&period)
            .map(|(mean, sample)| mean - sample)
            .collect();
        assert!(
            power(&rest) < 1e-3 * power(&period),
            "{}",
            power(&rest) / power(&period)
        );
        let mut estimate = DirectWaveEstimate::new(&parameters);
        estimate.push(&far);
        estimate.write(&mut mean);
        assert!(
            power(&mean) < 1e-3 * power(&period),
            "{}",
            power(&mean) / power(&period)
        );
    }

    #[test]
    fn the_free_field_must_fit() {
        assert!(
            subtract_free_field(&[1.0, 2.0], Some(&[0.5, 0.5]))
                .is_ok_and(|rest| rest == [0.5, 1.5])
        );
        assert!(subtract_free_field(&[1.0], None).is_err());
        assert!(subtract_free_field(&[1.0], Some(&[])).is_err());
    }
}
