//! Files of the results folder: atomic writes, the cache, and the data that studies write and figures read.

pub mod atomic;
pub mod cache;
pub mod estimate;
pub mod field_frame;
pub mod frames;
pub mod json;
pub mod layout;
pub mod lease;
pub mod manifest;
pub(crate) mod map_place;
pub mod peaks;
pub mod place;
pub mod table;
