//! Files: WAV, odometry, TUM trajectories, recording and map folders.

pub mod description;
mod files;
pub mod json;
pub mod landmark_map;
pub mod map_folder;
pub mod odometry_csv;
pub mod recording_clocks;
pub mod recording_folder;
mod recording_meta;
pub mod recording_source;
pub mod sound_reader;
pub mod temporary;
pub mod tum;
pub mod wav;
