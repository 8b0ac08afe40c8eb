//! Self-localization of a moving robot by the Doppler-resolved echoes of one loudspeaker and one microphone.
//!
//! The loudspeaker repeats a phase-modulated M-sequence; the robot drives; walls echo. The time scaling of an echo
//! depends on the angle between the heading and the direction of the wall (left and right remain ambiguous), its
//! delay on the distance. The stages follow section II of Jispin et al., 2024:
//!
//! | stage | equations | module |
//! |---|---|---|
//! | a robot's clocks and rates | | [`align`] |
//! | transmitted signal | II-A | [`signal::waveform`] |
//! | removal of the direct wave | II-A | [`signal::direct_wave`] |
//! | time scaling | (2) | [`signal::time_scale`] |
//! | matched filter and envelope | (1) | `signal::matched_filter` |
//! | Doppler bank: all of these for every direction | (1)-(3) | [`echo::doppler_bank`] |
//! | echo image around the robot | (4)-(6), (14)-(16) | [`image::echo_image`] |
//! | map image | (7) | [`image::map_image`] |
//! | motion model | (8) | [`filter::motion_model`] |
//! | likelihood | (9)-(14) | [`likelihood::mutual_information`] |
//! | particle filter | (8), (17), (18) | [`filter::particle_filter`] |
//! | resampling | | [`filter::resampling`] |
//!
//! [`mod@reference`] holds the same equations without shortcuts, as the oracle of the tests. [`multipath`] and
//! [`beacons`] are the methods of two papers of 2021.
//!
//! Two entries share the same code and give the same result: [`Localizer::step`] takes one period of samples at a time,
//! [`echo::measure`] followed by [`offline::localize`] takes a whole [`Recording`].
//!
//! ```
//! use std::path::Path;
//!
//! use localizer::image::map_builder;
//! use localizer::{Parameters, Recording, echo, offline};
//!
//! let mapping = Recording::read(Path::new("../examples/site_robot/mapping"))?;
//! let parameters = Parameters::default().for_recording(&mapping.meta);
//! let echoes = echo::measure(&mapping, &parameters)?;
//! let truth = mapping.truth.as_ref().ok_or("no truth.tum")?;
//! let map = map_builder::build(&[(&echoes, &echoes.poses(truth))])?;
//!
//! let drive = Recording::read(Path::new("../examples/site_robot/drive"))?;
//! let echoes = echo::measure(&drive, &parameters)?;
//! let estimates = offline::localize(&echoes, &map, &parameters, drive.start_pose(), 1)?;
//! let truth = drive.truth.as_ref().ok_or("no truth.tum")?;
//! let poses = echoes.poses(truth);
//! let error_m = |(estimate, pose): (&localizer::Estimate, _)| estimate.pose.distance_m(pose);
//! let sum_m: f64 = estimates.iter().zip(&poses).map(error_m).sum();
//! assert!(sum_m < 0.1 * poses.len() as f64);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Conventions: SI units, radians; x right, y up, headings counter-clockwise from +x; arrays are `[iy, ix]`; angles of
//! arrival are measured from the heading, 0 to pi; time 0 is the first sample of the first period.

pub mod align;
pub mod beacons;
pub mod echo;
pub mod error;
pub mod filter;
pub mod image;
pub mod io;
pub mod landmarks;
pub mod likelihood;
pub mod localizer;
pub mod memory;
pub mod multipath;
pub mod odometry;
pub mod offline;
pub mod parameters;
pub mod pose;
pub mod quality;
pub mod random;
pub mod recording;
pub mod reference;
pub mod signal;
mod simd;
pub mod slam;
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
