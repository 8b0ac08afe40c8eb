//! Rigid walls: polylines with a thickness, rasterized to solid cells.

pub mod operator;
mod rasterize;
mod wall;

pub use rasterize::{SolidMask, cell_at, cell_centre_m, rasterize};
pub use wall::Wall;
