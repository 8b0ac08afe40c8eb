//! Solid cells of walls by cell centres, and conversion between points and cells.

use super::wall::Wall;
use crate::grid::Grid;
use std::ops::Range;

/// Which cells of the grid are solid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SolidMask {
    /// Cells along x.
    pub nx: usize,
    /// Cells along y.
    pub ny: usize,
    /// `[iy, ix]`, x fastest: true where solid.
    pub cells: Vec<bool>,
}

impl SolidMask {
    /// A mask without solid cells.
    pub fn open(nx: usize, ny: usize) -> Self {
        Self {
            nx,
            ny,
            cells: vec![false; nx * ny],
        }
    }

    /// Index of a cell of any place, `None` outside the grid.
    pub(super) fn index(&self, ix: isize, iy: isize) -> Option<usize> {
        let inside = ix >= 0 && iy >= 0 && (ix as usize) < self.nx && (iy as usize) < self.ny;
        inside.then(|| iy as usize * self.nx + ix as usize)
    }

    /// Whether a cell is solid; what lies outside the grid is not.
    pub fn is_solid(&self, ix: usize, iy: usize) -> bool {
        ix < self.nx && iy < self.ny && self.cells[iy * self.nx + ix]
    }

    /// Number of solid cells.
    pub fn solid_cells(&self) -> usize {
        self.cells.iter().filter(|&&solid| solid).count()
    }

    /// Solid cells as `(ix, iy)`, row by row.
    pub fn iter_solid(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let place =
            |(index, &solid): (usize, &bool)| solid.then_some((index % self.nx, index / self.nx));
        self.cells.iter().enumerate().filter_map(place)
    }
}

/// The solid cells of `walls`: those whose centre lies in one of them. Parts of walls outside the grid are left out.
///
/// A wall at least two cells thick is tight, also against diagonal steps: a strip of that width cannot be crossed
/// without meeting a cell centre within it.
pub fn rasterize(grid: &Grid, walls: &[Wall]) -> SolidMask {
    let mut mask = SolidMask::open(grid.nx, grid.ny);
    for wall in walls {
        for segment in wall.segments_m() {
            let outline_m = wall.outline_m(segment);
            fill(&mut mask, grid, &outline_m, |point_m| {
                wall.beside(point_m, segment)
            });
        }
        let half_m = 0.5 * wall.thickness_m;
        for joint_m in wall.joints_m() {
            let corners_m =
                [-half_m, half_m].map(|shift_m| joint_m.map(|coordinate_m| coordinate_m + shift_m));
            fill(&mut mask, grid, &corners_m, |point_m| {
                wall.joins(point_m, joint_m)
            });
        }
    }
    mask
}

/// Makes solid the cells with a centre in a shape that `outline_m` surrounds.
fn fill(
    mask: &mut SolidMask,
    grid: &Grid,
    outline_m: &[[f64; 2]],
    inside: impl Fn([f64; 2]) -> bool,
) {
    let columns = cell_range(outline_m.iter().map(|point| point[0]), grid.dx_m, grid.nx);
    let rows = cell_range(outline_m.iter().map(|point| point[1]), grid.dx_m, grid.ny);
    for iy in rows {
        for ix in columns.clone() {
            if inside(cell_centre_m(grid, ix, iy)) {
                mask.cells[iy * grid.nx + ix] = true;
            }
        }
    }
}

/// The cells along one axis that the span of `coordinates_m` touches.
fn cell_range(coordinates_m: impl Iterator<Item = f64>, dx_m: f64, cells: usize) -> Range<usize> {
    let (low_m, high_m) = coordinates_m
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
    // A cast of a float saturates, so that walls far outside give an empty range.
    let first = (low_m / dx_m).floor().max(0.0) as usize;
    let last = (high_m / dx_m).ceil().max(0.0) as usize;
    first.min(cells)..last.saturating_add(1).min(cells)
}

/// Centre in metres of cell `(ix, iy)`.
pub fn cell_centre_m(grid: &Grid, ix: usize, iy: usize) -> [f64; 2] {
    [(ix as f64 + 0.5) * grid.dx_m, (iy as f64 + 0.5) * grid.dx_m]
}

/// The cell `(ix, iy)` that holds a point in metres; `None` outside the grid.
pub fn cell_at(grid: &Grid, point_m: [f64; 2]) -> Option<(usize, usize)> {
    let [x, y] = point_m.map(|coordinate_m| (coordinate_m / grid.dx_m).floor());
    let inside = x >= 0.0 && y >= 0.0 && x < grid.nx as f64 && y < grid.ny as f64;
    inside.then_some((x as usize, y as usize))
}
