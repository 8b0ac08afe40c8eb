//! Mutual information of two quantized images, eqs. (9)-(14).

/// Lanes in which pixels are counted and sums are added up: an addition does not wait for the one before.
const LANES: usize = 4;

/// Counts, logarithms and room for images of a fixed number of pixels and bins; nothing is allocated afterwards.
///
/// With counts n of N pixels, eq. (9) is exactly
/// `(sum n ln n (joint) - sum n ln n (first) - sum n ln n (second)) / N + ln N`, and n ln n comes from a table.
#[derive(Debug, Clone)]
pub struct MutualInformation {
    pixels: usize,
    /// Binary digits of one bin number.
    digits: u32,
    /// Joint counts, row by row; zero between calls. Has a place for every `u16`, so that none has to be checked.
    joint: Box<[u32; 1 << 16]>,
    /// Place of every pixel among the joint counts.
    places: Vec<u16>,
    /// The places in the order in which each lane first met them.
    met: Vec<[u16; LANES]>,
    /// Counts of single bins in as many copies, so that a run of equal pixels does not wait for itself.
    single: [[u32; 256]; LANES],
    n_ln_n: Vec<f64>,
}

impl MutualInformation {
    /// For images of `pixels` pixels with bin numbers 0 to `bins` (at most 255).
    pub fn new(bins: usize, pixels: usize) -> Self {
        let digits = (bins.min(255) + 1).next_power_of_two().ilog2();
        Self {
            pixels,
            digits,
            joint: Box::new([0; 1 << 16]),
            places: vec![0; pixels],
            // One more than a lane has pixels: where the next place would go.
            met: vec![[0; LANES]; pixels / LANES + LANES],
            single: [[0; 256]; LANES],
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
        let (chunks, rest) = image.as_chunks::<LANES>();
        for chunk in chunks {
            for (single, &bin) in self.single.iter_mut().zip(chunk) {
                single[usize::from(bin)] += 1;
            }
        }
        for &bin in rest {
            self.single[0][usize::from(bin)] += 1;
        }
        self.single_sum()
    }

    /// Sum of n ln n over the single bins, whose counts it leaves zero.
    fn single_sum(&mut self) -> f64 {
        let mut sum = 0.0;
        for bin in 0..256 {
            let count: u32 = self.single.iter().map(|single| single[bin]).sum();
            sum += self.n_ln_n.get(count as usize).copied().unwrap_or(0.0);
        }
        self.single = [[0; 256]; LANES];
        sum
    }

    /// Mutual information in nats of two images; `second_sum` is the [`Self::marginal`] of the second.
    ///
    /// Both images have the number of pixels given to [`Self::new`] and no bin above `bins`.
    pub fn information(&mut self, first: &[u8], second: &[u8], second_sum: f64) -> f64 {
        if self.pixels == 0 {
            return 0.0;
        }
        let digits = self.digits;
        for ((place, &a), &b) in self.places.iter_mut().zip(first).zip(second) {
            *place = (u16::from(a) << digits) | u16::from(b);
        }
        let lengths = self.count();
        let joint_sum = self.joint_sum(lengths);
        let first_sum = self.single_sum();
        let total = self.pixels as f64;
        // Rounding may leave a tiny negative number where there is no information.
        ((joint_sum - first_sum - second_sum) / total + total.ln()).max(0.0)
    }

    /// Counts all places. Returns how many each lane was the first to meet.
    fn count(&mut self) -> [usize; LANES] {
        let Self {
            joint, places, met, ..
        } = self;
        let met = met.as_mut_slice();
        let mut lengths = [0; LANES];
        let mut count = |place: u16, lane: usize| {
            let count = &mut joint[usize::from(place)];
            // Always written, kept only if new: no branch that would be guessed wrong.
            met[lengths[lane]][lane] = place;
            lengths[lane] += usize::from(*count == 0);
            *count += 1;
        };
        let (chunks, rest) = places.as_chunks::<LANES>();
        for chunk in chunks {
            for (lane, &place) in chunk.iter().enumerate() {
                count(place, lane);
            }
        }
        for &place in rest {
            count(place, 0);
        }
        lengths
    }

    /// Sum of n ln n over the joint counts, lane by lane in the order of [`Self::count`]. Leaves the joint counts zero and those of the
    /// first image in `single`.
    fn joint_sum(&mut self, lengths: [usize; LANES]) -> f64 {
        let longest = lengths.into_iter().fold(0, usize::max);
        let mut sums = [0.0; LANES];
        for (index, met) in self.met[..longest].iter().enumerate() {
            for lane in 0..LANES {
                if index < lengths[lane] {
                    let place = usize::from(met[lane]);
                    let count = std::mem::take(&mut self.joint[place]);
                    sums[lane] += self.n_ln_n[count as usize];
                    self.single[lane][(place >> self.digits) & 255] += count;
                }
            }
        }
        sums.iter().sum()
    }
}

/// Bin numbers floor(K value / max) of an image of non-negative values, eqs. (13) and (14); all zero for a black image.
pub fn quantize(image: &[f32], bins: usize, quantized: &mut [u8]) {
    let largest = largest_of(image);
    if largest <= 0.0 {
        return quantized.fill(0);
    }
    quantize_by(largest, image, bins, quantized);
}

/// [`quantize`] by a positive maximum that is known.
pub(crate) fn quantize_by(largest: f32, image: &[f32], bins: usize, quantized: &mut [u8]) {
    let bins = bins as f32;
    for (bin, &value) in quantized.iter_mut().zip(image) {
        // The conversion truncates, which is the floor of a non-negative number.
        *bin = ((value / largest) * bins) as u8;
    }
}

/// Largest of non-negative values, zero without any; in eight independent lanes, for it needs no order.
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

    /// The same sums by a second walk over all pixels, in the order that results on file rest on.
    fn by_two_walks(first: &[u8], second: &[u8]) -> f64 {
        let n_ln_n = |n: u32| match n {
            0 | 1 => 0.0,
            _ => f64::from(n) * f64::from(n).ln(),
        };
        let mut joint = vec![[0_u32; 256]; 256];
        let (mut rows, mut columns) = ([0_u32; 256], [0_u32; 256]);
        for (&a, &b) in first.iter().zip(second) {
            joint[usize::from(a)][usize::from(b)] += 1;
            rows[usize::from(a)] += 1;
            columns[usize::from(b)] += 1;
        }
        let mut sums = [0.0; LANES];
        let whole = first.len() / LANES * LANES;
        for (index, (&a, &b)) in first.iter().zip(second).enumerate() {
            let lane = if index < whole { index % LANES } else { 0 };
            sums[lane] += n_ln_n(std::mem::take(&mut joint[usize::from(a)][usize::from(b)]));
        }
        let marginal = |counts: [u32; 256]| counts.into_iter().map(n_ln_n).sum::<f64>();
        let sum: f64 = sums.iter().sum();
        let total = first.len() as f64;
        ((sum - marginal(rows) - marginal(columns)) / total + total.ln()).max(0.0)
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
            MutualInformation::new(127, 0).information(&[], &[], 0.0),
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
        fn additions_keep_their_order(pairs in prop::collection::vec((0_u8..=255, 0_u8..12), 1..900), few in 1_u8..=255) {
            let (first, second): (Vec<u8>, Vec<u8>) = pairs.into_iter().map(|(a, b)| (a % few, b)).unzip();
            prop_assert_eq!(information(&first, &second).to_bits(), by_two_walks(&first, &second).to_bits());
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
