//! One time level of the field in memory.

use std::ops::Range;

use super::kernel;
use super::line::{LINE, Line};

/// Lines in a page.
const PAGE_LINES: usize = 4096 / size_of::<Line>();

/// One time level. The two levels start at different places of a page, wherever the allocator puts them: were the same
/// cells of both at the same place, loads of one would wait for stores to the other (the processor compares the low 12
/// bits first).
#[derive(Debug)]
pub(super) struct Level {
    lines: Vec<Line>,
    /// Those that hold it.
    own: Range<usize>,
}

impl Level {
    /// Zeros that begin `place` lines into a page.
    pub(super) fn silent(numbers: usize, place: usize) -> Self {
        let count = numbers.div_ceil(LINE);
        let lines = vec![Line([0.0; LINE]); count + PAGE_LINES - 1];
        let begin = lines.as_ptr().addr() / size_of::<Line>();
        let skip = (place + PAGE_LINES - begin % PAGE_LINES) % PAGE_LINES;
        Self {
            lines,
            own: skip..skip + count,
        }
    }

    pub(super) fn numbers(&self) -> &[f32] {
        kernel::flat(&self.lines[self.own.clone()])
    }

    pub(super) fn numbers_mut(&mut self) -> &mut [f32] {
        kernel::flat_mut(&mut self.lines[self.own.clone()])
    }
}
