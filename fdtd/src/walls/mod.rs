//! Rigid walls: polylines with a thickness, the grid cells that they leave, and the wave operator near them.
//!
//! Each file depends on files above it only:
//! * `wall`: geometry of a wall;
//! * `rasterize`: the mask of solid cells, by cell centres;
//! * `clip`: exact areas and lengths that convex shapes leave of cells and faces;
//! * `face_weights`: open parts of faces, and the weights that stability leaves them;
//! * `load`: surface elements of walls that carry an impedance (geometry only: [`crate::boundary`] designs their
//!   reaction);
//! * `slant`: changes of the operator in cells that slanted walls cut;
//! * `wall_cells`: all walls of a grid as cells;
//! * `cut_cells`, `staircase`: the two ways to get there; `model` chooses one;
//! * `reached`: walls that sound from a given place can meet;
//! * `patch`, [`operator`]: rows of the wave operator near walls.

mod clip;
mod cut_cells;
mod face_weights;
mod load;
mod model;
pub mod operator;
mod patch;
mod rasterize;
mod reached;
pub(crate) mod slant;
mod staircase;
mod wall;
mod wall_cells;

pub use crate::impedance::{Branch, Impedance};
pub use cut_cells::cut;
pub use load::Load;
pub use model::WallModel;
pub use rasterize::{SolidMask, cell_at, cell_centre_m, rasterize};
pub use wall::Wall;
pub use wall_cells::{CutCell, WallCells};
