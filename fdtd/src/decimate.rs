//! From the field's rate to the sampling rate of the microphone, without aliasing and without delay.

use crate::bessel::i0;
use crate::error::Error;
use std::f64::consts::PI;

/// Attenuation in decibels that the Kaiser window is designed for; ripple in the band is as small.
const ATTENUATION_DB: f64 = 95.0;
/// Most positions of an output sample between two input samples that get weights of their own. A ratio of rates that
/// needs more is served by the nearest one, which moves a sample by 1/32768 of an input step at most: -90 dB at the
/// edge of a band of a sixth of the field's rate.
const MAX_PHASES: usize = 16_384;

/// A low-pass filter and the places where its output is taken: output `k` is at time `k / sample_rate_hz`, as input `n`
/// is at `n / field_rate_hz`.
#[derive(Debug, Clone)]
pub struct Decimator {
    /// Input samples per output sample.
    ratio: f64,
    /// Taps of each phase, first tap at input `floor(k ratio) - reach + 1`; one phase after the other.
    taps: Vec<f64>,
    taps_per_phase: usize,
    phases: usize,
    /// Phases in turn (output `k` has phase `k % phases`) rather than by nearest position.
    in_turn: bool,
}

impl Decimator {
    /// A filter that keeps frequencies up to `band_hz` within 0.01 dB and takes those from `sample_rate_hz - band_hz`
    /// on, which would fall into the band, below -80 dB.
    ///
    /// # Errors
    /// [`Error::Invalid`] for rates that are not positive and finite, a sampling rate above the field's rate, or a band
    /// that leaves no room below half the sampling rate (at least 1 % of it).
    pub fn new(field_rate_hz: f64, sample_rate_hz: f64, band_hz: f64) -> Result<Self, Error> {
        check(field_rate_hz, sample_rate_hz, band_hz)?;
        let nearest_whole = (field_rate_hz / sample_rate_hz).round();
        let ratio = field_rate_hz / sample_rate_hz;
        // A step such as 8.333e-6 s written with all digits means exactly 3 field samples per sample.
        let ratio = if (ratio - nearest_whole).abs() < 1e-12 * ratio {
            nearest_whole
        } else {
            ratio
        };
        if ratio == 1.0 {
            return Ok(Self {
                ratio,
                taps: vec![1.0, 0.0],
                taps_per_phase: 2,
                phases: 1,
                in_turn: true,
            });
        }
        let whole_after = |outputs: usize| {
            let inputs = outputs as f64 * ratio;
            (inputs - inputs.round()).abs() <= 1e-12 * inputs
        };
        let in_turn = (1..=MAX_PHASES).find(|&outputs| whole_after(outputs));
        let phases = in_turn.unwrap_or(MAX_PHASES);
        let kernel = Kernel::new(field_rate_hz, sample_rate_hz, band_hz);
        let reach = kernel.half_width.ceil() as usize + 1;
        let mut taps = Vec::with_capacity(phases * 2 * reach);
        for phase in 0..phases {
            let fraction = match in_turn {
                Some(_) => offset_in_turn(phase, ratio, phases),
                None => phase as f64 / phases as f64,
            };
            let first = taps.len();
            taps.extend(
                (0..2 * reach).map(|tap| kernel.value(fraction + reach as f64 - 1.0 - tap as f64)),
            );
            // A constant comes out as that constant whatever the phase.
            let sum: f64 = taps[first..].iter().sum();
            taps[first..].iter_mut().for_each(|tap| *tap /= sum);
        }
        Ok(Self {
            ratio,
            taps,
            taps_per_phase: 2 * reach,
            phases,
            in_turn: in_turn.is_some(),
        })
    }

    /// Number of output samples for `count` input samples: those at times of the input.
    pub fn output_len(&self, count: usize) -> usize {
        match count {
            0 => 0,
            _ => ((count - 1) as f64 / self.ratio * (1.0 + 1e-12)).floor() as usize + 1,
        }
    }

    /// How many input samples before and after an output sample it depends on.
    pub fn reach(&self) -> usize {
        self.taps_per_phase / 2
    }

    /// The filtered signal; samples beyond the input's ends count as zero.
    pub fn apply(&self, field: &[f32]) -> Vec<f32> {
        (0..self.output_len(field.len()))
            .map(|k| self.output(field, k))
            .collect()
    }

    fn output(&self, field: &[f32], k: usize) -> f32 {
        let (whole, phase) = self.place(k);
        let taps = &self.taps[phase * self.taps_per_phase..(phase + 1) * self.taps_per_phase];
        let reach = self.reach();
        // Input index of tap i is whole + 1 + i - reach.
        let skip = (reach - 1).saturating_sub(whole);
        let start = (whole + 1 + skip).saturating_sub(reach).min(field.len());
        let sum: f64 = taps[skip..]
            .iter()
            .zip(&field[start..])
            .map(|(tap, &value)| tap * f64::from(value))
            .sum();
        sum as f32
    }

    /// Input sample at or before output `k`, and the phase of the remainder.
    fn place(&self, k: usize) -> (usize, usize) {
        if self.in_turn {
            let phase = k % self.phases;
            let inputs_per_round = (self.phases as f64 * self.ratio).round() as usize;
            let within = (phase as f64 * self.ratio
                - offset_in_turn(phase, self.ratio, self.phases))
            .round() as usize;
            return (k / self.phases * inputs_per_round + within, phase);
        }
        let place = k as f64 * self.ratio;
        let phase = (place.fract() * self.phases as f64).round() as usize;
        (
            place.floor() as usize + phase / self.phases,
            phase % self.phases,
        )
    }
}

/// [`Decimator::new`] and [`Decimator::apply`] in one: the signal at `sample_rate_hz`, sample `k` at time
/// `k / sample_rate_hz`.
///
/// # Errors
/// As [`Decimator::new`].
pub fn decimate(
    field: &[f32],
    field_rate_hz: f64,
    sample_rate_hz: f64,
    band_hz: f64,
) -> Result<Vec<f32>, Error> {
    Ok(Decimator::new(field_rate_hz, sample_rate_hz, band_hz)?.apply(field))
}

/// Position of output `phase` after the input sample at or before it, in input samples: a multiple of `1 / phases`.
fn offset_in_turn(phase: usize, ratio: f64, phases: usize) -> f64 {
    let inputs_per_round = (phases as f64 * ratio).round() as usize;
    (phase * inputs_per_round % phases) as f64 / phases as f64
}

/// Kaiser-windowed sinc; its argument is in input samples.
struct Kernel {
    /// Cut-off in cycles per input sample.
    cutoff: f64,
    half_width: f64,
    beta: f64,
}

impl Kernel {
    fn new(field_rate_hz: f64, sample_rate_hz: f64, band_hz: f64) -> Self {
        // From the band's edge to its alias, half of it on either side of half the sampling rate.
        let transition = 2.0 * PI * (sample_rate_hz - 2.0 * band_hz) / field_rate_hz;
        Self {
            cutoff: 0.5 * sample_rate_hz / field_rate_hz,
            half_width: 0.5 * (ATTENUATION_DB - 7.95) / (2.285 * transition),
            beta: 0.1102 * (ATTENUATION_DB - 8.7),
        }
    }

    fn value(&self, x: f64) -> f64 {
        let edge = x / self.half_width;
        if edge.abs() >= 1.0 {
            return 0.0;
        }
        let argument = 2.0 * PI * self.cutoff * x;
        let sinc = if argument == 0.0 {
            1.0
        } else {
            argument.sin() / argument
        };
        sinc * i0(self.beta * (1.0 - edge * edge).sqrt())
    }
}

fn check(field_rate_hz: f64, sample_rate_hz: f64, band_hz: f64) -> Result<(), Error> {
    let refuse = |field: &str, problem: String, remedy: String| {
        Err(Error::invalid("decimation", field, problem, remedy))
    };
    if !(field_rate_hz.is_finite() && field_rate_hz > 0.0) {
        return refuse(
            "field_rate_hz",
            format!("{field_rate_hz} is not a rate"),
            "give a positive number".into(),
        );
    }
    if !(sample_rate_hz > 0.0 && sample_rate_hz <= field_rate_hz * (1.0 + 1e-12)) {
        return refuse(
            "sample_rate_hz",
            format!("{sample_rate_hz} Hz cannot be taken from a field at {field_rate_hz} Hz"),
            format!("give a rate above 0 and up to {field_rate_hz} Hz"),
        );
    }
    let highest_hz = 0.495 * sample_rate_hz;
    if !(band_hz > 0.0 && band_hz <= highest_hz) {
        return refuse(
            "band_hz",
            format!("a band to {band_hz} Hz does not fit below half of {sample_rate_hz} Hz"),
            format!("end it at {highest_hz} Hz or lower, or sample faster"),
        );
    }
    Ok(())
}
