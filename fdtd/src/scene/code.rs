//! The signal of a scene's loudspeaker: an M-sequence that phase-modulates a carrier, within the band.

use std::f64::consts::TAU;

use super::model::{Scene, WaveformSpec};
use crate::error::Error;
use crate::waveform::PeriodicWaveform;

/// Feedback taps of a maximal-length shift register for every order from 2 to 20.
const TAPS: [&[u32]; 19] = [
    &[2, 1],
    &[3, 2],
    &[4, 3],
    &[5, 3],
    &[6, 5],
    &[7, 6],
    &[8, 6, 5, 4],
    &[9, 5],
    &[10, 7],
    &[11, 9],
    &[12, 6, 4, 1],
    &[13, 4, 3, 1],
    &[14, 5, 3, 1],
    &[15, 14],
    &[16, 15, 13, 4],
    &[17, 14],
    &[18, 11],
    &[19, 18, 17, 14],
    &[20, 17],
];

impl Scene {
    /// Source strength over time, relative to [`crate::simulation::SOURCE_STRENGTH_M2PS`]: the scene's code sampled at
    /// its sample rate, within its band, tabulated for the time step of its field.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the code length is no 2^n - 1 with n from 2 to 20.
    ///
    /// ```
    /// use fdtd::scene::Scene;
    ///
    /// let text = r#"{ "name": "open air", "grid": { "nx": 300, "ny": 200, "dx_m": 0.005, "dt_s": 8e-6 } }"#;
    /// let scene = Scene::from_json(text, "open.json".as_ref())?;
    /// let waveform = scene.source_waveform()?;
    /// assert!((waveform.period_s() - scene.waveform.period_s()).abs() < 1e-12);
    /// # Ok::<(), fdtd::Error>(())
    /// ```
    pub fn source_waveform(&self) -> Result<PeriodicWaveform, Error> {
        let samples = self.waveform.one_period(self.sample_rate_hz);
        if samples.is_empty() {
            return Err(Error::invalid(
                format!("scene '{}'", self.name),
                "waveform.code_length",
                format!("no M-sequence has {} chips", self.waveform.code_length),
                "give 2^n - 1 chips with n from 2 to 20, for example 1023",
            ));
        }
        Ok(PeriodicWaveform::with_band(
            &samples,
            samples.len() as f64 / self.sample_rate_hz,
            self.waveform.band_hz,
            1.0 / self.grid.dt_s,
        ))
    }
}

impl WaveformSpec {
    /// Order n of the M-sequence of 2^n - 1 chips; `None` unless n is 2 to 20.
    pub fn code_order(&self) -> Option<u32> {
        (2..)
            .zip(TAPS)
            .map(|(order, _)| order)
            .find(|&order| (1 << order) - 1 == self.code_length)
    }

    /// One period of the signal at a sample rate, before the band's limits: the carrier's sine times the chip, both
    /// starting at sample 0. Empty when the code length is no 2^n - 1 with n from 2 to 20.
    pub fn one_period(&self, sample_rate_hz: f64) -> Vec<f64> {
        let Some(code) = self.code_order().map(m_sequence) else {
            return Vec::new();
        };
        let length = (self.period_s() * sample_rate_hz).round() as usize;
        (0..length)
            .map(|k| {
                // Rounding guards the chip boundary against 3.9999999.
                let chip = (k as f64 * self.chip_rate_hz / sample_rate_hz + 1e-9).floor() as usize;
                let phase = (k as f64 * self.carrier_hz / sample_rate_hz).fract();
                f64::from(code[chip % code.len()]) * (TAU * phase).sin()
            })
            .collect()
    }
}

/// One period of the M-sequence of 2^order - 1 chips of +1 and -1, starting from the register of all ones.
fn m_sequence(order: u32) -> Vec<i8> {
    let taps = TAPS[order as usize - 2];
    let mut register = (1_u32 << order) - 1;
    (0..register)
        .map(|_| {
            let chip = if register & 1 == 1 { 1 } else { -1 };
            // Tap p of the register is its p-th stage from the input; the output leaves at stage `order`, bit 0.
            let feedback = taps
                .iter()
                .fold(0, |bit, &tap| bit ^ (register >> (order - tap)) & 1);
            register = (register >> 1) | (feedback << (order - 1));
            chip
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_has_a_two_valued_autocorrelation() {
        // Over a shorter cycle than the full period the sum of the chips, or of the products, would be another.
        for order in (2..).take(TAPS.len()) {
            let code = m_sequence(order);
            let length = code.len();
            assert_eq!(length, (1 << order) - 1);
            assert_eq!(
                code.iter().map(|&chip| i64::from(chip)).sum::<i64>(),
                1,
                "order {order}"
            );
            let shifts = if order <= 10 { 1..length } else { 77..78 };
            for shift in shifts {
                let product = |k: usize| i64::from(code[k] * code[(k + shift) % length]);
                assert_eq!(
                    (0..length).map(product).sum::<i64>(),
                    -1,
                    "order {order}, shift {shift}"
                );
            }
        }
    }

    #[test]
    fn lengths_that_are_no_code_are_refused() {
        for code_length in [0, 1, 2, 1022, 1024, (1 << 21) - 1, u32::MAX] {
            let waveform = WaveformSpec {
                code_length,
                ..WaveformSpec::default()
            };
            assert_eq!(waveform.code_order(), None, "{code_length}");
            assert!(waveform.one_period(40e3).is_empty());
        }
        let twenty = WaveformSpec {
            code_length: (1 << 20) - 1,
            ..WaveformSpec::default()
        };
        assert_eq!(twenty.code_order(), Some(20));
    }
}
