//! Files: WAV, odometry, TUM trajectories, recording and map folders.

mod files;
pub mod json;
pub mod landmark_map;
pub mod map_folder;
pub mod odometry_csv;
pub mod recording_folder;
pub mod temporary;
pub mod tum;
pub mod wav;
