//! Resampling of particles by their weights: systematic (one comb of equal steps over the cumulated weights) or
//! multinomial (independent draws).

/// Writes the parents of `parents.len()` new particles, in increasing order.
///
/// `weights` add up to 1; `offset` in [0, 1) places the comb. Each particle is drawn as often as its weight times the
/// number of new particles, rounded up or down, and exactly that often on average over the offset.
///
/// ```
/// use localizer::filter::resampling::systematic;
///
/// let mut parents = [0; 4];
/// systematic(&[0.5, 0.0, 0.25, 0.25], 0.5, &mut parents);
/// assert_eq!(parents, [0, 0, 2, 3]);
/// ```
pub fn systematic(weights: &[f64], offset: f64, parents: &mut [usize]) {
    let step = 1.0 / parents.len().max(1) as f64;
    let last = weights.len().saturating_sub(1);
    let mut cumulated = weights.first().copied().unwrap_or(1.0);
    let mut parent = 0;
    for (index, slot) in parents.iter_mut().enumerate() {
        let tooth = (index as f64 + offset) * step;
        // The sum may end a rounding error below 1; the last particle then takes the last tooth.
        while tooth >= cumulated && parent < last {
            parent += 1;
            cumulated += weights[parent];
        }
        *slot = parent;
    }
}

/// Writes the parents of `parents.len()` new particles, each drawn independently with the probability of its weight.
///
/// `weights` add up to 1; `draw` gives numbers in [0, 1).
pub fn multinomial(weights: &[f64], mut draw: impl FnMut() -> f64, parents: &mut [usize]) {
    let last = weights.len().saturating_sub(1);
    for slot in parents {
        let mut left = draw();
        let taken = weights.iter().position(|weight| {
            left -= weight;
            left < 0.0
        });
        // The sum may end a rounding error below 1.
        *slot = taken.unwrap_or(last);
    }
}

/// Effective sample size 1 / sum w^2 of weights that add up to 1.
pub fn effective_sample_size(weights: &[f64]) -> f64 {
    1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(weights: &[f64], offset: f64, size: usize) -> Vec<usize> {
        let mut parents = vec![0; size];
        systematic(weights, offset, &mut parents);
        (0..weights.len())
            .map(|k| parents.iter().filter(|&&parent| parent == k).count())
            .collect()
    }

    #[test]
    fn counts_are_the_expected_ones_rounded_up_or_down() {
        let weights = [0.07, 0.0, 0.313, 0.217, 0.4];
        for step in 0..100 {
            for (count, weight) in counts(&weights, f64::from(step) / 100.0, 50)
                .iter()
                .zip(&weights)
            {
                let expected: f64 = 50.0 * weight;
                assert!((expected.floor() as usize..=expected.ceil() as usize).contains(count));
            }
        }
    }

    #[test]
    fn counts_are_right_on_average() {
        let weights = [0.07, 0.013, 0.3, 0.217, 0.4];
        let offsets = 10_000;
        let mut sums = [0; 5];
        for step in 0..offsets {
            let counts = counts(&weights, f64::from(step) / f64::from(offsets), 10);
            sums.iter_mut()
                .zip(counts)
                .for_each(|(sum, count)| *sum += count);
        }
        for (sum, weight) in sums.iter().zip(weights) {
            assert!((*sum as f64 / f64::from(offsets) - 10.0 * weight).abs() < 1e-3);
        }
    }

    #[test]
    fn multinomial_draws_are_independent_and_right_on_average() {
        let weights = [0.07, 0.013, 0.3, 0.217, 0.4];
        let mut random = crate::random::stream(1, "multinomial");
        let (rounds, size) = (20_000, 10);
        let (mut sums, mut squares) = ([0.0; 5], [0.0; 5]);
        let mut parents = vec![0; size];
        for _ in 0..rounds {
            multinomial(&weights, || rand::RngExt::random(&mut random), &mut parents);
            for parent in 0..weights.len() {
                let count = parents.iter().filter(|&&drawn| drawn == parent).count() as f64;
                sums[parent] += count;
                squares[parent] += count * count;
            }
        }
        for ((sum, square), weight) in sums.iter().zip(squares).zip(weights) {
            let mean = sum / f64::from(rounds);
            let variance = square / f64::from(rounds) - mean * mean;
            let binomial = size as f64 * weight * (1.0 - weight);
            // Five standard errors of the mean; the variance, unlike that of the comb, is the binomial one.
            assert!((mean - 10.0 * weight).abs() < 5.0 * (binomial / f64::from(rounds)).sqrt());
            assert!(
                (variance / binomial - 1.0).abs() < 0.1,
                "{variance} {binomial}"
            );
        }
        multinomial(&weights[..1], || 0.999, &mut parents);
        assert_eq!(parents, [0; 10]);
    }

    #[test]
    fn equal_weights_keep_every_particle_and_one_weight_takes_all() {
        assert_eq!(counts(&[0.25; 4], 0.5, 4), [1; 4]);
        assert_eq!(counts(&[0.0, 1.0, 0.0], 0.999, 7), [0, 7, 0]);
        assert!((effective_sample_size(&[0.25; 4]) - 4.0).abs() < 1e-12);
        systematic(&[], 0.5, &mut []);
    }
}
