//! Mutual information of two quantized images, eqs. (9)-(14).
//!
//! With counts n of N pixels, eq. (9) is exactly
//! `(sum n ln n (joint) - sum n ln n (first) - sum n ln n (second)) / N + ln N`. The terms n ln n come from a table of
//! fixed-point numbers, so that sums are exact: they do not depend on the order, and can be updated when single pixels
//! change.

use crate::simd::vectorized;

/// Independent copies of the counts of one image, so that a run of equal pixels does not serialize.
const LANES: usize = 4;

/// Mutual information of images of a fixed number of pixels and bins; nothing is allocated after [`Self::new`].
///
/// ```
/// use localizer::likelihood::mutual_information::MutualInformation;
///
/// let image = [0, 0, 1, 1];
/// let mut measure = MutualInformation::new(1, image.len());
/// let marginal = measure.marginal(&image);
/// assert!((measure.information(&image, &image, marginal) - 2_f64.ln()).abs() < 1e-12);
/// assert_eq!(measure.information(&[0, 1, 0, 1], &image, marginal), 0.0);
/// ```
#[derive(Debug, Clone)]
pub struct MutualInformation {
    /// Binary digits of one bin number.
    digits: u32,
    pixels: usize,
    /// Counts of the pair, row by row; one entry for every `u16`, so that no index needs a check.
    joint: Box<[u32; 1 << 16]>,
    /// Counts of the first image.
    single: [u32; 256],
    /// Sum of n ln n over the joint counts.
    joint_sum: Fixed,
    n_ln_n: Logarithms,
}

/// A sum of n ln n in the units of [`Logarithms`].
type Fixed = i64;

/// n ln n as fixed-point numbers, as fine as the largest possible sum permits.
#[derive(Debug, Clone)]
struct Logarithms {
    /// One unit is 2 to the power of minus this.
    binary_places: i32,
    values: Vec<Fixed>,
    /// Increase of n ln n from n to n + 1.
    steps: Vec<Fixed>,
}

impl Logarithms {
    /// For counts up to `most`.
    fn new(most: usize) -> Self {
        let n_ln_n = |n: usize| n as f64 * (n.max(1) as f64).ln();
        let binary_places = 62 - n_ln_n(most).max(1.0).log2().ceil() as i32;
        let values: Vec<Fixed> = (0..=most + 1)
            .map(|n| (n_ln_n(n) * 2.0_f64.powi(binary_places)).round() as Fixed)
            .collect();
        Self {
            binary_places,
            steps: values.windows(2).map(|pair| pair[1] - pair[0]).collect(),
            values,
        }
    }

    /// Sum over counts of bins.
    fn sum(&self, counts: &[u32]) -> Fixed {
        counts.iter().map(|&n| self.values[n as usize]).sum()
    }

    /// The value of a sum.
    fn number(&self, sum: Fixed) -> f64 {
        sum as f64 * 2.0_f64.powi(-self.binary_places)
    }
}

impl MutualInformation {
    /// A measure for images of `pixels` pixels with bin numbers 0 to `bins` (at most 255).
    pub fn new(bins: usize, pixels: usize) -> Self {
        Self {
            digits: (bins.min(255) + 1).next_power_of_two().ilog2(),
            pixels,
            joint: Box::new([0; 1 << 16]),
            single: [0; 256],
            joint_sum: 0,
            n_ln_n: Logarithms::new(pixels),
        }
    }

    /// Sum of n ln n over the bins of one image, in fixed-point units; its entropy is `ln N` minus this sum over N.
    pub fn marginal(&self, image: &[u8]) -> i64 {
        let mut lanes = [[0_u32; 256]; LANES];
        let (chunks, rest) = image.as_chunks::<LANES>();
        for chunk in chunks {
            for (lane, &bin) in lanes.iter_mut().zip(chunk) {
                lane[usize::from(bin)] += 1;
            }
        }
        for &bin in rest {
            lanes[0][usize::from(bin)] += 1;
        }
        let mut counts = [0; 256];
        for lane in &lanes {
            counts.iter_mut().zip(lane).for_each(|(sum, n)| *sum += n);
        }
        self.n_ln_n.sum(&counts)
    }

    /// Mutual information in nats of two images; `second_sum` is the [`Self::marginal`] of the second.
    ///
    /// Both images have the number of pixels given to [`Self::new`] and no bin above `bins`.
    pub fn information(&mut self, first: &[u8], second: &[u8], second_sum: i64) -> f64 {
        self.count(first, second);
        self.value(second_sum)
    }

    /// Eq. (9) of the pair counted last; `second_sum` as for [`Self::information`].
    pub(crate) fn value(&self, second_sum: i64) -> f64 {
        if self.pixels == 0 {
            return 0.0;
        }
        let total = self.pixels as f64;
        let first_sum = self.n_ln_n.sum(&self.single[..1 << self.digits]);
        let sum = self.n_ln_n.number(self.joint_sum - first_sum - second_sum);
        // Rounding may leave a small negative number.
        (sum / total + total.ln()).max(0.0)
    }

    /// Counts a pair.
    fn count(&mut self, first: &[u8], second: &[u8]) {
        let (digits, width) = (self.digits, 1 << self.digits);
        // Rows of bins that the previous first image did not have are zero already.
        let rows = self.joint.chunks_exact_mut(width).take(width);
        for (row, _) in rows.zip(&self.single).filter(|(_, n)| **n > 0) {
            row.fill(0);
        }
        let mut sum = 0;
        for (&a, &b) in first.iter().zip(second) {
            let count = &mut self.joint[usize::from((u16::from(a) << digits) | u16::from(b))];
            sum += self.n_ln_n.steps[*count as usize];
            *count += 1;
        }
        self.joint_sum = sum;
        let rows = self.joint.chunks_exact(width).take(width);
        vectorized(|| {
            for (single, row) in self.single.iter_mut().zip(rows) {
                *single = row.iter().sum();
            }
        });
    }

    /// Updates the counts for pixels whose bins in the first image changed from `old` to `new`; `second` are their
    /// bins in the second image.
    pub(crate) fn change(&mut self, old: &[u8], new: &[u8], second: &[u8]) {
        let digits = self.digits;
        let place =
            |first: u8, second: u8| usize::from((u16::from(first) << digits) | u16::from(second));
        let steps = self.n_ln_n.steps.as_slice();
        // A local sum stays in a register, so that changes do not wait for memory.
        let mut sum = self.joint_sum;
        for ((&old, &new), &second) in old.iter().zip(new).zip(second) {
            if old == new {
                continue;
            }
            let from = &mut self.joint[place(old, second)];
            *from -= 1;
            sum -= steps[*from as usize];
            let to = &mut self.joint[place(new, second)];
            sum += steps[*to as usize];
            *to += 1;
            self.single[usize::from(old)] -= 1;
            self.single[usize::from(new)] += 1;
        }
        self.joint_sum = sum;
    }
}

/// Bin numbers floor(K value / max) of an image of non-negative values, eqs. (13) and (14); all zero for an image of
/// zeros.
pub fn quantize(image: &[f32], bins: usize, quantized: &mut [u8]) {
    let largest = largest_of(image);
    if largest <= 0.0 {
        return quantized.fill(0);
    }
    quantize_by(largest, image, bins, quantized);
}

/// [`quantize`] with a given positive maximum.
pub(crate) fn quantize_by(largest: f32, image: &[f32], bins: usize, quantized: &mut [u8]) {
    let bins = bins as f32;
    vectorized(|| {
        for (bin, &value) in quantized.iter_mut().zip(image) {
            *bin = floor((value / largest) * bins);
        }
    });
}

/// Floor of a number below 256, zero for a negative one; vectorizes, which a conversion by `as` does not.
#[inline(always)]
fn floor(number: f32) -> u8 {
    /// 2^23: a sum with it is rounded to a whole number, in its lowest binary digits.
    const WHOLE: f32 = 8_388_608.0;
    let number = if number > 0.0 { number } else { 0.0 };
    let rounded = (number + WHOLE) - WHOLE;
    let excess = if rounded > number { 1.0 } else { 0.0 };
    (rounded - excess + WHOLE).to_bits() as u8
}

/// Largest of non-negative values, zero without any; in eight independent lanes.
pub(crate) fn largest_of(image: &[f32]) -> f32 {
    let mut lanes = [0.0_f32; 8];
    let (chunks, rest) = image.as_chunks::<8>();
    for chunk in chunks {
        for (lane, &value) in lanes.iter_mut().zip(chunk) {
            *lane = if value > *lane { value } else { *lane };
        }
    }
    lanes.iter().chain(rest).copied().fold(0.0, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn information(first: &[u8], second: &[u8]) -> f64 {
        let mut tool = MutualInformation::new(255, first.len());
        let second_sum = tool.marginal(second);
        tool.information(first, second, second_sum)
    }

    #[test]
    fn a_case_worked_by_hand() {
        // Joint counts [[2, 1], [1, 4]] of 8 pixels; marginals 3, 5 and 3, 5.
        let first = [0, 0, 0, 1, 1, 1, 1, 1];
        let second = [0, 0, 1, 0, 1, 1, 1, 1];
        let by_hand = 0.25 * (0.25_f64 / (0.375 * 0.375)).ln()
            + 2.0 * 0.125 * (0.125_f64 / (0.375 * 0.625)).ln()
            + 0.5 * (0.5_f64 / (0.625 * 0.625)).ln();
        assert!((information(&first, &second) - by_hand).abs() < 1e-12);
    }

    #[test]
    fn an_image_knows_all_of_itself_and_nothing_of_a_constant() {
        let image: Vec<u8> = (0..128).collect();
        assert!((information(&image, &image) - 128.0_f64.ln()).abs() < 1e-12);
        assert_eq!(information(&image, &[7; 128]), 0.0);
        assert_eq!(MutualInformation::new(127, 0).information(&[], &[], 0), 0.0);
    }

    #[test]
    fn the_maximum_lands_in_bin_k_and_bins_are_floors() {
        for scale in [1e-6_f32, 0.1, 0.3, 1.0, 7.7, 3e5] {
            let image: Vec<f32> = (0..=127).map(|k| scale * k as f32 / 127.0).collect();
            let mut bins = vec![0; 128];
            quantize(&image, 127, &mut bins);
            assert_eq!((bins[0], bins[127]), (0, 127));
            assert_eq!(bins, crate::reference::quantize(&image, 127));
        }
        let mut bins = [9; 3];
        quantize(&[0.0; 3], 127, &mut bins);
        assert_eq!(bins, [0; 3]);
        let mut bins = [0; 3];
        quantize(&[0.999, 1.0, 0.4999], 2, &mut bins);
        assert_eq!(bins, [1, 2, 0]);
    }

    #[test]
    fn floors_are_those_of_a_conversion() {
        let near = |number: f32| [number, number.next_down(), number.next_up()];
        let whole_and_halves = (0..512).map(|half| half as f32 / 2.0).flat_map(near);
        for number in whole_and_halves.chain([-1e-9, -0.3, -7.0, 1e-30]) {
            assert_eq!(floor(number), number as u8, "{number:e}");
        }
    }

    proptest! {
        #[test]
        fn bounds_symmetry_and_the_plain_sum(pairs in prop::collection::vec((0_u8..20, 0_u8..20), 1..400)) {
            let (first, second): (Vec<u8>, Vec<u8>) = pairs.into_iter().unzip();
            let shared = information(&first, &second);
            prop_assert!(shared >= 0.0);
            prop_assert!(shared <= information(&first, &first).min(information(&second, &second)) + 1e-12);
            prop_assert!((shared - information(&second, &first)).abs() < 1e-12);
            prop_assert!((shared - crate::reference::mutual_information(&first, &second)).abs() < 1e-9);
        }

        #[test]
        fn following_changes_gives_the_same_as_counting(
            images in prop::collection::vec(prop::collection::vec(0_u8..12, 61), 2..6),
            second in prop::collection::vec(0_u8..=127, 61),
            start in 0_usize..61,
        ) {
            let mut tool = MutualInformation::new(127, 61);
            let second_sum = tool.marginal(&second);
            let mut held = images[0].clone();
            tool.information(&held, &second, second_sum);
            for image in &images[1..] {
                tool.change(&held[start..], &image[start..], &second[start..]);
                held[start..].copy_from_slice(&image[start..]);
                let followed = tool.value(second_sum);
                let counted = MutualInformation::new(127, 61).information(&held, &second, second_sum);
                prop_assert_eq!(followed.to_bits(), counted.to_bits());
            }
        }

        #[test]
        fn a_tool_is_clean_after_use(pairs in prop::collection::vec((0_u8..128, 0_u8..128), 50)) {
            let (first, second): (Vec<u8>, Vec<u8>) = pairs.into_iter().unzip();
            let mut tool = MutualInformation::new(127, 50);
            let second_sum = tool.marginal(&second);
            let once = tool.information(&first, &second, second_sum);
            prop_assert_eq!(once, tool.information(&first, &second, second_sum));
        }
    }
}
