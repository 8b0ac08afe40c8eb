//! Small numbers set to zero in quiet steps, see [`crate::field`].

use std::ops::Range;

use super::super::super::{layer_row, quieten};
use super::super::{Plan, RowWalls};
use super::Shared;

/// What a quiet step does to the memory of the layers in some rows before it is used.
///
/// # Safety
/// As [`super::run_tile`], for these rows.
pub(super) unsafe fn memory(plan: &Plan, shared: Shared, rows: Range<usize>) {
    let quieten = |at: *mut f32, count: usize| {
        // SAFETY: parts of the buffers, and of rows of this thread.
        quieten(unsafe { std::slice::from_raw_parts_mut(at, count) });
    };
    let x = plan.memory_x.stride();
    quieten(shared.layer_x.wrapping_add(rows.start * x), rows.len() * x);
    let (cells, ny) = (plan.setup.layer.cells(), plan.setup.ny);
    // On the low side a row reads the memory of the next row's face too, which is as old as its own; a second time changes nothing.
    for iy in rows.start..(rows.end + 1).min(ny) {
        if let Some(row) = layer_row(cells, ny, iy)
            && (iy < rows.end || !plan.memory_y.is_high(row))
        {
            let at = shared.layer_y.wrapping_add(plan.memory_y.face(row));
            quieten(at, 2 * plan.layout.stride);
        }
    }
}

/// What a quiet step does to the cells of a row that its walls have changed, and to the memory of its surfaces.
///
/// # Safety
/// As [`super::run_tile`], for this row.
pub(super) unsafe fn walls(walls: &RowWalls, shared: Shared, next: &mut [f32]) {
    for correction in &walls.corrections {
        quieten(&mut next[correction.at as usize..][..1]);
    }
    for surface in &walls.surfaces {
        // SAFETY: the memory of a row's surfaces belongs to who writes the row.
        quieten(unsafe {
            let memory = shared.surfaces.add(surface.memory);
            std::slice::from_raw_parts_mut(memory, surface.memory_count)
        });
        for &(offset, _) in &surface.gains {
            quieten(&mut next[offset as usize..][..1]);
        }
    }
}
