//! Loops compiled for the widest vectors of the machine: the only unsafe code of the crate.
//!
//! A release binary must run on any machine, so it is compiled for vectors of four 32-bit numbers. The closures
//! passed here are compiled once more for eight, and that version runs where the machine has them. Products and sums
//! are rounded one by one in both (no fused multiply-adds), so that the results are equal bit for bit.
#![expect(
    unsafe_code,
    reason = "calling a function of an instruction set that was looked for before"
)]

/// Runs `work`, whose loops should be in its own body or in functions that are always inlined.
#[inline]
pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the machine has the instructions.
        return unsafe { with_avx2(work) };
    }
    work()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<R>(work: impl FnOnce() -> R) -> R {
    work()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_loops_give_the_same_bytes() {
        let numbers: Vec<f32> = (0..1003).map(|k| (k as f32 * 0.7).sin()).collect();
        let work = || -> Vec<u32> {
            let polynomial = |u: f32| ((u * 0.3 + 0.1) * u + 0.7) * u - 0.2;
            numbers.iter().map(|&u| polynomial(u).to_bits()).collect()
        };
        assert_eq!(vectorized(work), work());
    }
}
