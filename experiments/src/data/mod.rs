//! Files of the results folder: atomic writes, the cache, and the data that studies write and figures read.

pub mod atomic;
pub mod cache;
pub mod field_frame;
pub mod layout;
pub mod peaks;
pub mod table;
