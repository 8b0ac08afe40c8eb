//! Files: WAV, odometry, TUM trajectories, recording and map folders.

mod files;
pub mod landmark_map;
pub mod map_folder;
pub mod odometry_csv;
pub mod recording_folder;
pub mod tum;
pub mod wav;
