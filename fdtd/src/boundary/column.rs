//! The column of cells before walls along the axes, and nearly so.

use super::half_line::AxisWeights;
use super::surface_element::Reach;
use crate::walls::{Load, WallCells};

/// Least area of a cell beside the first one along the wall, over that of the first, to take part: smaller cells
/// would need too much mass for passivity.
const LEAST_BESIDE: f64 = 0.5;

/// The cells before a surface along the axis nearest to its normal.
pub(super) struct Column {
    /// First cell that holds air.
    first: [usize; 2],
    axis: usize,
    /// Direction from the wall into the air along the axis, 1 or -1.
    inward: isize,
    /// Cosine of the angle between axis and normal.
    pub(super) slope: f64,
    /// Open part of the first cell, along the axis through its centre.
    pub(super) open: f64,
}

impl Column {
    /// The column before a surface element.
    pub(super) fn of(walls: &WallCells, load: &Load) -> Self {
        let (axis, slope) = load.nearest_axis();
        let inward = if load.normal[axis] > 0.0 { 1 } else { -1 };
        let [nx, ny] = walls.size();
        let air = |[x, y]: [isize; 2]| {
            let inside = x >= 0 && y >= 0 && (x as usize) < nx && (y as usize) < ny;
            inside && walls.cut_cell(x, y).is_some()
        };
        let own = load.cell.map(|at| at as isize);
        let mut place = own;
        let mut open = 0.5 + load.distance / slope;
        // The cell in which the line through the centres of the column meets the wall.
        if open > 1.0 {
            let mut outward = place;
            outward[axis] -= inward;
            if air(outward) {
                (place, open) = (outward, open - 1.0);
            }
        }
        if open <= 0.0 {
            place[axis] += inward;
            open += 1.0;
        }
        let place = if air(place) { place } else { own };
        Self {
            first: place.map(|at| at as usize),
            axis,
            inward,
            slope,
            open: open.clamp(0.0, 1.0),
        }
    }

    /// Weights of the cells of the column, fewer than three where another wall comes between.
    pub(super) fn reach(&self, walls: &WallCells, axis: &AxisWeights) -> Reach {
        let mut cells = vec![self.first];
        while let Some(next) = (cells.len() < 3)
            .then(|| walls.beside(cells[cells.len() - 1], self.axis, self.inward))
            .flatten()
        {
            cells.push(next);
        }
        let mut weights = axis.weights;
        // The last cell takes the weights of missing ones.
        for missing in (cells.len()..3).rev() {
            weights[missing - 1] += weights[missing];
        }
        let mut reach: Reach = cells.iter().copied().zip(weights).collect();
        let area = |[ix, iy]: [usize; 2]| {
            let cut = walls.cut_cell(ix as isize, iy as isize);
            cut.map_or(0.0, |cut| cut.area)
        };
        for side in [-1, 1] {
            if let Some(cell) = walls.beside(self.first, 1 - self.axis, side)
                && area(cell) >= LEAST_BESIDE * area(self.first)
            {
                *reach.entry(self.first).or_default() -= axis.along;
                *reach.entry(cell).or_default() += axis.along;
            }
        }
        reach.retain(|_, weight| *weight != 0.0);
        reach
    }
}
