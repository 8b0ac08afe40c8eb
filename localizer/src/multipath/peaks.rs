//! Peaks of the impulse response that an M-sequence measures (2021, process (iii)).

use std::ops::Range;

/// Median of the magnitude of complex Gaussian noise over its standard deviation per component: `sqrt(2 ln 2)`.
const RAYLEIGH_MEDIAN: f64 = 1.177_410_022_515_474_7;

/// Conditions on a peak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Picking {
    /// Lowest level over the noise level of the impulse response (see [`noise_level`]).
    pub threshold: f64,
    /// A peak is the largest value within this many samples to both sides; one chip keeps the code's own flanks out.
    pub separation: usize,
    /// Most peaks of one impulse response; the strongest stay.
    pub most: usize,
}

/// A peak of the envelope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Delay in samples, with fraction.
    pub delay: f64,
    /// Level in the unit of the envelope.
    pub level: f64,
}

/// Standard deviation per component of the noise under an impulse response, from the median of its whole envelope:
/// echoes fill less than half of a period, so the median is one of noise. 0 for an empty envelope.
pub fn noise_level(envelope: &[f32]) -> f64 {
    let mut sorted = envelope.to_vec();
    let middle = sorted.len() / 2;
    if sorted.is_empty() {
        return 0.0;
    }
    let (_, median, _) = sorted.select_nth_unstable_by(middle, f32::total_cmp);
    f64::from(*median) / RAYLEIGH_MEDIAN
}

/// Peaks of an envelope at delays in `window`, in the order of their delays.
pub fn pick(envelope: &[f32], window: Range<usize>, picking: &Picking) -> Vec<Peak> {
    let least = picking.threshold * noise_level(envelope);
    let end = window.end.min(envelope.len().saturating_sub(1));
    let mut peaks: Vec<Peak> = (window.start.max(1)..end)
        .filter(|&k| f64::from(envelope[k]) >= least && tops(envelope, k, picking.separation))
        .map(|k| parabola(envelope, k))
        .collect();
    peaks.sort_by(|a, b| b.level.total_cmp(&a.level));
    peaks.truncate(picking.most);
    peaks.sort_by(|a, b| a.delay.total_cmp(&b.delay));
    peaks
}

/// Whether sample `k` is above its neighbours within `reach`; of equal ones the first counts.
fn tops(envelope: &[f32], k: usize, reach: usize) -> bool {
    let reach = reach.max(1);
    let before = &envelope[k.saturating_sub(reach)..k];
    let after = &envelope[k + 1..(k + 1 + reach).min(envelope.len())];
    before.iter().all(|&value| value < envelope[k])
        && after.iter().all(|&value| value <= envelope[k])
}

/// Top of the parabola through sample `k` and its two neighbours.
fn parabola(envelope: &[f32], k: usize) -> Peak {
    let [left, top, right] = [k - 1, k, k + 1].map(|index| f64::from(envelope[index]));
    let bend = left - 2.0 * top + right;
    let shift = if bend < 0.0 {
        (0.5 * (left - right) / bend).clamp(-0.5, 0.5)
    } else {
        0.0
    };
    Peak {
        delay: k as f64 + shift,
        level: top - 0.25 * (left - right) * shift,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand_distr::{Distribution, StandardNormal};

    const PICKING: Picking = Picking {
        threshold: 4.0,
        separation: 4,
        most: 9,
    };

    /// Domain: bells of half width 4 samples at known places, 30 samples apart, in Rayleigh noise 40 dB below the
    /// least; tolerance 0.2 sample (a parabola on a Gaussian of this width errs by 0.02, the noise under the weakest
    /// by 0.05 rms).
    #[test]
    fn known_echoes_in_noise_are_found_between_the_samples() {
        let echoes = [(40.3, 1.0), (71.8, 0.4), (160.5, 0.2), (300.1, 0.6)];
        let mut random = crate::random::stream(7, "noise");
        let envelope: Vec<f32> = (0..1000)
            .map(|k| {
                let clean: f64 = echoes
                    .iter()
                    .map(|(place, level)| level * (-(f64::from(k) - place).powi(2) / 12.0).exp())
                    .sum();
                let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                let noise = [0.002 * normal(), 0.002 * normal()];
                (clean + noise[0]).hypot(noise[1]) as f32
            })
            .collect();
        assert!((noise_level(&envelope) / 0.002 - 1.0).abs() < 0.2);
        let picking = Picking {
            threshold: 8.0,
            ..PICKING
        };
        let found = pick(&envelope, 10..900, &picking);
        assert_eq!(found.len(), 4, "{found:?}");
        for (peak, (place, level)) in found.iter().zip(echoes) {
            assert!((peak.delay - place).abs() < 0.2, "{peak:?} {place}");
            assert!((peak.level - level).abs() < 0.02 * level + 0.005);
        }
        let strongest = Picking { most: 2, ..picking };
        let delays: Vec<f64> = pick(&envelope, 10..900, &strongest)
            .iter()
            .map(|peak| peak.delay.round())
            .collect();
        assert_eq!(delays, [40.0, 300.0]);
        assert_eq!(pick(&envelope, 60..200, &picking).len(), 2);
    }

    #[test]
    fn silence_and_nothing_have_no_peaks() {
        assert!(pick(&[], 0..10, &PICKING).is_empty());
        assert!(pick(&[1.0], 0..10, &PICKING).is_empty());
        assert_eq!(noise_level(&[]), 0.0);
    }

    proptest! {
        /// The plain words: above the threshold, strictly above all before and not below any after within the
        /// separation.
        #[test]
        fn the_same_peaks_as_by_the_plain_words(
            levels in prop::collection::vec(0_u8..40, 3..80), separation in 1_usize..6, threshold in 0.5..3.0_f64
        ) {
            let envelope: Vec<f32> = levels.iter().map(|&level| f32::from(level)).collect();
            let picking = Picking { threshold, separation, most: usize::MAX };
            let mut sorted = levels.clone();
            sorted.sort_unstable();
            let least = threshold * f64::from(sorted[sorted.len() / 2]) / (2.0 * 2_f64.ln()).sqrt();
            let last = levels.len() - 1;
            let expected: Vec<usize> = levels
                .iter()
                .enumerate()
                .filter(|&(k, &level)| {
                    let lower = |(other, &value): (usize, &u8)| {
                        other == k
                            || other.abs_diff(k) > separation
                            || value < level
                            || (other > k && value == level)
                    };
                    k > 0 && k < last && f64::from(level) >= least && levels.iter().enumerate().all(lower)
                })
                .map(|(k, _)| k)
                .collect();
            let found: Vec<f64> = pick(&envelope, 0..levels.len(), &picking).iter().map(|peak| peak.delay).collect();
            prop_assert_eq!(found.len(), expected.len());
            for (delay, k) in found.iter().zip(expected) {
                prop_assert!((delay - k as f64).abs() <= 0.5);
            }
        }
    }
}
