//! Domain: convex rooms with plain faces; formulas: image sources, the Doppler factor of a plane wall ([`plane_wall`]).

use super::echoes::track;
use super::*;
use crate::exact::time_scale::plane_wall;
use crate::image_source::ImageSourceOptions;
use fdtd::waveform::PeriodicWaveform;

const C_MPS: f64 = 346.0;
const RATE_HZ: f64 = 40e3;

fn shoebox(size_m: [f64; 3], reflection: f64) -> Room {
    let [x, y, z] = size_m;
    Room::new(&[[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]], z, reflection).unwrap()
}

/// Images of a shoebox by its lattice: every image of up to `order` reflections once, as (distance, number of
/// reflections).
fn lattice(size_m: [f64; 3], source: [f64; 3], receiver: [f64; 3], order: i32) -> Vec<(f64, i32)> {
    // Cell k of one axis holds the image at k L + x for even k, k L + L - x for odd k, after |k| reflections.
    let at = |k: i32, axis: usize| {
        let cell = f64::from(k) * size_m[axis];
        if k % 2 == 0 {
            cell + source[axis]
        } else {
            cell + size_m[axis] - source[axis]
        }
    };
    let mut found = Vec::new();
    for i in -order..=order {
        for j in -order..=order {
            for k in -order..=order {
                let count = i.abs() + j.abs() + k.abs();
                if count <= order {
                    let image = [at(i, 0), at(j, 1), at(k, 2)];
                    let r = (0..3)
                        .map(|a| (image[a] - receiver[a]).powi(2))
                        .sum::<f64>();
                    found.push((r.sqrt(), count));
                }
            }
        }
    }
    found
}

/// A pulse of a few samples' width, so that arrivals are separate: harmonics with a Gaussian spectrum.
fn pulse() -> PeriodicWaveform {
    let samples: Vec<f64> = (0..4000)
        .map(|k| (-((f64::from(k) - 200.0) / 4.0).powi(2)).exp())
        .collect();
    PeriodicWaveform::new(&samples, 0.1, 19e3, RATE_HZ)
}

/// Tolerance 2e-3 of the pulse at 1 m: its band limit. A source off all planes of symmetry keeps every path far from
/// borders of visibility.
#[test]
fn a_static_pair_hears_every_image_of_the_lattice_once() {
    let (size, source, receiver) = ([4.1, 5.3, 2.6], [1.23, 2.17, 0.4], [1.31, 2.02, 0.9]);
    let reflection = 0.8;
    let room = shoebox(size, reflection);
    let signal = synthesize(
        &room,
        &RoomPair {
            source_at: &|_| source,
            receiver_at: &|_| receiver,
            duration_s: 0.1,
        },
        &pulse(),
        C_MPS,
        RATE_HZ,
        &ImageSourceOptions {
            max_order: 3,
            include_direct: true,
            fade_m: 1e-6,
            stamped: false,
        },
    );
    assert_eq!(signal.len(), 4000);
    let images = lattice(size, source, receiver, 3);
    assert_eq!(images.len(), 63);
    for (index, &recorded) in signal.iter().enumerate() {
        let expected: f64 = images
            .iter()
            .map(|&(r, count)| {
                let late = index as f64 - 200.0 - r / C_MPS * RATE_HZ;
                reflection.powi(count) / r * (-(late / 4.0).powi(2)).exp()
            })
            .sum();
        assert!(
            (f64::from(recorded) - expected).abs() < 2e-3,
            "sample {index}: {recorded} instead of {expected}"
        );
    }
}

/// A pair at 10 m/s, angle 0.7 from the wall's normal: the sending time advances at the exact rate, to 1e-9.
#[test]
fn a_wall_scales_the_time_of_a_moving_pair_by_the_exact_factor() {
    let room = shoebox([40.0, 40.0, 20.0], 1.0);
    let (v, theta) = (10.0_f64, 0.7_f64);
    let drive = |t_s: f64| {
        [
            20.0 + v * theta.cos() * t_s,
            15.0 + v * theta.sin() * t_s,
            8.0,
        ]
    };
    let pair = RoomPair {
        source_at: &drive,
        receiver_at: &drive,
        duration_s: 0.5,
    };
    // Face 1 is the wall at x = 40 m.
    let nodes = track(&room, &[1], &pair, C_MPS, 1e-3).unwrap();
    let rate = (nodes[200].sent_s - nodes[50].sent_s) / (150.0 * 2e-3);
    let expected = plane_wall(v / C_MPS, theta);
    assert!((rate - expected).abs() < 1e-9, "{rate} {expected}");
    // The image comes nearer by v cos(theta) towards the receiver, to first order: 1/(r (1 - M cos)).
    let delay_s = 100.0 * 2e-3 - nodes[100].sent_s;
    let gain = 1.0 / (C_MPS * delay_s * (1.0 - v * theta.cos() / C_MPS));
    assert!((nodes[100].gain / gain - 1.0).abs() < 3e-3);
}

#[test]
fn in_an_obtuse_corner_the_double_echo_is_not_heard_and_opposite_orders_share_a_right_one() {
    // Regular hexagon of side 3 m: neighbouring walls meet at 120 degrees.
    let corners: Vec<[f64; 2]> = (0..6)
        .map(|k| (f64::from(k) * std::f64::consts::FRAC_PI_3).sin_cos())
        .map(|(sin, cos)| [3.0 * cos, 3.0 * sin])
        .collect();
    let hexagon = Room::new(&corners, 3.0, 1.0).unwrap();
    let at = [0.4, 0.3, 1.0];
    assert_eq!(hexagon.visibility(&[0], at, at, 0.01), 1.0);
    assert_eq!(hexagon.visibility(&[0, 1], at, at, 0.01), 0.0);
    assert_eq!(hexagon.visibility(&[0, 3], at, at, 0.01), 1.0);
    let room = shoebox([4.0, 5.0, 2.5], 1.0);
    let (source, receiver) = ([1.0, 1.1, 0.4], [1.05, 1.0, 0.4]);
    let both = [[0, 3], [3, 0]].map(|pair| room.visibility(&pair, source, receiver, 1e-3));
    assert_eq!(both[0] + both[1], 1.0);
}

#[test]
fn rooms_that_are_none_are_refused() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let clockwise: Vec<[f64; 2]> = square.iter().rev().copied().collect();
    for (corners, height, reflection, word) in [
        (&clockwise[..], 2.0, 0.9, "corners_m"),
        (&square[..2], 2.0, 0.9, "corners_m"),
        (&square[..], 0.0, 0.9, "height_m"),
        (&square[..], 2.0, 1.5, "reflection"),
    ] {
        let message = Room::new(corners, height, reflection)
            .unwrap_err()
            .to_string();
        assert!(message.contains(word), "{message}");
    }
    assert_eq!(Room::new(&square, 2.0, 0.9).unwrap().sequences(2).len(), 37);
}
