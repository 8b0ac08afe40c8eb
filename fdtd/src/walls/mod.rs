//! Walls: polylines with a thickness, and what they leave of the grid's cells.
//!
//! * `wall`: a wall as drawn;
//! * `rasterize`: whole solid cells, a staircase where the wall is slanted;
//! * `cut` (with `clip`): cells that keep the part that walls leave open;
//! * `faces`: weights of faces, and where walls of an impedance have their surface;
//! * `openings`: what all of it gives to the field; [`operator`] (with `patch`): the field's rows near walls;
//! * `reached`: which walls sound from a place can meet;
//! * `impedance`: the impedance of a wall's surface; `branches`: one of resistances, inertances and compliances, in steps;
//! * `surface`: what surfaces of an impedance do to the field; `column` with `aperture` (and `half_line`), and `footprint`
//!   (with `linear`): through which cells, before walls along the axes and others; `inertance`, `spring`: with how much
//!   mass; `slant`: what the operator does differently in cells that slanted ones cut.

mod aperture;
mod branches;
mod clip;
mod column;
mod cut;
mod faces;
mod footprint;
mod half_line;
mod impedance;
mod inertance;
mod linear;
mod model;
mod openings;
pub mod operator;
mod patch;
mod rasterize;
mod reached;
mod slant;
mod spring;
mod surface;
mod wall;

pub use branches::Branches;
pub use cut::cut;
pub use impedance::{Branch, Impedance};
pub use model::WallModel;
pub use openings::{Load, Opening, WallCells};
pub use rasterize::{SolidMask, cell_at, cell_centre_m, rasterize};
pub use surface::{Reaction, Surface};
pub use wall::Wall;
