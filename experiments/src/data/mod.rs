//! Files of the results folder: atomic writes, the cache, and the data between what computes and what draws.

pub mod atomic;
pub mod cache;
pub mod field_frame;
pub mod layout;
pub mod peaks;
pub mod table;
