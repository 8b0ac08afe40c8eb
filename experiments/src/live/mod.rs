//! Sound and odometry as they come, from bytes to numbers: what `echolot track` reads.

#[cfg(feature = "audio")]
pub mod audio;
pub mod lines;
pub mod pcm;
