//! Self-localization of a moving robot by the Doppler-resolved echoes of one loudspeaker and one microphone.
//!
//! The loudspeaker repeats a phase-modulated M-sequence; the robot drives; walls echo. Every echo is time-scaled by a
//! factor that tells the angle between the heading and the wall it came from (the ambiguity between left and right
//! stays), and its delay tells the distance. The stages follow the paper, section II of Jispin et al., 2024:
//!
//! | stage | equations | module |
//! |---|---|---|
//! | transmit signal | II-A | [`signal::waveform`] |
//! | Doppler bank: resample, fold, correlate, envelope | (1)-(3) | [`echo::doppler_bank`] |
//! | echo image around the robot | (4)-(6), (14)-(16) | [`image::echo_image`] |
//! | map image | (7) | [`image::map_image`] |
//! | motion model | (8) | [`filter::motion_model`] |
//! | likelihood | (9)-(13) | [`likelihood::mutual_information`] |
//! | particle filter | (8), (17), (18) | [`filter::particle_filter`] |
//!
//! Two entries share the same code and give the same result: [`Localizer::step`] takes one period of samples at a time,
//! [`echo::measure`] followed by [`offline::localize`] takes a whole [`Recording`].
//!
//! Conventions: SI units, radians; x right, y up, headings counter-clockwise from +x; arrays are `[iy, ix]`; angles of
//! arrival are measured from the heading, 0 to pi; time 0 is the first sample of the first period.

pub mod beacons;
pub mod echo;
pub mod error;
pub mod filter;
mod fnv;
pub mod image;
pub mod io;
pub mod likelihood;
pub mod localizer;
pub mod multipath;
pub mod odometry;
pub mod offline;
pub mod parameters;
pub mod pose;
pub mod random;
pub mod recording;
pub mod reference;
pub mod signal;
mod simd;
pub mod trajectory;

pub use crate::localizer::Localizer;
pub use echo::{EchoBlock, EchoSequence};
pub use error::Error;
pub use filter::tracker::Estimate;
pub use image::MapImage;
pub use odometry::Odometry;
pub use parameters::{
    DirectWave, Integration, Method, Parameters, Resampling, TimeReference, ToaImage,
};
pub use pose::Pose;
pub use recording::Recording;
pub use trajectory::Trajectory;
