//! One echo along the drive: time of emission and gain of the sound that arrives.

use super::pair::{ONSET_S, PlanePair};
use super::spectrum::CylindricalWaveform;
use crate::rays::plane::{Vec2, dot, length, scale, sub};
use crate::rays::{Reflectors, fade};
use fdtd::grid::Medium;
use std::f64::consts::{PI, TAU};

/// Spacing of the times at which delays are solved, in seconds. Between them a cubic errs by less than a nanosecond at
/// a robot's accelerations.
const NODE_S: f64 = 1e-3;

/// Delay nodes per evaluation of the visibility.
const NODES_PER_VIEW: usize = 10;

/// Half the interval over which velocities are taken, in seconds.
const VELOCITY_S: f64 = 1e-4;

/// Shortest path with a finite level, in metres.
const NEAREST_M: f64 = 1e-3;

/// The delay and gain of one face sequence at evenly spaced times.
pub(super) struct EchoTrack {
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Default)]
struct Node {
    /// Time of emission of the sound that arrives at this node.
    sent_s: f64,
    /// Rate of `sent_s`: the Doppler time scale of the echo.
    rate: f64,
    /// Factor of the half derivative; 0 when the path is not visible.
    gain: f64,
    /// Factor of the half integral.
    near_gain: f64,
}

impl EchoTrack {
    /// Follows one face sequence over the drive; none when it is never visible.
    pub(super) fn new(
        reflectors: &Reflectors,
        sequence: &[usize],
        pair: &PlanePair<'_>,
        medium: &Medium,
        fade_m: f64,
    ) -> Option<Self> {
        let views = (pair.duration_s / (NODE_S * NODES_PER_VIEW as f64)).ceil() as usize + 2;
        let visible: Vec<f64> = (0..views)
            .map(|view| {
                visibility(
                    reflectors,
                    sequence,
                    pair,
                    (view * NODES_PER_VIEW) as f64 * NODE_S,
                    fade_m,
                )
            })
            .collect();
        if visible.iter().all(|&share| share == 0.0) {
            return None;
        }
        let image_at = |t_s: f64| reflectors.image(sequence, (pair.source_at)(t_s));
        let nodes = (0..(views - 1) * NODES_PER_VIEW)
            .map(|index| {
                let (view, within) = (index / NODES_PER_VIEW, index % NODES_PER_VIEW);
                if visible[view] == 0.0 && visible[view + 1] == 0.0 {
                    return Node::default();
                }
                let share = visible[view]
                    + (visible[view + 1] - visible[view]) * within as f64 / NODES_PER_VIEW as f64;
                node_at(index as f64 * NODE_S, share, pair, &image_at, medium)
            })
            .collect();
        Some(Self { nodes })
    }

    /// Adds the echo to samples that start with number `first` of the recording; with `stamp_zero_s` times the time of
    /// sending since then.
    pub(super) fn add_to(
        &self,
        sum: &mut [f64],
        first: usize,
        sample_rate_hz: f64,
        strength: &CylindricalWaveform,
        stamp_zero_s: Option<f64>,
    ) {
        for (offset, value) in sum.iter_mut().enumerate() {
            let position = (first + offset) as f64 / sample_rate_hz / NODE_S;
            let index = position as usize;
            let Some(&[before, after]) = self
                .nodes
                .get(index..index + 2)
                .and_then(|pair| pair.first_chunk())
            else {
                break;
            };
            let u = position - index as f64;
            let gain = before.gain + (after.gain - before.gain) * u;
            if gain == 0.0 {
                continue;
            }
            let sent_s = sent_between(&before, &after, u);
            if sent_s <= 0.0 {
                continue;
            }
            let near_gain = before.near_gain + (after.near_gain - before.near_gain) * u;
            let [derivative, integral] = strength.at(sent_s);
            let stamp = stamp_zero_s.map_or(1.0, |zero_s| sent_s - zero_s);
            *value += stamp * onset(sent_s) * (gain * derivative + near_gain * integral);
        }
    }
}

/// Cubic between two nodes; next to a node where the path is not visible only the other node's value and rate exist.
fn sent_between(before: &Node, after: &Node, u: f64) -> f64 {
    if before.rate == 0.0 {
        return after.sent_s - after.rate * NODE_S * (1.0 - u);
    }
    if after.rate == 0.0 {
        return before.sent_s + before.rate * NODE_S * u;
    }
    let rise = after.sent_s - before.sent_s;
    let (bend_before, bend_after) = (before.rate * NODE_S - rise, after.rate * NODE_S - rise);
    before.sent_s + u * rise + u * (1.0 - u) * (bend_before * (1.0 - u) - bend_after * u)
}

fn onset(sent_s: f64) -> f64 {
    if sent_s >= ONSET_S {
        1.0
    } else {
        0.5 - 0.5 * (PI * sent_s / ONSET_S).cos()
    }
}

/// Share of the path that walls let through at one time, 0..1.
fn visibility(
    reflectors: &Reflectors,
    sequence: &[usize],
    pair: &PlanePair<'_>,
    t_s: f64,
    fade_m: f64,
) -> f64 {
    let t_s = t_s.min(pair.duration_s);
    let (source_m, receiver_m) = ((pair.source_at)(t_s), (pair.receiver_at)(t_s));
    if sequence.is_empty() && length(sub(source_m, receiver_m)) < NEAREST_M {
        return 0.0;
    }
    let Some(unfolded) = reflectors.unfold(sequence, source_m, receiver_m, fade_m) else {
        return 0.0;
    };
    let on_faces = fade(unfolded.clearance_m, fade_m);
    if on_faces == 0.0 {
        return 0.0;
    }
    on_faces * reflectors.leg_transmission(sequence, &unfolded, fade_m)
}

fn node_at(
    t_s: f64,
    share: f64,
    pair: &PlanePair<'_>,
    image_at: &dyn Fn(f64) -> Vec2,
    medium: &Medium,
) -> Node {
    let receiver_m = (pair.receiver_at)(t_s);
    let (sent_s, apart_m) = sent_at(t_s, receiver_m, image_at, medium.c_mps);
    let towards = scale(apart_m, 1.0 / length(apart_m).max(NEAREST_M));
    let mach_source = dot(velocity(image_at, sent_s, pair.duration_s), towards) / medium.c_mps;
    let mach_receiver =
        dot(velocity(pair.receiver_at, t_s, pair.duration_s), towards) / medium.c_mps;
    let delay_s = (t_s - sent_s).max(NEAREST_M / medium.c_mps);
    let gain =
        share * medium.rho_kgpm3 / (2.0 * (TAU * delay_s).sqrt()) * (1.0 - mach_source).powf(-1.5);
    Node {
        sent_s,
        rate: (1.0 - mach_receiver) / (1.0 - mach_source),
        gain,
        near_gain: -gain / (8.0 * delay_s),
    }
}

/// Retarded time and the vector from the image then to the receiver now.
fn sent_at(t_s: f64, receiver_m: Vec2, image_at: &dyn Fn(f64) -> Vec2, c_mps: f64) -> (f64, Vec2) {
    let mut sent_s = t_s;
    let mut apart_m = sub(receiver_m, image_at(sent_s));
    // Each turn gains a factor of the Mach number; this many do for half the speed of sound.
    for _ in 0..60 {
        let next_s = t_s - length(apart_m) / c_mps;
        let change_s = (next_s - sent_s).abs();
        sent_s = next_s;
        apart_m = sub(receiver_m, image_at(sent_s));
        if change_s < 1e-12 {
            break;
        }
    }
    (t_s - length(apart_m) / c_mps, apart_m)
}

/// Velocity in m/s; one-sided at the ends of the drive, where a path may stand still beyond.
fn velocity(position_at: &dyn Fn(f64) -> Vec2, t_s: f64, duration_s: f64) -> Vec2 {
    let from_s = (t_s - VELOCITY_S).clamp(0.0, (duration_s - VELOCITY_S).max(0.0));
    let to_s = from_s + 2.0 * VELOCITY_S;
    let to_s = to_s.min(duration_s.max(from_s + VELOCITY_S));
    scale(
        sub(position_at(to_s), position_at(from_s)),
        1.0 / (to_s - from_s),
    )
}
