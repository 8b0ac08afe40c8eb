//! The domain of a run: the scene's, or an open one cropped to the drive.
//!
//! Absorbing layers stand for air without end, and it is the same wherever they begin: so air beyond walls and drive
//! costs nothing.

use super::options::SimulationOptions;
use crate::error::Error;
use crate::field::FieldSetup;
use crate::grid::{Grid, Medium};
use crate::scene::Scene;
use crate::scheme::Scheme;
use crate::spread::Spread;
use crate::walls::WallCells;

/// Cells kept between walls or a drive and the absorbing layer.
const CLEARANCE_CELLS: usize = 12;

/// A domain to simulate, in its parts, as [`Simulation::new`](super::Simulation::new) derives it from a scene.
#[derive(Debug, Clone)]
pub struct Domain {
    /// Grid and step.
    pub grid: Grid,
    /// The air.
    pub medium: Medium,
    /// Scheme.
    pub scheme: Scheme,
    /// Spreading kernel.
    pub spread: Spread,
    /// Width of the absorbing layers in cells.
    pub layer_cells: usize,
    /// Rigid walls.
    pub walls: WallCells,
}

impl Domain {
    /// The scene's domain with the choices of a run, without walls for a free field.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the step is unstable.
    pub(super) fn of(scene: &Scene, options: &SimulationOptions) -> Result<Self, Error> {
        let scheme = options.scheme.unwrap_or(scene.scheme);
        let grid = scene.grid;
        if grid.courant(&scene.medium) > scheme.max_courant() {
            let largest = scheme.max_courant() * grid.dx_m / scene.medium.c_mps;
            return Err(Error::invalid(
                &scene.name,
                "grid.dt_s",
                format!("{:e} s is over the stability limit of {scheme}", grid.dt_s),
                format!("the largest stable step is {largest:e} s"),
            ));
        }
        let walls = if options.free_field {
            WallCells::open(grid.nx, grid.ny)
        } else {
            let model = options.wall_model.unwrap_or(scene.wall_model);
            model.cells(&grid, &scene.walls)
        };
        Ok(Self {
            grid,
            medium: scene.medium,
            scheme,
            spread: options.spread.unwrap_or(scene.spread),
            layer_cells: scene.layer_cells,
            walls,
        })
    }

    /// The constants of the field of all of it.
    ///
    /// # Panics
    /// As [`FieldSetup::new`].
    pub(super) fn setup(&self) -> FieldSetup {
        FieldSetup::new(
            &self.grid,
            &self.medium,
            self.scheme,
            self.layer_cells,
            &self.walls,
        )
    }

    /// Crops an open domain to the drive, its clearance and the layer; returns the new origin in metres, a whole number
    /// of cells, so that points keep their place within a cell.
    pub(super) fn crop(
        &mut self,
        duration_s: f64,
        points: &dyn Fn(f64) -> [[f64; 2]; 2],
    ) -> [f64; 2] {
        let extent = Extent::of_drive(&self.grid, duration_s, points);
        let margin = self.margin_cells();
        let first = extent
            .low
            .map(|x| (x.floor() as usize).saturating_sub(margin));
        let grid = self.grid;
        let end = [
            (extent.high[0].ceil() as usize + margin).min(grid.nx),
            (extent.high[1].ceil() as usize + margin).min(grid.ny),
        ];
        // Whole vectors make full use of the engine.
        self.grid.nx = (end[0] - first[0]).next_multiple_of(8);
        self.grid.ny = end[1] - first[1];
        self.walls = WallCells::open(self.grid.nx, self.grid.ny);
        first.map(|cells| cells as f64 * grid.dx_m)
    }

    /// Cells between a free-field drive and the edge: kernel, clearance and layer.
    pub(super) fn margin_cells(&self) -> usize {
        self.wall_margin_cells() + self.spread.reach_cells()
    }

    /// Cells between walls and the edge: clearance and layer.
    pub(super) fn wall_margin_cells(&self) -> usize {
        self.layer_cells.next_multiple_of(8) + CLEARANCE_CELLS
    }
}

/// Where a drive goes, in cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    pub(super) low: [f64; 2],
    pub(super) high: [f64; 2],
}

impl Default for Extent {
    /// That of no points.
    fn default() -> Self {
        Self {
            low: [f64::INFINITY; 2],
            high: [f64::NEG_INFINITY; 2],
        }
    }
}

impl Extent {
    /// That of a drive through `points` (metres) at a time in seconds.
    pub(super) fn of_drive(
        grid: &Grid,
        duration_s: f64,
        points: &dyn Fn(f64) -> [[f64; 2]; 2],
    ) -> Self {
        let mut extent = Self::default();
        let instants = (duration_s / 0.005).ceil().max(1.0);
        for k in 0..=instants as usize {
            extent.add(grid, points(duration_s * k as f64 / instants));
        }
        extent
    }

    /// Grows to hold points in metres.
    pub(super) fn add(&mut self, grid: &Grid, points_m: [[f64; 2]; 2]) {
        for point in points_m.map(|point| grid.to_cells(point)) {
            self.join(&Self {
                low: point,
                high: point,
            });
        }
    }

    /// Grows to hold another extent.
    pub(super) fn join(&mut self, other: &Self) {
        for axis in 0..2 {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
    }

    /// The longer of its two sides.
    pub(super) fn width(&self) -> f64 {
        (self.high[0] - self.low[0]).max(self.high[1] - self.low[1])
    }
}
