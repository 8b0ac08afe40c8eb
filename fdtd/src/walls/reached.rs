//! Walls that sound from given cells can meet. Cells deeper in walls or beyond closed walls need not be simulated.

use super::wall_cells::{WallCells, bounds};

/// Depth in cells along either axis to which the cells of a wall affect the air: the reach of the widest stencil, and
/// one more.
const DEPTH: usize = 4;

impl WallCells {
    /// Lowest and highest column and row of the cells of walls, down to [`DEPTH`], that sound from the cells `from`
    /// can reach; `None` when it reaches no wall. Solid cells and cells beyond the grid emit nothing; when all are
    /// such, all walls count.
    ///
    /// Sound is assumed to pass every face between two cells that are not solid: an upper bound.
    pub fn extent_met(&self, from: &[[usize; 2]]) -> Option<[[usize; 2]; 2]> {
        let [nx, ny] = self.size();
        let mut reached = vec![false; nx * ny];
        let mut ahead: Vec<usize> = (from.iter())
            .filter(|[ix, iy]| *ix < nx && *iy < ny)
            .map(|[ix, iy]| iy * nx + ix)
            .filter(|&cell| !self.solid().cells[cell])
            .collect();
        if ahead.is_empty() {
            reached.fill(true);
        }
        while let Some(cell) = ahead.pop() {
            if std::mem::replace(&mut reached[cell], true) {
                continue;
            }
            let (ix, iy) = (cell % nx, cell / nx);
            let beside = [
                (ix > 0).then(|| cell - 1),
                (ix + 1 < nx).then_some(cell + 1),
                (iy > 0).then(|| cell - nx),
                (iy + 1 < ny).then_some(cell + nx),
            ];
            let open = |&cell: &usize| !reached[cell] && !self.solid().cells[cell];
            ahead.extend(beside.into_iter().flatten().filter(open));
        }
        let near = widened(&reached, nx);
        let touched = (0..nx * ny).map(|cell| (cell % nx, cell / nx));
        bounds(touched.filter(|&(ix, iy)| near[iy * nx + ix] && self.is_touched(ix, iy)))
    }
}

/// The cells within [`DEPTH`] of those of `mask`, along both axes, in rows of `nx`.
fn widened(mask: &[bool], nx: usize) -> Vec<bool> {
    let ny = mask.len() / nx;
    let along_x: Vec<bool> = (0..mask.len())
        .map(|cell| {
            let (ix, row) = (cell % nx, cell - cell % nx);
            mask[row + ix.saturating_sub(DEPTH)..row + (ix + DEPTH + 1).min(nx)].contains(&true)
        })
        .collect();
    (0..mask.len())
        .map(|cell| {
            let (ix, iy) = (cell % nx, cell / nx);
            let mut rows = iy.saturating_sub(DEPTH)..(iy + DEPTH + 1).min(ny);
            rows.any(|y| along_x[y * nx + ix])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::rasterize::SolidMask;
    use super::*;

    /// A ring of solid cells 10 thick around air at 30..50 x 20..40, in 100 x 80 cells.
    fn ring() -> WallCells {
        let solid = |ix: usize, iy: usize| {
            let inside = |x, a, b| (a..b).contains(&x);
            inside(ix, 20, 60) && inside(iy, 10, 50) && !(inside(ix, 30, 50) && inside(iy, 20, 40))
        };
        let (nx, ny) = (100, 80);
        SolidMask {
            nx,
            ny,
            cells: (0..nx * ny)
                .map(|cell| solid(cell % nx, cell / nx))
                .collect(),
        }
        .into()
    }

    #[test]
    fn from_within_a_ring_only_its_inside_is_met() {
        let ring = ring();
        assert_eq!(ring.extent_met(&[[40, 30]]), Some([[26, 16], [53, 43]]));
        assert_eq!(ring.extent_met(&[[0, 0]]), Some([[20, 10], [59, 49]]));
        assert_eq!(ring.extent_met(&[[40, 30], [70, 60]]), ring.extent());
        // From inside a wall or beyond the grid alone, all walls count.
        assert_eq!(ring.extent_met(&[[25, 15], [100, 3]]), ring.extent());
        assert_eq!(WallCells::open(9, 9).extent_met(&[[4, 4]]), None);
    }

    #[test]
    fn a_door_lets_sound_out() {
        let mut mask = ring().solid().clone();
        for ix in 20..30 {
            mask.cells[30 * mask.nx + ix] = false;
        }
        let ring = WallCells::from(mask);
        assert_eq!(ring.extent_met(&[[40, 30]]), ring.extent());
    }

    #[test]
    fn widening_is_that_of_every_cell_by_itself() {
        let (nx, ny) = (17, 13);
        let mask: Vec<bool> = (0..nx * ny).map(|cell| cell % 71 == 5).collect();
        let near = |cell: usize| {
            let off = |a: usize, b: usize| a.abs_diff(b) <= DEPTH;
            (0..mask.len()).any(|other| {
                mask[other] && off(cell % nx, other % nx) && off(cell / nx, other / nx)
            })
        };
        let expected: Vec<bool> = (0..mask.len()).map(near).collect();
        assert_eq!(widened(&mask, nx), expected);
    }
}
