//! Self-localization of a moving robot by the Doppler-resolved echoes of one loudspeaker and one microphone.
//!
//! The loudspeaker repeats a phase-modulated M-sequence; the robot drives; walls echo. Every echo is time-scaled by a
//! factor that tells the angle between the heading and the wall it came from (the ambiguity between left and right
//! stays), and its delay tells the distance. The stages follow the paper, section II of Jispin et al., 2024:
//!
//! | stage | equations | module |
//! |---|---|---|
//! | transmit signal | II-A | [`waveform`] |
//! | Doppler bank: resample, fold, correlate, envelope | (1)-(3) | [`doppler`] |
//! | echo image around the robot | (4)-(6), (14)-(16) | [`echo_image`] |
//! | map image | (7) | [`map_image`] |
//! | motion model | (8) | [`dead_reckoning`] |
//! | likelihood | (9)-(13) | [`mutual_information`] |
//! | particle filter | (8), (17), (18) | [`particle_filter`] |
//!
//! Two entries share the same code and give the same result: [`Localizer::step`] takes one period of samples at a time,
//! [`echoes::measure`] followed by [`offline::localize`] takes a whole [`Recording`].
//!
//! Conventions: SI units, radians; x right, y up, headings counter-clockwise from +x; arrays are `[iy, ix]`; angles of
//! arrival are measured from the heading, 0 to pi; time 0 is the first sample of the first period.

pub mod beacons;
mod bearings;
mod blocks;
mod correlation;
mod crops;
pub mod dead_reckoning;
pub mod direct_wave;
pub mod doppler;
pub mod echo_image;
pub mod echoes;
pub mod error;
mod files;
pub mod localizer;
pub mod map_folder;
pub mod map_image;
mod matcher;
pub mod multipath;
pub mod mutual_information;
pub mod noisy;
pub mod offline;
pub mod parameters;
pub mod particle_filter;
pub mod pose;
pub mod random;
pub mod receiver;
pub mod recording;
pub mod reference;
pub mod resample;
pub mod resampling;
mod sheets;
pub mod tracker;
pub mod trajectory;
pub mod waveform;
mod wide;

pub use crate::localizer::Localizer;
pub use echoes::{EchoBlock, EchoSequence};
pub use error::Error;
pub use map_image::MapImage;
pub use parameters::{
    DirectWave, Integration, Method, MotionModel, Parameters, Resampling, TimeReference, ToaImage,
};
pub use pose::{Odometry, Pose};
pub use recording::Recording;
pub use tracker::Estimate;
pub use trajectory::Trajectory;
