//! The part of the field that a step of the wavefront takes at once, so that the first-level cache holds all that is
//! read again soon.
//!
//! The leapfrog's sweep does five operations for three numbers that come from the second-level cache or go there, and
//! waits for them. When a step takes no more rows than fit into the first level, together with the two beyond them and
//! those of the level that is written, the next step finds nearly all of them there. Wider stencils move on by more
//! rows per step and have more to do for each number: they take many rows, in parts short enough that a cell is there
//! for all rows of its stencil.

use super::instructions::InstructionSet;
use super::layout::{RowLayout, WIDE};
use crate::scheme::Scheme;

/// The machine that a field is laid out for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Machine {
    /// Instructions of the sweeps.
    pub instructions: InstructionSet,
    /// First-level data cache of a core, bytes.
    pub first_level_bytes: usize,
}

/// Assumed where the processor does not report its cache: the smallest in use.
const FIRST_LEVEL_BYTES: usize = 32 * 1024;

impl Machine {
    /// This one.
    pub fn detect() -> Self {
        Self {
            instructions: InstructionSet::detect(),
            first_level_bytes: first_level_bytes().unwrap_or(FIRST_LEVEL_BYTES),
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn first_level_bytes() -> Option<usize> {
    use raw_cpuid::CacheType;
    let caches = raw_cpuid::CpuId::new().get_cache_parameters()?;
    let mut first = caches.filter(|cache| cache.level() == 1);
    let data = first.find(|cache| cache.cache_type() == CacheType::Data)?;
    let ways = data.associativity() * data.physical_line_partitions();
    Some(ways * data.coherency_line_size() * data.sets())
}

#[cfg(not(target_arch = "x86_64"))]
fn first_level_bytes() -> Option<usize> {
    None
}

/// The part of the field that a step of the wavefront takes at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Blocking {
    /// Rows.
    pub(super) rows: usize,
    /// Vectors of the centre that these rows take one after the other.
    pub(super) chunk: usize,
}

impl Blocking {
    /// For rows of `layout` in a first-level cache of so many bytes.
    pub(super) fn new(scheme: Scheme, layout: &RowLayout, first_level_bytes: usize) -> Self {
        let row_bytes = layout.stride * size_of::<f32>();
        let whole = layout.centre.max(1);
        match scheme {
            Scheme::Slf => {
                let most = if layout.lanes == WIDE { 6 } else { 4 };
                let fits = |rows: &usize| (2 * rows + 2) * row_bytes <= first_level_bytes;
                Self {
                    // Where not even three fit, all come from farther away, and the most have the fewest rows beside
                    // them.
                    rows: (3..=most).rev().find(fits).unwrap_or(most),
                    chunk: whole,
                }
            }
            Scheme::Iwb | Scheme::M13 | Scheme::O13 | Scheme::D25 => {
                // The rows of a stencil, or of a pair of them, and those that are written.
                let vectors = first_level_bytes * 3 / 4 / (8 * layout.lanes * size_of::<f32>());
                let parts = whole.div_ceil(vectors.max(1));
                Self {
                    rows: 24,
                    chunk: whole.div_ceil(parts),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_step_takes_fits_into_the_first_level() {
        for (nx, bytes, rows) in [
            (512, 48 << 10, 6),
            (850, 48 << 10, 5),
            (1000, 48 << 10, 4),
            (850, 32 << 10, 3),
            (8000, 48 << 10, 6),
        ] {
            let layout = RowLayout::new(nx, 24, WIDE, 1);
            let blocking = Blocking::new(Scheme::Slf, &layout, bytes);
            let expected = Blocking {
                rows,
                chunk: layout.centre,
            };
            assert_eq!(blocking, expected, "{nx} cells, {bytes} bytes");
        }
        for (nx, bytes, parts) in [(850, 48 << 10, 1), (1000, 32 << 10, 2), (8000, 48 << 10, 7)] {
            let layout = RowLayout::new(nx, 24, WIDE, 2);
            let blocking = Blocking::new(Scheme::O13, &layout, bytes);
            assert_eq!(layout.centre.div_ceil(blocking.chunk), parts, "{nx} cells");
            assert!(8 * blocking.chunk * WIDE * size_of::<f32>() <= bytes);
        }
        let narrow = RowLayout::new(50, 24, WIDE, 2);
        assert_eq!(Blocking::new(Scheme::O13, &narrow, 0).chunk, 1);
    }

    #[test]
    fn the_first_level_is_of_a_likely_size() {
        let bytes = Machine::detect().first_level_bytes;
        assert!((8 << 10..=1 << 20).contains(&bytes), "{bytes} bytes");
    }
}
