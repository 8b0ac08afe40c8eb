//! The transmitted signal: an M-sequence that phase-modulates a carrier.

use std::f64::consts::TAU;

use crate::parameters::{Parameters, SignalParameters};

/// Feedback taps of a maximal-length shift register for every order from 2 to 18.
const TAPS: [&[u32]; 17] = [
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
];

/// One period of an M-sequence of 2^order - 1 chips of +1 and -1, starting from the register of all ones.
///
/// Empty for an order outside 2 to 18.
///
/// ```
/// use localizer::signal::waveform::m_sequence;
///
/// assert_eq!(m_sequence(3), [1, 1, 1, -1, -1, 1, -1]);
/// ```
pub fn m_sequence(order: u32) -> Vec<i8> {
    let Some(taps) = order
        .checked_sub(2)
        .and_then(|index| TAPS.get(index as usize))
    else {
        return Vec::new();
    };
    let length = (1_usize << order) - 1;
    let mut register = (1_u32 << order) - 1;
    (0..length)
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

/// One period of what the loudspeaker repeats: the recording's own waveform, else the code's.
pub fn transmitted(parameters: &Parameters) -> Vec<f64> {
    match &parameters.transmitted {
        Some(period) => period.iter().map(|&sample| f64::from(sample)).collect(),
        None => transmit_period(&parameters.signal),
    }
}

/// One period of s(k): L_s = L T_c f_s samples at f_s, the carrier's sine times the chip.
///
/// Both chips and carrier start at sample 0, so a signal that repeats this slice is periodic in L T_c whenever the
/// carrier makes a whole number of cycles in it. Empty for a code length that is no 2^n - 1 with n from 2 to 18.
///
/// ```
/// use localizer::parameters::SignalParameters;
/// use localizer::signal::waveform::transmit_period;
///
/// let signal = SignalParameters::default();
/// assert_eq!(transmit_period(&signal).len(), signal.samples_per_period());
/// ```
pub fn transmit_period(signal: &SignalParameters) -> Vec<f64> {
    let code = signal.code_order().map(m_sequence).unwrap_or_default();
    if code.is_empty() {
        return Vec::new();
    }
    let length = signal.samples_per_period();
    (0..length)
        .map(|k| {
            // Rounding guards the chip boundary against 3.9999999.
            let chip =
                (k as f64 * signal.chip_rate_hz / signal.sample_rate_hz + 1e-9).floor() as usize;
            let phase = (k as f64 * signal.carrier_hz / signal.sample_rate_hz).fract();
            f64::from(code[chip % code.len()]) * (TAU * phase).sin()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_is_balanced_and_has_a_two_valued_autocorrelation() {
        for order in 2..=11 {
            let code: Vec<i64> = m_sequence(order).into_iter().map(i64::from).collect();
            assert_eq!(code.len(), (1 << order) - 1);
            assert_eq!(
                code.iter().sum::<i64>(),
                1,
                "order {order}: one more +1 than -1"
            );
            for shift in 1..code.len() {
                let sum: i64 = (0..code.len())
                    .map(|k| code[k] * code[(k + shift) % code.len()])
                    .sum();
                assert_eq!(sum, -1, "order {order}, shift {shift}");
            }
        }
    }

    #[test]
    fn long_orders_have_the_full_period() {
        // Balance holds for the full period only; a shorter cycle would repeat a state and break it.
        for order in 12..=18 {
            let code = m_sequence(order);
            assert_eq!(
                code.iter().map(|&chip| i64::from(chip)).sum::<i64>(),
                1,
                "order {order}"
            );
            let lag: i64 = (0..code.len())
                .map(|k| i64::from(code[k] * code[(k + 77) % code.len()]))
                .sum();
            assert_eq!(lag, -1, "order {order}");
        }
    }

    #[test]
    fn shift_and_add_gives_a_shifted_copy() {
        let code = m_sequence(10);
        let length = code.len();
        // With +1 and -1 the modulo-2 sum is the negated product.
        for shift in [1, 5, 100, 511] {
            let sum: Vec<i8> = (0..length)
                .map(|k| -code[k] * code[(k + shift) % length])
                .collect();
            let copies = (0..length)
                .filter(|&lag| (0..length).all(|k| sum[k] == code[(k + lag) % length]))
                .count();
            assert_eq!(copies, 1, "shift {shift}");
        }
    }

    #[test]
    fn orders_outside_the_table_give_nothing() {
        assert!(m_sequence(0).is_empty() && m_sequence(1).is_empty() && m_sequence(19).is_empty());
        let order_of = |code_length| {
            let signal = SignalParameters {
                code_length,
                ..SignalParameters::default()
            };
            signal.code_order()
        };
        assert_eq!(order_of(1023), Some(10));
        assert_eq!(order_of(1024), None);
        // The orders that parameters may have are those of the table.
        for order in 1..=19 {
            let code = m_sequence(order);
            let has_code = order_of((1 << order) - 1) == Some(order);
            assert_eq!(has_code, !code.is_empty(), "order {order}");
        }
    }

    #[test]
    fn a_period_is_chips_times_carrier() {
        for order in [6, 9, 10, 11] {
            let code = m_sequence(order);
            let parameters = SignalParameters {
                code_length: code.len(),
                ..SignalParameters::default()
            };
            let period = transmit_period(&parameters);
            assert_eq!(period.len(), 4 * code.len());
            for (chip, samples) in code.iter().zip(period.chunks(4)) {
                let chip = f64::from(*chip);
                for (sample, carrier) in samples.iter().zip([0.0, 1.0, 0.0, -1.0]) {
                    assert!((sample - chip * carrier).abs() < 1e-12);
                }
            }
        }
    }
}
