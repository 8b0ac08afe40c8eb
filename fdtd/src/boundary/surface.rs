//! Surfaces of an impedance as a step of the field uses them.

use super::branches::Branches;

/// A surface of an impedance as seen from one row of the grid. Each row that a surface takes part in has a copy of
/// its state, with the same values, so that rows can be computed independently.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// `(dy, ix, weight)`: row offset and column of cells, and the weight of their pressure in the velocity (times
    /// `rho c`, in Pa), or in the pressure before the branches.
    pub taps: Vec<(isize, usize, f32)>,
    /// `(ix, gain)`: cells of this row, and the factor by which the change of the velocity reduces their pressure.
    pub gains: Vec<(usize, f32)>,
    /// Update of the velocity.
    pub reaction: Reaction,
    /// Index of its first number in the field's memory.
    pub memory: usize,
}

/// All surfaces of an impedance of a grid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surfaces {
    /// By row of the grid; no rows when all walls are rigid.
    rows: Vec<Vec<Surface>>,
}

impl Surfaces {
    /// From the surfaces of each row.
    pub(super) fn new(rows: Vec<Vec<Surface>>) -> Self {
        Self { rows }
    }

    /// The surfaces by row of the grid; no rows when all walls are rigid.
    pub fn rows(&self) -> &[Vec<Surface>] {
        &self.rows
    }

    /// The surfaces of a row.
    pub fn of_row(&self, iy: usize) -> &[Surface] {
        self.rows.get(iy).map_or(&[], Vec::as_slice)
    }

    /// Length of the field's memory of all of them.
    pub fn memory_count(&self) -> usize {
        let surfaces = self.rows.iter().flatten();
        surfaces.map(Surface::memory_count).sum()
    }
}

/// Update of the velocity of a surface from step to step.
#[derive(Debug, Clone, PartialEq)]
pub enum Reaction {
    /// Resistance and mass: the velocity is multiplied by this factor, and the taps are added.
    Decay(f32),
    /// Several branches, or one with a compliance; the taps give the pressure.
    Branches(Branches),
}

impl Surface {
    /// Length of its part of the field's memory.
    pub fn memory_count(&self) -> usize {
        match &self.reaction {
            Reaction::Decay(_) => 1,
            Reaction::Branches(branches) => branches.memory(),
        }
    }
}
