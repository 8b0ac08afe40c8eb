//! The walls of a field in terms of the layout.
//!
//! Lists go through all rows, so that what a block of rows needs is one part of each: a few long loops instead of
//! several short ones for each row, whose ends the processor would hardly ever predict.

use std::ops::Range;

use super::layout::RowLayout;
use crate::boundary::{Reaction, Surface, Surfaces};
use crate::walls::operator::WallOperator;

/// Changes at walls.
#[derive(Debug)]
pub(super) struct Walls {
    /// Corrected cells, by how many entries they have.
    pub(super) corrections: Vec<Corrections>,
    /// Cells inside walls to which the stencil brings something from outside; those farther in stay silent by
    /// themselves.
    pub(super) solid: Cells,
    /// Surfaces that are not rigid, row by row; no rows when there are none.
    surfaces: Vec<Vec<RowSurface>>,
}

/// Cells in ascending order of their rows.
#[derive(Debug, Default)]
pub(super) struct Cells {
    /// Offsets from the first row of the rim.
    at: Vec<u32>,
    /// How many lie in the rows before each one, and in all.
    before: Vec<usize>,
}

/// Corrected cells with the same number of entries.
#[derive(Debug)]
pub(super) struct Corrections {
    /// Entries per cell.
    pub(super) each: usize,
    cells: Cells,
    /// `(offset from the cell, weight)`.
    entries: Vec<(i32, f32)>,
}

/// A surface that is not rigid, as [`Surface`] has it.
#[derive(Debug)]
pub(super) struct RowSurface {
    /// `(offset from the row's start, weight)`.
    pub(super) taps: Vec<(i32, f32)>,
    /// `(offset in the row, gain)`.
    pub(super) gains: Vec<(u32, f32)>,
    pub(super) reaction: Reaction,
    pub(super) memory: usize,
    pub(super) memory_count: usize,
}

impl Cells {
    /// Those of some rows.
    pub(super) fn of(&self, rows: &Range<usize>) -> &[u32] {
        &self.at[self.range(rows)]
    }

    fn range(&self, rows: &Range<usize>) -> Range<usize> {
        self.before[rows.start]..self.before[rows.end]
    }

    /// Adds the cells of the next row.
    fn push_row(&mut self, cells: impl Iterator<Item = usize>) {
        if self.before.is_empty() {
            self.before.push(0);
        }
        self.at.extend(cells.map(|at| at as u32));
        self.before.push(self.at.len());
    }
}

impl Corrections {
    /// Cells of some rows, and their entries one after the other.
    pub(super) fn of(&self, rows: &Range<usize>) -> (&[u32], &[(i32, f32)]) {
        let range = self.cells.range(rows);
        let entries = &self.entries[range.start * self.each..range.end * self.each];
        (&self.cells.at[range], entries)
    }
}

impl Walls {
    /// The surfaces that are not rigid of each of some rows.
    pub(super) fn surfaces_of(
        &self,
        rows: &Range<usize>,
    ) -> impl Iterator<Item = (usize, &[RowSurface])> {
        let surfaces = self.surfaces.get(rows.clone()).unwrap_or_default();
        rows.clone().zip(surfaces.iter().map(Vec::as_slice))
    }

    /// Those of `walls` in rows of `layout`.
    pub(super) fn new(walls: &WallOperator, surfaces: &Surfaces, layout: &RowLayout) -> Self {
        let row_at = |iy: usize| (iy + layout.halo) * layout.stride;
        let offset =
            |dy: isize, ix: usize| (dy * layout.stride as isize) as i32 + layout.offset(ix) as i32;
        let mut counts: Vec<usize> = (walls.corrections.iter().flatten())
            .map(|correction| correction.entries.len())
            .collect();
        counts.sort_unstable();
        counts.dedup();
        let corrections = counts.into_iter().map(|each| {
            let (mut cells, mut entries) = (Cells::default(), Vec::new());
            for (iy, row) in walls.corrections.iter().enumerate() {
                let row = || {
                    row.iter()
                        .filter(|correction| correction.entries.len() == each)
                };
                cells.push_row(row().map(|correction| row_at(iy) + layout.offset(correction.ix)));
                entries.extend(row().flat_map(|correction| {
                    let own = layout.offset(correction.ix) as i32;
                    (correction.entries.iter())
                        .map(move |&(dy, ix, weight)| (offset(dy, ix) - own, weight))
                }));
            }
            Corrections {
                each,
                cells,
                entries,
            }
        });
        let mut solid = Cells::default();
        for (iy, row) in walls.solid.iter().enumerate() {
            let reached = row
                .iter()
                .filter(|&&ix| is_reached(walls, layout.halo, [ix, iy]));
            solid.push_row(reached.map(|&ix| row_at(iy) + layout.offset(ix)));
        }
        let surface = |surface: &Surface| RowSurface {
            taps: (surface.taps.iter())
                .map(|&(dy, ix, weight)| (offset(dy, ix), weight))
                .collect(),
            gains: (surface.gains.iter())
                .map(|&(ix, gain)| (layout.offset(ix) as u32, gain))
                .collect(),
            reaction: surface.reaction.clone(),
            memory: surface.memory,
            memory_count: surface.memory_count(),
        };
        Self {
            corrections: corrections.collect(),
            solid,
            surfaces: (surfaces.rows().iter())
                .map(|row| row.iter().map(surface).collect())
                .collect(),
        }
    }
}

/// Whether there is a cell that is not solid in the stencil of this one, which is a diamond.
fn is_reached(walls: &WallOperator, radius: usize, [ix, iy]: [usize; 2]) -> bool {
    let mut rows = iy.saturating_sub(radius)..(iy + radius + 1).min(walls.solid.len());
    rows.any(|y| {
        let reach = radius - y.abs_diff(iy);
        let solid = walls.solid_within(y, ix.saturating_sub(reach)..ix + reach + 1);
        solid.len() < 2 * reach + 1
    })
}
