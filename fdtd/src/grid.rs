//! Grid and medium of a simulation.
//!
//! The domain is `[0, nx*dx] x [0, ny*dx]` metres, x right, y up. Cell `(ix, iy)` has its centre at
//! `((ix + 0.5) dx, (iy + 0.5) dx)`; arrays are `[iy, ix]`, x fastest.

/// Size and step of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Cells along x.
    pub nx: usize,
    /// Cells along y.
    pub ny: usize,
    /// Cell width in metres, the same along x and y.
    pub dx_m: f64,
    /// Time step in seconds.
    pub dt_s: f64,
}

/// A homogeneous fluid at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium {
    /// Speed of sound in m/s.
    pub c_mps: f64,
    /// Density in kg/m^3.
    pub rho_kgpm3: f64,
}

impl Grid {
    /// Width and height of the domain in metres.
    pub fn size_m(&self) -> [f64; 2] {
        [self.nx as f64 * self.dx_m, self.ny as f64 * self.dx_m]
    }

    /// Courant number lambda = c dt / dx.
    pub fn courant(&self, medium: &Medium) -> f64 {
        medium.c_mps * self.dt_s / self.dx_m
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.nx * self.ny
    }

    /// Grid coordinates (in cells, cell centres at whole numbers) of a point in metres.
    pub fn to_cells(&self, point_m: [f64; 2]) -> [f64; 2] {
        [point_m[0] / self.dx_m - 0.5, point_m[1] / self.dx_m - 0.5]
    }
}
