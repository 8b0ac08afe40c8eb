//! Lengths and products of discrete spectra.

use rustfft::num_complex::Complex;

use crate::simd::vectorized;

/// The products of two spectra, line by line.
pub(crate) fn multiply(
    spectrum: &[Complex<f32>],
    filter: &[Complex<f32>],
    product: &mut [Complex<f32>],
) {
    vectorized(|| {
        for ((product, value), weight) in product.iter_mut().zip(spectrum).zip(filter) {
            *product = value * weight;
        }
    });
}

/// The smallest 2^a 3^b 5^c with a >= 6 that is not below `length`, for fast transforms.
pub(crate) fn fast_length(length: usize) -> usize {
    let mut best = length.next_power_of_two().max(64);
    let mut fives = 64;
    while fives < best {
        let mut threes = fives;
        while threes < best {
            let mut twos = threes;
            while twos < length {
                twos *= 2;
            }
            best = best.min(twos);
            threes *= 3;
        }
        fives *= 5;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_have_small_factors() {
        assert_eq!(fast_length(24_808), 25_600);
        assert_eq!(fast_length(10), 64);
        for length in [100, 5000, 20_716, 61_380] {
            let mut rest = fast_length(length);
            assert!(rest >= length);
            for prime in [2, 3, 5] {
                while rest.is_multiple_of(prime) {
                    rest /= prime;
                }
            }
            assert_eq!(rest, 1);
        }
    }
}
