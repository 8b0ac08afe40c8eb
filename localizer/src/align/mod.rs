//! Alignment of a robot's recording: where a period begins in its sound, and how its clocks go.

mod acquisition;
mod alignment;
mod echo_clock;
mod follower;
mod log_clock;
mod replica;
mod report;
mod resampler;
mod sound;

pub use alignment::{Alignment, ClockSource, LogClock, SPEED_OF_SOUND_MPS};
pub use echo_clock::{PathKind, Tracks};
pub use log_clock::{Offset, match_logs, motion_of};
pub use report::{Gap, SoundClock, SoundReport};
pub use resampler::{Position, Resampler};
pub use sound::{Emit, SoundAligner};
