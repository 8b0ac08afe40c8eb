//! Random streams that depend on names and numbers only, never on the order of execution.

use std::hash::Hasher;

use fnv::FnvHasher;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Seed of one trial of one cell of an experiment.
pub fn trial_seed(experiment: &str, cell: &str, trial: u64) -> u64 {
    let mut hasher = FnvHasher::default();
    for part in [experiment.as_bytes(), cell.as_bytes(), &trial.to_le_bytes()] {
        hasher.write(part);
        // A separator that UTF-8 does not contain keeps ("ab", "c") apart from ("a", "bc").
        hasher.write(&[0xff]);
    }
    hasher.finish()
}

/// The stream of one purpose (such as "motion noise") under a seed: ChaCha8 with the seed as key, the purpose as nonce.
pub fn stream(seed: u64, purpose: &str) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut hasher = FnvHasher::default();
    hasher.write(purpose.as_bytes());
    rng.set_stream(hasher.finish());
    rng
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    /// Published estimates depend on it: FNV-1a, 64 bits, by another program.
    #[test]
    fn a_seed_stays_what_it_was() {
        assert_eq!(trial_seed("noise", "snr 5", 3), 0x8cee_a8bb_d8b1_5593);
    }

    #[test]
    fn streams_differ_by_purpose_and_trial_and_repeat() {
        let first = |seed, purpose| stream(seed, purpose).next_u64();
        assert_eq!(first(1, "motion"), first(1, "motion"));
        assert_ne!(first(1, "motion"), first(1, "resampling"));
        assert_ne!(first(1, "motion"), first(2, "motion"));
        assert_ne!(trial_seed("ab", "c", 0), trial_seed("a", "bc", 0));
        assert_ne!(trial_seed("a", "b", 0), trial_seed("a", "b", 1));
    }
}
