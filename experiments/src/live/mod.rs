//! Sound and odometry as they come, from bytes to numbers: what `echolot track` reads.

pub mod lines;
pub mod pcm;
