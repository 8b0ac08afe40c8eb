//! Mutual information of two quantized images, eqs. (9)-(14).

/// Counts, logarithms and room for images of a fixed number of pixels and bins; nothing is allocated afterwards.
///
/// With counts n of N pixels, eq. (9) is exactly
/// `(sum n ln n (joint) - sum n ln n (first) - sum n ln n (second)) / N + ln N`, and n ln n comes from a table.
#[derive(Debug, Clone)]
pub struct MutualInformation {
    pixels: usize,
    /// Binary digits of one bin number.
    digits: u32,
    /// Joint counts, row by row; zero between calls.
    joint: Vec<u32>,
    /// Place of every pixel among the joint counts.
    places: Vec<u16>,
    /// Counts of single bins in four copies, so that a run of equal pixels does not wait for itself.
    single: [[u32; 256]; 4],
    n_ln_n: Vec<f64>,
}

impl MutualInformation {
    /// For images of `pixels` pixels with bin numbers 0 to `bins` (at most 255).
    pub fn new(bins: usize, pixels: usize) -> Self {
        let digits = (bins.min(255) + 1).next_power_of_two().ilog2();
        Self {
            pixels,
            digits,
            joint: vec![0; 1 << (2 * digits)],
            places: vec![0; pixels],
            single: [[0; 256]; 4],
            n_ln_n: (0..=pixels)
                .map(|n| {
                    if n < 2 {
                        0.0
                    } else {
                        n as f64 * (n as f64).ln()
                    }
                })
                .collect(),
        }
    }

    /// Sum of n ln n over the bins of one image: `N ln N - N` times its entropy.
    pub fn marginal(&mut self, image: &[u8]) -> f64 {
        self.single = [[0; 256]; 4];
        let (chunks, rest) = image.as_chunks::<4>();
        for chunk in chunks {
            for (single, &bin) in self.single.iter_mut().zip(chunk) {
                single[usize::from(bin)] += 1;
            }
        }
        for &bin in rest {
            self.single[0][usize::from(bin)] += 1;
        }
        let count = |bin: usize| self.single.iter().map(|single| single[bin]).sum::<u32>();
        (0..256)
            .map(|bin| self.n_ln_n.get(count(bin) as usize).copied().unwrap_or(0.0))
            .sum()
    }

    /// Mutual information in nats of two images whose [`Self::marginal`] sums are known.
    ///
    /// Both images have the number of pixels given to [`Self::new`] and no bin above `bins`; pixels that break this are left
    /// out.
    pub fn information(
        &mut self,
        first: &[u8],
        first_sum: f64,
        second: &[u8],
        second_sum: f64,
    ) -> f64 {
        if self.pixels == 0 {
            return 0.0;
        }
        let digits = self.digits;
        for ((place, &a), &b) in self.places.iter_mut().zip(first).zip(second) {
            *place = (u16::from(a) << digits) | u16::from(b);
        }
        for &place in &self.places {
            if let Some(count) = self.joint.get_mut(usize::from(place)) {
                *count += 1;
            }
        }
        // A second walk over the pixels meets every used count once and leaves zeros behind. Four sums, so that an addition
        // does not wait for the one before.
        let mut sums = [0.0; 4];
        let n_ln_n = self.n_ln_n.as_slice();
        let joint = self.joint.as_mut_slice();
        let mut take = |place: u16| {
            let count = joint.get_mut(usize::from(place)).map_or(0, std::mem::take);
            n_ln_n.get(count as usize).copied().unwrap_or(0.0)
        };
        let (chunks, rest) = self.places.as_chunks::<4>();
        for chunk in chunks {
            for (sum, &place) in sums.iter_mut().zip(chunk) {
                *sum += take(place);
            }
        }
        for &place in rest {
            sums[0] += take(place);
        }
        let joint_sum: f64 = sums.iter().sum();
        let total = self.pixels as f64;
        // Rounding may leave a tiny negative number where there is no information.
        ((joint_sum - first_sum - second_sum) / total + total.ln()).max(0.0)
    }
}

/// Bin numbers floor(K value / max) of an image of non-negative values, eqs. (13) and (14); all zero for a black image.
pub fn quantize(image: &[f32], bins: usize, quantized: &mut [u8]) {
    let largest = largest(image);
    if largest <= 0.0 {
        return quantized.fill(0);
    }
    let bins = bins as f32;
    for (bin, &value) in quantized.iter_mut().zip(image) {
        // The conversion truncates, which is the floor of a non-negative number.
        *bin = ((value / largest) * bins) as u8;
    }
}

/// Largest of non-negative values; in eight independent lanes, so that it needs no order.
fn largest(image: &[f32]) -> f32 {
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
        let (a, b) = (tool.marginal(first), tool.marginal(second));
        tool.information(first, a, second, b)
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
        assert_eq!(
            MutualInformation::new(127, 0).information(&[], 0.0, &[], 0.0),
            0.0
        );
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
        fn a_tool_is_clean_after_use(pairs in prop::collection::vec((0_u8..128, 0_u8..128), 50)) {
            let (first, second): (Vec<u8>, Vec<u8>) = pairs.into_iter().unzip();
            let mut tool = MutualInformation::new(127, 50);
            let (a, b) = (tool.marginal(&first), tool.marginal(&second));
            let once = tool.information(&first, a, &second, b);
            prop_assert_eq!(once, tool.information(&first, a, &second, b));
        }
    }
}
