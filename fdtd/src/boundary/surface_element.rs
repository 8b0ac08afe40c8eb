//! A surface element with the weights of the cells before it.

use std::collections::BTreeMap;

/// Weights of cells by column and row.
pub(super) type Reach = BTreeMap<[usize; 2], f64>;

/// A surface element.
pub(super) struct SurfaceElement {
    /// Column and row of the cell in which it lies.
    pub(super) cell: [usize; 2],
    /// Length in cell widths.
    pub(super) length: f64,
    /// Weights of the cells whose pressure it samples and from which it takes its flow.
    pub(super) reach: Reach,
}
