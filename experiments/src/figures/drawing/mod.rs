//! Tools of the figures: canvas, axes, legends, colours and styles.

pub mod axes;
pub mod axis;
pub mod canvas;
pub mod colour;
pub mod layout;
pub mod legend;
pub mod png;
pub mod stroke;
pub(crate) mod style;
mod svg;
