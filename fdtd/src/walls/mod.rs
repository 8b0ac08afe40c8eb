//! Walls: polylines with a thickness, and what they leave of the grid's cells.
//!
//! * `wall`: a wall as drawn;
//! * `rasterize`: whole solid cells, a staircase where the wall is slanted;
//! * `cut` (with `clip`): cells that keep the part that walls leave open;
//! * `surface`: weights of faces, and walls of an impedance;
//! * `openings`: what all of it gives to the field; [`operator`]: the field's rows near walls.

mod clip;
mod cut;
mod model;
mod openings;
pub mod operator;
mod rasterize;
mod surface;
mod wall;

pub use cut::cut;
pub use model::WallModel;
pub use openings::{Load, Opening, WallCells};
pub use rasterize::{SolidMask, cell_at, cell_centre_m, rasterize};
pub use wall::Wall;
