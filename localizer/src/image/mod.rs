//! Images: echoes around the robot (eqs. (4)-(6)) and their sum over a drive, the map (eq. (7)).

pub(crate) mod bearing_index;
pub mod echo_image;
pub mod map_builder;
pub mod map_image;

pub use echo_image::ImageWindow;
pub use map_image::MapImage;
