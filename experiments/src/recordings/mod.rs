//! Recordings of simulated drives: the scene's waveform through a field or image sources, with odometry, truth and the
//! instruments of a robot.

pub mod fingerprint;
pub mod impulse_snapshot;
pub mod key;
pub mod multipath_room;
pub mod noise;
pub mod preflight;
pub mod recording;
pub mod robot;
pub mod simulate;
pub mod sound_card;
pub mod spec;
pub mod ultrasound;
pub mod waveform;

pub use self::simulate::{Checkpoint, RunOptions, Snapshots};
pub use self::spec::{Engine, RecordingSpec};
