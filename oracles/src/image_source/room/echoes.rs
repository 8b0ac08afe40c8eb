//! The signal of a moving loudspeaker and microphone in a [`Room`].
//!
//! The waveform w is the pressure at 1 m from the loudspeaker at rest:
//! `(1/c^2) p_tt - lap p = 4 pi w(t) delta(x - x_s(t))`. Sound that arrives at `t` left its image at the retarded time
//! `t_e` with `c (t - t_e) = |x_r(t) - x_i(t_e)| = r`, and
//! ```text
//! p(t) = g w(t_e) / (r (1 - M_n))
//! ```
//! exactly, with g the product of the faces' reflection factors and `M_n` the Mach number of the image towards the
//! receiver.

use rayon::prelude::*;

use super::super::pair::{ImageSourceOptions, in_chunks};
use super::faces::{Room, Vec3, dot};
use fdtd::waveform::PeriodicWaveform;

/// Spacing of the times at which delays are solved, in seconds. At 2 m/s^2, more than a robot does, the chord in
/// between is 3 ns off.
const NODE_S: f64 = 2e-3;

/// Delay nodes per evaluation of the visibility.
const NODES_PER_VIEW: usize = 10;

/// Half the interval over which velocities are taken, in seconds.
const VELOCITY_S: f64 = 1e-3;

/// A position in metres at any time in seconds; evaluated at times somewhat before 0 and after the end too.
pub type SpatialPositionAt<'a> = &'a (dyn Fn(f64) -> [f64; 3] + Sync);

/// A loudspeaker and a microphone that move in a room, slower than sound.
#[derive(Clone, Copy)]
pub struct RoomPair<'a> {
    /// Where the loudspeaker is.
    pub source_at: SpatialPositionAt<'a>,
    /// Where the microphone is.
    pub receiver_at: SpatialPositionAt<'a>,
    /// How long they are recorded, in seconds.
    pub duration_s: f64,
}

/// Pressure at the microphone, in the unit of the waveform at 1 m: `floor(duration * sample_rate)` samples, the first
/// at time 0. The source has sounded for ever, so that the first sample already holds all echoes. The result does not
/// depend on the number of threads.
pub fn synthesize(
    room: &Room,
    pair: &RoomPair<'_>,
    waveform: &PeriodicWaveform,
    c_mps: f64,
    sample_rate_hz: f64,
    options: &ImageSourceOptions,
) -> Vec<f32> {
    let sequences = room.sequences(options.max_order);
    let tracks: Vec<Vec<Node>> = sequences
        .par_iter()
        .filter(|sequence| options.include_direct || !sequence.is_empty())
        .filter_map(|sequence| track(room, sequence, pair, c_mps, options.fade_m))
        .collect();
    in_chunks(pair.duration_s, sample_rate_hz, |first, out| {
        for (offset, sample) in out.iter_mut().enumerate() {
            let place = (first + offset) as f64 / sample_rate_hz / NODE_S;
            let index = place as usize;
            let u = place - index as f64;
            let sum: f64 = tracks
                .iter()
                .map(|nodes| {
                    let (before, after) = (nodes[index], nodes[index + 1]);
                    let gain = before.gain + u * (after.gain - before.gain);
                    if gain == 0.0 {
                        return 0.0;
                    }
                    let sent_s = before.sent_s + u * (after.sent_s - before.sent_s);
                    gain * waveform.value(sent_s)
                })
                .sum();
            *sample = sum as f32;
        }
    })
}

/// Time of emission and gain of the sound that arrives at a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) sent_s: f64,
    pub(super) gain: f64,
}

/// Follows one face sequence over the drive; none when it never arrives.
pub(super) fn track(
    room: &Room,
    sequence: &[usize],
    pair: &RoomPair<'_>,
    c_mps: f64,
    fade_m: f64,
) -> Option<Vec<Node>> {
    let views = (pair.duration_s / (NODE_S * NODES_PER_VIEW as f64)).ceil() as usize + 2;
    let visible: Vec<f64> = (0..views)
        .map(|view| {
            let t_s = (view * NODES_PER_VIEW) as f64 * NODE_S;
            let (source_m, receiver_m) = ((pair.source_at)(t_s), (pair.receiver_at)(t_s));
            room.visibility(sequence, source_m, receiver_m, fade_m)
        })
        .collect();
    if visible.iter().all(|&share| share == 0.0) {
        return None;
    }
    let reflection = room.reflection.powi(sequence.len() as i32);
    let image_at = |t_s: f64| room.image(sequence, (pair.source_at)(t_s));
    let nodes = (0..(views - 1) * NODES_PER_VIEW)
        .map(|index| {
            let (view, within) = (index / NODES_PER_VIEW, index % NODES_PER_VIEW);
            let share = visible[view]
                + (visible[view + 1] - visible[view]) * within as f64 / NODES_PER_VIEW as f64;
            let t_s = index as f64 * NODE_S;
            let (sent_s, unit_gain) = heard_at(t_s, (pair.receiver_at)(t_s), &image_at, c_mps);
            Node {
                sent_s,
                gain: reflection * share * unit_gain,
            }
        })
        .collect();
    Some(nodes)
}

/// Retarded time, and the factor `1 / (r (1 - M_n))`.
fn heard_at(t_s: f64, receiver_m: Vec3, image_at: &dyn Fn(f64) -> Vec3, c_mps: f64) -> (f64, f64) {
    let apart = |sent_s: f64| -> Vec3 {
        let image = image_at(sent_s);
        std::array::from_fn(|i| receiver_m[i] - image[i])
    };
    let length = |v: Vec3| dot(v, v).sqrt();
    let mut sent_s = t_s;
    // Each turn gains a factor of the Mach number.
    for _ in 0..60 {
        let next_s = t_s - length(apart(sent_s)) / c_mps;
        let change_s = (next_s - sent_s).abs();
        sent_s = next_s;
        if change_s < 1e-13 {
            break;
        }
    }
    let ray = apart(sent_s);
    // A pair at one point has no direct wave of finite level; a millimetre bounds it.
    let r_m = length(ray).max(1e-3);
    let (before, after) = (image_at(sent_s - VELOCITY_S), image_at(sent_s + VELOCITY_S));
    let towards: f64 = (0..3)
        .map(|i| (after[i] - before[i]) / (2.0 * VELOCITY_S) * ray[i] / r_m)
        .sum();
    (sent_s, 1.0 / (r_m * (1.0 - towards / c_mps)))
}
