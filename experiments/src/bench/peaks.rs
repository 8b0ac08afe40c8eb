//! Peak rates of the machine with some threads at once: the roofs of the roofline.

use std::sync::Barrier;

use fdtd::field::probe;

use crate::data::peaks::Peaks;

/// Times that each probe is repeated; the best counts, because a peak is reached without disturbance only.
const REPEATS: usize = 5;

/// Measures `threads` threads at the same time.
pub fn measure(threads: usize) -> Peaks {
    Peaks {
        threads,
        fma_gflops: best(threads, probe::fma_gflops),
        l1_load_gbps: best(threads, || probe::load_gbps(16 << 10, 1 << 33)),
        memory_gbps: best(threads, || probe::load_gbps(256 << 20, 1 << 30)),
    }
}

/// The best sum of rates over some repeats, in each of which the threads start together.
fn best(threads: usize, probe: impl Fn() -> f64 + Sync) -> f64 {
    let once = || {
        let start = Barrier::new(threads);
        std::thread::scope(|scope| {
            let runs: Vec<_> = (0..threads)
                .map(|_| {
                    scope.spawn(|| {
                        start.wait();
                        probe()
                    })
                })
                .collect();
            runs.into_iter()
                .map(|run| run.join().unwrap_or(f64::NAN))
                .sum::<f64>()
        })
    };
    (0..REPEATS).map(|_| once()).fold(f64::NAN, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_repeat_of_all_threads_together_counts() {
        assert_eq!(best(3, || 2.0), 6.0);
    }
}
