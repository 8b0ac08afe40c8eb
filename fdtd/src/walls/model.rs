//! Choice between the two representations of walls on the grid.

use super::cut_cells::cut;
use super::staircase::staircase;
use super::wall::Wall;
use super::wall_cells::WallCells;
use crate::grid::Grid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How walls become cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WallModel {
    /// Walls cut cells: a cell keeps the area that the walls leave open.
    #[default]
    CutCells,
    /// Cells whose centre is in a wall are solid, the others are whole.
    Staircase,
}

impl WallModel {
    /// Both, the default first.
    pub const ALL: [Self; 2] = [Self::CutCells, Self::Staircase];

    /// The name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::CutCells => "cut_cells",
            Self::Staircase => "staircase",
        }
    }

    /// The walls as cells of a grid.
    pub fn cells(self, grid: &Grid, walls: &[Wall]) -> WallCells {
        match self {
            Self::CutCells => cut(grid, walls),
            Self::Staircase => staircase(grid, walls),
        }
    }
}

impl std::fmt::Display for WallModel {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}
