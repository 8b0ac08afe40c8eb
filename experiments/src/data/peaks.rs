//! Measured peak rates of a machine: the part `peaks` of `bench.json`.

use serde::{Deserialize, Serialize};

/// Peak rates of some threads together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Peaks {
    /// Number of threads.
    pub threads: usize,
    /// Fused multiply-adds in registers, 10^9 flops per second.
    pub fma_gflops: f64,
    /// Loads from the first-level cache, 10^9 bytes per second.
    pub l1_load_gbps: f64,
    /// Loads from memory, 10^9 bytes per second.
    pub memory_gbps: f64,
}

/// The peaks measured with this many threads, if any.
pub fn of(peaks: &[Peaks], threads: usize) -> Option<&Peaks> {
    peaks.iter().find(|peak| peak.threads == threads)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_are_found_by_threads() {
        let peaks = [1, 2].map(|threads| Peaks {
            threads,
            fma_gflops: 1.0,
            l1_load_gbps: 1.0,
            memory_gbps: 1.0,
        });
        assert_eq!(of(&peaks, 2).map(|peak| peak.threads), Some(2));
        assert_eq!(of(&peaks, 3), None);
    }
}
