//! The walls of a grid as cells: how much of every cell and of every face between cells is open.

use super::load::Load;
use super::rasterize::SolidMask;
use super::slant::{Slant, Slants};
use std::collections::BTreeMap;

/// Open fractions of a cell and of its faces to the cells at lower x and at lower y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutCell {
    /// Open part of the cell's area, above 0.
    pub area: f64,
    /// Weight of the face to the cell at lower x: its open part, or less where stability demands it.
    pub west: f64,
    /// Weight of the face to the cell at lower y.
    pub south: f64,
}

impl CutCell {
    /// A cell far from walls.
    pub const FULL: Self = Self {
        area: 1.0,
        west: 1.0,
        south: 1.0,
    };
}

/// The walls as cells: solid ones, and those of which a wall leaves a part.
///
/// A face is closed when either of its cells is solid. Outside the grid everything is open.
#[derive(Debug, Clone, PartialEq)]
pub struct WallCells {
    solid: SolidMask,
    /// By index `iy nx + ix`; a fluid cell that is not in here is full and has open faces to fluid cells.
    partial: BTreeMap<usize, CutCell>,
    /// Surface elements of walls of an impedance, in the order of the cells in which they lie.
    loads: Vec<Load>,
    /// Changes of the operator in cells that slanted walls cut.
    slants: Slants,
}

impl WallCells {
    /// From the solid cells and the cut cells of others by their index `iy nx + ix`.
    pub(super) fn new(solid: SolidMask, mut partial: BTreeMap<usize, CutCell>) -> Self {
        partial.retain(|&cell, cut| !solid.cells[cell] && *cut != CutCell::FULL);
        Self {
            solid,
            partial,
            loads: Vec::new(),
            slants: Slants::new(),
        }
    }

    /// The same with surface elements of walls of an impedance.
    pub(super) fn with_loads(self, loads: Vec<Load>) -> Self {
        Self { loads, ..self }
    }

    /// The same with the changes that slanted walls make ([`super::slant`]).
    pub(super) fn with_slants(self, slants: Slants) -> Self {
        Self { slants, ..self }
    }

    /// Changes in a cell of any place, if a slanted wall cuts it.
    pub(super) fn slant(&self, ix: isize, iy: isize) -> Option<&Slant> {
        (self.solid.index(ix, iy)).and_then(|cell| self.slants.get(&cell))
    }

    /// The surface elements of walls of an impedance, in the order of the cells in which they lie.
    pub fn loads(&self) -> &[Load] {
        &self.loads
    }

    /// A grid without walls.
    pub fn open(nx: usize, ny: usize) -> Self {
        SolidMask::open(nx, ny).into()
    }

    /// Lowest and highest column and row that walls touch; `None` without walls.
    pub fn extent(&self) -> Option<[[usize; 2]; 2]> {
        let nx = self.solid.nx;
        let partial = self.partial.keys().map(|cell| (cell % nx, cell / nx));
        bounds(self.solid.iter_solid().chain(partial))
    }

    /// The walls within a part of the grid of `nx` by `ny` cells that begins at column and row `first`.
    ///
    /// # Panics
    /// When the part reaches beyond the grid.
    pub fn window(&self, first: [usize; 2], [nx, ny]: [usize; 2]) -> Self {
        let [x, y] = first;
        assert!(
            x + nx <= self.solid.nx && y + ny <= self.solid.ny,
            "a part of the grid"
        );
        let mut solid = SolidMask::open(nx, ny);
        for (row, cells) in solid.cells.chunks_exact_mut(nx).enumerate() {
            let begin = (y + row) * self.solid.nx + x;
            cells.copy_from_slice(&self.solid.cells[begin..begin + nx]);
        }
        let place = |[ix, iy]: [usize; 2]| {
            let holds = (x..x + nx).contains(&ix) && (y..y + ny).contains(&iy);
            holds.then(|| [ix - x, iy - y])
        };
        let moved = |cell: usize| {
            let [ix, iy] = place([cell % self.solid.nx, cell / self.solid.nx])?;
            Some(iy * nx + ix)
        };
        let partial = self
            .partial
            .iter()
            .filter_map(|(&cell, &cut)| Some((moved(cell)?, cut)));
        let loads = self.loads.iter().filter_map(|load| {
            Some(Load {
                cell: place(load.cell)?,
                ..load.clone()
            })
        });
        let slants = self.slants.iter();
        Self {
            solid,
            partial: partial.collect(),
            loads: loads.collect(),
            slants: slants
                .filter_map(|(&cell, &slant)| Some((moved(cell)?, slant)))
                .collect(),
        }
    }

    /// Cells along x and y.
    pub fn size(&self) -> [usize; 2] {
        [self.solid.nx, self.solid.ny]
    }

    /// The cells that hold no air.
    pub fn solid(&self) -> &SolidMask {
        &self.solid
    }

    /// The cells of which a wall leaves a part, by index `iy nx + ix`, in order.
    pub fn partial(&self) -> impl Iterator<Item = (usize, &CutCell)> {
        self.partial.iter().map(|(&cell, cut)| (cell, cut))
    }

    /// Whether a wall takes the cell or a part of it or of its faces at lower x and y; not so outside the grid.
    pub fn is_touched(&self, ix: usize, iy: usize) -> bool {
        self.solid.is_solid(ix, iy)
            || (ix < self.solid.nx && self.partial.contains_key(&(iy * self.solid.nx + ix)))
    }

    /// Open area fraction of every cell, `[iy, ix]`, x fastest: the weights of the inner product in which the wave
    /// operator is symmetric.
    pub fn areas(&self) -> Vec<f64> {
        let solid = self.solid.cells.iter();
        let mut areas: Vec<f64> = solid.map(|&solid| f64::from(u8::from(!solid))).collect();
        for (&cell, cut) in &self.partial {
            areas[cell] = cut.area;
        }
        areas
    }

    /// The neighbour of a cell along an axis on a side (-1 or 1), if it lies on the grid and the face between them is
    /// open.
    pub(crate) fn beside(
        &self,
        [ix, iy]: [usize; 2],
        axis: usize,
        side: isize,
    ) -> Option<[usize; 2]> {
        let [nx, ny] = self.size();
        let mut place = [ix as isize, iy as isize];
        place[axis] += side;
        let [x, y] = place;
        let inside = x >= 0 && y >= 0 && (x as usize) < nx && (y as usize) < ny;
        let there = self.cut_cell(x, y).filter(|_| inside)?;
        let upper = if side > 0 {
            there
        } else {
            self.cut_cell(ix as isize, iy as isize)?
        };
        let face = if axis == 0 { upper.west } else { upper.south };
        (face > 0.0).then_some([x as usize, y as usize])
    }

    /// Open fractions of a cell at any place, full outside the grid; none for a solid cell. Faces to solid
    /// cells are closed.
    pub(crate) fn cut_cell(&self, ix: isize, iy: isize) -> Option<CutCell> {
        let mask = &self.solid;
        let solid = |x, y| mask.index(x, y).is_some_and(|cell| mask.cells[cell]);
        if solid(ix, iy) {
            return None;
        }
        let partial = mask.index(ix, iy).and_then(|cell| self.partial.get(&cell));
        let mut cut = partial.copied().unwrap_or(CutCell::FULL);
        if solid(ix - 1, iy) {
            cut.west = 0.0;
        }
        if solid(ix, iy - 1) {
            cut.south = 0.0;
        }
        Some(cut)
    }

    /// Bridges past the cells of a window that begins at `first`, `width` cells along a side: places of their ends in
    /// the window, which may lie just outside, and their weights for a scheme with `spare`
    /// ([`crate::scheme::Polynomial::spare`]).
    pub(crate) fn bridges(
        &self,
        first: [isize; 2],
        width: usize,
        spare: f64,
    ) -> Vec<([[isize; 2]; 2], f64)> {
        let area = |[x, y]: [isize; 2]| {
            let cut = self.cut_cell(first[0] + x, first[1] + y);
            cut.map_or(1.0, |cut| cut.area)
        };
        let places = (0..width as isize).flat_map(|y| (0..width as isize).map(move |x| [x, y]));
        places
            .filter_map(|[x, y]| {
                let bridge = self.slant(first[0] + x, first[1] + y)?.bridge?;
                let ends = bridge.ends([x, y]);
                Some((ends, bridge.stable_weight(spare, ends.map(area))))
            })
            .collect()
    }
}

/// Lowest and highest column and row of some cells; `None` without any.
pub(super) fn bounds(cells: impl Iterator<Item = (usize, usize)>) -> Option<[[usize; 2]; 2]> {
    cells.fold(None, |extent, (ix, iy)| {
        let [low, high] = extent.unwrap_or([[ix, iy]; 2]);
        Some([
            [low[0].min(ix), low[1].min(iy)],
            [high[0].max(ix), high[1].max(iy)],
        ])
    })
}

impl From<SolidMask> for WallCells {
    /// Whole cells only: the staircase.
    fn from(solid: SolidMask) -> Self {
        Self {
            solid,
            partial: BTreeMap::new(),
            loads: Vec::new(),
            slants: Slants::new(),
        }
    }
}
