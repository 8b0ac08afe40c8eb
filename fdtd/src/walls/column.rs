//! The cells that take part before walls along the axes, and nearly so.

use super::WallCells;
use super::aperture::Aperture;
use super::openings::Load;
use super::surface::Reach;

/// Cells beside a surface need so much of the air of the first cell to take part along it: small ones would ask for more mass than is there.
const LEAST_BESIDE: f64 = 0.5;

/// The cells before a surface along the axis nearest to its normal.
pub(super) struct Column {
    /// First cell that holds air.
    first: [usize; 2],
    axis: usize,
    /// Way from the wall into the air along the axis, 1 or -1.
    inward: isize,
    /// Cosine of the angle between axis and normal.
    pub(super) slope: f64,
    /// Open part of the first cell, along the axis through its middle.
    pub(super) open: f64,
}

impl Column {
    pub(super) fn of(walls: &WallCells, load: &Load) -> Self {
        let (axis, slope) = load.nearest_axis();
        let inward = if load.normal[axis] > 0.0 { 1 } else { -1 };
        let [nx, ny] = walls.size();
        let air = |[x, y]: [isize; 2]| {
            let inside = x >= 0 && y >= 0 && (x as usize) < nx && (y as usize) < ny;
            inside && walls.opening(x, y).is_some()
        };
        let own = load.cell.map(|at| at as isize);
        let mut place = own;
        let mut open = 0.5 + load.distance / slope;
        // The cell that holds the wall where the line through the cells' middles meets it.
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

    /// The cells that the surface samples and takes its flow from. Where another wall comes between, fewer.
    pub(super) fn reach(&self, walls: &WallCells, aperture: &Aperture) -> Reach {
        let mut cells = vec![self.first];
        while let Some(next) = (cells.len() < 3)
            .then(|| walls.beside(cells[cells.len() - 1], self.axis, self.inward))
            .flatten()
        {
            cells.push(next);
        }
        let mut weights = aperture.weights;
        // What cells that are not there should have done is left to the last one that is.
        for missing in (cells.len()..3).rev() {
            weights[missing - 1] += weights[missing];
        }
        let mut reach: Reach = cells.iter().copied().zip(weights).collect();
        let area = |[ix, iy]: [usize; 2]| {
            let opening = walls.opening(ix as isize, iy as isize);
            opening.map_or(0.0, |opening| opening.area)
        };
        for side in [-1, 1] {
            if let Some(cell) = walls.beside(self.first, 1 - self.axis, side)
                && area(cell) >= LEAST_BESIDE * area(self.first)
            {
                *reach.entry(self.first).or_default() -= aperture.along;
                *reach.entry(cell).or_default() += aperture.along;
            }
        }
        reach.retain(|_, weight| *weight != 0.0);
        reach
    }
}
