//! 2-D acoustic finite-difference time-domain simulation with perfectly matched layers, rigid walls and a moving
//! source and receiver by the direct method.

pub mod bessel;
pub mod boundary;
pub mod decimate;
pub mod error;
pub mod field;
pub mod grid;
pub mod impedance;
pub mod medium;
pub mod motion;
mod number;
pub mod pml;
pub mod scene;
pub mod scheme;
pub mod simulation;
pub mod spread;
pub mod walls;
pub mod waveform;

pub use error::Error;
