//! Whole solid cells: a staircase where a wall is slanted.

use super::face_weights::FaceWeights;
use super::load::{impedance_cells, loads};
use super::rasterize::rasterize;
use super::wall::Wall;
use super::wall_cells::WallCells;
use crate::grid::Grid;
use std::collections::{BTreeMap, BTreeSet};

/// Walls as whole cells: those with their centre in a wall are solid.
pub(super) fn staircase(grid: &Grid, walls: &[Wall]) -> WallCells {
    let solid = rasterize(grid, walls);
    let mut owners = BTreeMap::new();
    if walls.iter().any(|wall| wall.impedance.is_some()) {
        for (index, wall) in walls.iter().enumerate() {
            let own = rasterize(grid, std::slice::from_ref(wall));
            owners.extend(own.iter_solid().map(|(ix, iy)| (iy * grid.nx + ix, index)));
        }
    }
    let cells = impedance_cells(walls, &owners, &solid);
    let faces = FaceWeights {
        solid: &solid,
        near: &BTreeMap::new(),
        areas: &BTreeMap::new(),
        slivers: &BTreeSet::new(),
    };
    let loads = loads(&faces, grid, walls, &cells);
    WallCells::from(solid).with_loads(loads)
}
