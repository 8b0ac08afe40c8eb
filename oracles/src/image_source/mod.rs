//! The signal of a moving loudspeaker and microphone among rigid walls by image sources: ray acoustics as an
//! independent check of the field, and a recording within seconds instead of minutes.
//!
//! Every face sequence up to `max_order` mirrors the loudspeaker's whole path. The echo at time `t` left its image at
//! the retarded time `t_e` with `c (t - t_e) = |x_r(t) - x_i(t_e)|`, and the pressure there is that of a moving line
//! source,
//! ```text
//! p(t) = rho / (2 sqrt(2 pi tau)) (1 - M_n)^(-3/2) [D^(1/2) q - 1/(8 tau) D^(-1/2) q](t_e),   tau = t - t_e
//! ```
//! with `M_n` the Mach number of the image towards the receiver. It leaves out diffraction: at the borders of a wall's
//! reflection and of its shadow an echo fades over a few centimetres instead of over its Fresnel zone.

mod pair;
pub mod room;
mod spectrum;
mod track;

pub use pair::{ImageSourceOptions, PlanePair, PositionAt};
pub use spectrum::CylindricalWaveform;

use crate::rays::Reflectors;
use fdtd::grid::Medium;
use fdtd::motion::DrivePath;
use fdtd::simulation::SOURCE_STRENGTH_M2PS;
use fdtd::walls::Wall;
use fdtd::waveform::PeriodicWaveform;
use pair::in_chunks;
use rayon::prelude::*;
use track::EchoTrack;

/// Pressure in Pa at the microphone of a moving pair: `floor(duration * sample_rate)` samples, the first at time 0. The
/// source is silent before time 0. The result does not depend on the number of threads.
pub fn synthesize_pair(
    reflectors: &Reflectors,
    pair: &PlanePair<'_>,
    strength: &CylindricalWaveform,
    medium: &Medium,
    sample_rate_hz: f64,
    options: &ImageSourceOptions,
) -> Vec<f32> {
    let mut sequences = reflectors.sequences(options.max_order);
    if options.include_direct {
        sequences.insert(0, Vec::new());
    }
    let tracks: Vec<EchoTrack> = sequences
        .par_iter()
        .filter_map(|sequence| EchoTrack::new(reflectors, sequence, pair, medium, options.fade_m))
        .collect();

    let zero_s = options.stamped.then_some(0.5 * pair.duration_s);
    in_chunks(pair.duration_s, sample_rate_hz, |first, out| {
        let mut sum = vec![0.0_f64; out.len()];
        for track in &tracks {
            track.add_to(&mut sum, first, sample_rate_hz, strength, zero_s);
        }
        for (sample, value) in out.iter_mut().zip(sum) {
            *sample = value as f32;
        }
    })
}

/// A robot on its drive.
#[derive(Debug, Clone, Copy)]
pub struct DrivingPair<'a> {
    /// Where the robot drives.
    pub path: &'a DrivePath,
    /// Loudspeaker in the robot's frame, `[forward, left]` in metres.
    pub loudspeaker_offset_m: [f64; 2],
    /// Microphone in the robot's frame, `[forward, left]` in metres.
    pub microphone_offset_m: [f64; 2],
}

/// Pressure in Pa at a robot's microphone along its whole drive among walls: see [`synthesize_pair`]. As in the field,
/// the source strength is the waveform times [`SOURCE_STRENGTH_M2PS`].
pub fn synthesize(
    walls: &[Wall],
    drive: &DrivingPair<'_>,
    waveform: &PeriodicWaveform,
    medium: &Medium,
    sample_rate_hz: f64,
    options: &ImageSourceOptions,
) -> Vec<f32> {
    let pair = PlanePair {
        source_at: &|t_s| drive.path.point_at(t_s, drive.loudspeaker_offset_m),
        receiver_at: &|t_s| drive.path.point_at(t_s, drive.microphone_offset_m),
        duration_s: drive.path.duration_s(),
    };
    let strength = CylindricalWaveform::of(waveform, SOURCE_STRENGTH_M2PS);
    synthesize_pair(
        &Reflectors::of(walls),
        &pair,
        &strength,
        medium,
        sample_rate_hz,
        options,
    )
}

#[cfg(test)]
mod tests;
