//! Peaks of the machine, with which the engines' speed is compared.

use std::hint::black_box;
use std::time::Instant;

use super::fast::InstructionSet;

/// Runs `work` with the widest instructions of this machine that the engines use.
fn compiled<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    match InstructionSet::detect() {
        InstructionSet::Avx512 => return super::fast::with_avx512(work),
        InstructionSet::Avx2 => return super::fast::with_avx2(work),
        InstructionSet::Portable => {}
    }
    work()
}

/// Fused multiply-adds in registers on one thread, in Gflop/s (two flops each), with vectors as wide as the fast
/// engine's.
pub fn fma_gflops() -> f64 {
    match InstructionSet::detect() {
        InstructionSet::Avx512 => fma::<16>(),
        InstructionSet::Avx2 | InstructionSet::Portable => fma::<8>(),
    }
}

/// [`fma_gflops`] with vectors of `LANES`. Twelve sums: more than the latency of two units needs, fewer than there are
/// registers.
fn fma<const LANES: usize>() -> f64 {
    const ROUNDS: usize = 10_000_000;
    let factor = black_box([0.999_f32; LANES]);
    let mut sums = black_box([[1.0_f32; LANES]; 12]);
    let start = Instant::now();
    compiled(
        #[inline(always)]
        || {
            for _ in 0..ROUNDS {
                for sum in &mut sums {
                    for (s, f) in sum.iter_mut().zip(&factor) {
                        *s = s.mul_add(*f, 0.001);
                    }
                }
            }
        },
    );
    black_box(sums);
    (2 * LANES * 12 * ROUNDS) as f64 / start.elapsed().as_secs_f64() / 1e9
}

/// Rate at which one thread sums an array of `bytes` again and again for `total` bytes, in GB/s: the load bandwidth of
/// the level of memory that the array fits in.
pub fn load_gbps(bytes: usize, total: usize) -> f64 {
    let numbers = black_box(vec![1.0_f32; bytes.div_ceil(512) * 128]);
    let passes = (total / (4 * numbers.len()).max(1)).max(1);
    let start = Instant::now();
    compiled(
        #[inline(always)]
        || {
            for _ in 0..passes {
                let mut sums = [0.0_f32; 128];
                for chunk in black_box(&numbers).as_chunks::<128>().0 {
                    for (s, x) in sums.iter_mut().zip(chunk) {
                        *s += x;
                    }
                }
                black_box(sums);
            }
        },
    );
    (4 * numbers.len() * passes) as f64 / start.elapsed().as_secs_f64() / 1e9
}
