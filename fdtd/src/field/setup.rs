//! The constants of a field: scheme, layer, walls and surfaces on one grid.

use crate::boundary::{Surfaces, surfaces};
use crate::grid::{Grid, Medium};
use crate::pml::Profile;
use crate::scheme::{Scheme, Weights};
use crate::walls::WallCells;
use crate::walls::operator::WallOperator;

/// The constants of a field.
#[derive(Debug, Clone)]
pub struct FieldSetup {
    /// Cells along x.
    pub nx: usize,
    /// Cells along y.
    pub ny: usize,
    /// The scheme.
    pub scheme: Scheme,
    /// Its weights.
    pub weights: Weights,
    /// The absorbing layer on all four sides; zero cells for none (then the edge is pressure-free).
    pub layer: Profile,
    /// The operator near rigid walls.
    pub walls: WallOperator,
    /// Surfaces of walls of an impedance.
    pub surfaces: Surfaces,
}

impl FieldSetup {
    /// Setup of `grid` in `medium` with `scheme`, a layer of `layer_cells` and these walls.
    ///
    /// # Panics
    /// When the walls have another size than the grid, the step is unstable, or two layers would meet.
    pub fn new(
        grid: &Grid,
        medium: &Medium,
        scheme: Scheme,
        layer_cells: usize,
        walls: &WallCells,
    ) -> Self {
        assert_eq!(
            walls.size(),
            [grid.nx, grid.ny],
            "walls and grid differ in size"
        );
        let width = layer_cells.next_multiple_of(8);
        assert!(
            2 * width < grid.nx && 2 * layer_cells < grid.ny,
            "the absorbing layers meet"
        );
        let courant = grid.courant(medium);
        assert!(
            courant <= scheme.max_courant(),
            "Courant number {courant} over the stability limit"
        );
        let weights = scheme.weights(courant);
        let polynomial = scheme.polynomial(courant);
        let operator = WallOperator::new(walls, &weights, &polynomial, scheme.radius());
        Self {
            nx: grid.nx,
            ny: grid.ny,
            scheme,
            weights,
            layer: Profile::new(layer_cells, courant),
            surfaces: surfaces(walls, &operator, grid, medium, scheme),
            walls: operator,
        }
    }
}
