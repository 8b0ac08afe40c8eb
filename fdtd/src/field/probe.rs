//! Measures what the machine can do, to hold the engines' speed against it.

use std::hint::black_box;
use std::time::Instant;

/// Runs `work` with the widest instructions that a probe is compiled for.
fn compiled<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if super::fast::InstructionSet::detect() != super::fast::InstructionSet::Portable {
        return super::fast::with_avx2(work);
    }
    work()
}

/// Fused multiply-adds in registers on one thread with vectors of eight, in Gflop/s (two flops each).
pub fn fma_gflops() -> f64 {
    const ROUNDS: usize = 10_000_000;
    let factor = black_box([0.999_f32; 8]);
    let mut sums = black_box([[1.0_f32; 8]; 12]);
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
    (2 * 8 * 12 * ROUNDS) as f64 / start.elapsed().as_secs_f64() / 1e9
}

/// Rate at which one thread sums an array of `bytes` again and again for `total` bytes, in GB/s: the load bandwidth of
/// the level of memory that the array fits in.
pub fn load_gbps(bytes: usize, total: usize) -> f64 {
    let numbers = black_box(vec![1.0_f32; bytes.div_ceil(256) * 64]);
    let passes = (total / (4 * numbers.len()).max(1)).max(1);
    let start = Instant::now();
    compiled(
        #[inline(always)]
        || {
            for _ in 0..passes {
                let mut sums = [0.0_f32; 64];
                for chunk in black_box(&numbers).as_chunks::<64>().0 {
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
