//! The figures of the multipath paper: three models in a room, and one of them on the scene.

pub(crate) mod room;
pub(crate) mod scene;

mod models;
