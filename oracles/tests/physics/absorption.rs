//! Absorption on a recording of the field: a robot drives in front of a wall, sent twice, and its echo is attenuated
//! along its path.
//!
//! Layout: the rig of [`oracles::laws::corner`] with one of its walls, 0.15 s at 0.4 m/s, noise of 1.5 to 5 kHz; the
//! free-field run is subtracted. A loss of 0.26 dB/m at all frequencies, so that the exact result is a plain product.
//! Formula: the way by the image source at each instant, put into the straight line in tau that stands for the
//! exponential ([`fdtd::medium::absorbed`], where the line itself is held against the exponential).
//! Bias: the path is that of the moment of reception, not of the reflection: 1 mm; the change of tau during a period;
//! dispersion 0.1 %.
//! Tolerance: 0.01 dB and 0.2 % of a loss of 0.3 dB; image sources within 0.05 dB of the field.

use fdtd::medium::absorbed::Stamped;
use fdtd::simulation::{Flow, Simulation, SimulationOptions};
use fdtd::waveform::PeriodicWaveform;
use oracles::image_source::{DrivingPair, ImageSourceOptions, synthesize};
use oracles::laws::corner;
use oracles::laws::rig::{decibels, norm};
use oracles::laws::setting::{Setting, Turn};

/// Loss in nepers per metre of the papers' grid, the same at all frequencies: then the exact result is a plain product.
const ALPHA: f64 = 0.03;

#[test]
fn an_echo_of_the_field_loses_what_its_way_takes() {
    // The image is given by hand, for the wall on the right.
    let setting = Setting {
        turn: Turn::NONE,
        ..Setting::drawn("absorption", "m13")
    };
    let conditions = &setting.conditions;
    let (c_mps, alpha) = (conditions.medium.c_mps, ALPHA / conditions.m(1.0));
    let longest_m = fdtd::medium::absorbed::LONGEST_M;
    let mut scene = corner::scene(&setting, fdtd::scheme::Scheme::M13).expect("a valid scene");
    scene.walls[0].points_m = [[1.31, -0.2], [1.31, 2.0]]
        .map(|point| conditions.point(point))
        .to_vec();
    let chips: Vec<f64> = (0..1001_u64)
        .map(|k| {
            if (k * k * 31 + k * 7) % 1009 < 504 {
                1.0
            } else {
                -1.0
            }
        })
        .collect();
    let period_s = 1001.0 / scene.sample_rate_hz;
    let waveform = PeriodicWaveform::with_band(
        &chips,
        period_s,
        [1.5e3, 5e3].map(|hz| conditions.hz(hz)),
        1.0 / conditions.dt_s,
    );
    let hear = |free_field, stamped| -> Vec<f32> {
        let options = SimulationOptions {
            free_field,
            stamped,
            threads: 1,
            ..SimulationOptions::default()
        };
        let mut simulation =
            Simulation::new(&scene, "drive", &waveform, &options).expect("a valid scene");
        simulation
            .run(&mut |_, _| Flow::Continue)
            .expect("a finite field");
        simulation.signal()
    };
    let path = &scene.paths["drive"];
    let absorb = |plain: &[f32], stamped: &[f32]| {
        Stamped {
            plain,
            stamped,
            middle_s: 0.5 * path.duration_s(),
            sample_rate_hz: scene.sample_rate_hz,
        }
        .absorbed(c_mps, &|_| alpha)
    };
    let [walled, open] = [false, true].map(|free| {
        let plain = hear(free, false);
        let absorbed = absorb(&plain, &hear(free, true));
        [plain, absorbed]
    });
    // The straight line is not exact, but its value for the known path is.
    let [first, slope] = fdtd::medium::absorbed::straight_line(alpha * c_mps, longest_m / c_mps);
    let offsets = [
        scene.robot.loudspeaker_offset_m,
        scene.robot.microphone_offset_m,
    ];
    let (from, to) = (1400, 5600);
    let (mut recorded, mut expected) = (Vec::new(), Vec::new());
    for k in from..to {
        let t_s = k as f64 / scene.sample_rate_hz;
        let [[sx, sy], [rx, ry]] = offsets.map(|offset_m| path.point_at(t_s, offset_m));
        let way_m = (conditions.m(2.6) - sx - rx).hypot(sy - ry);
        let echo = |signals: usize| f64::from(walled[signals][k] - open[signals][k]);
        recorded.push(echo(1));
        expected.push(echo(0) * (first - slope * way_m / c_mps));
    }
    let level_db = decibels(norm(&recorded) / norm(&expected));
    let off: Vec<f64> = recorded.iter().zip(&expected).map(|(a, b)| a - b).collect();
    let waveform_off = norm(&off) / norm(&expected);
    println!("absorption on the field: level {level_db:+.4} dB, waveform {waveform_off:.5}");
    assert!(level_db.abs() < 0.01 && waveform_off < 2e-3);

    // By image sources the same.
    let drive = DrivingPair {
        path,
        loudspeaker_offset_m: offsets[0],
        microphone_offset_m: offsets[1],
    };
    let image = |stamped| {
        let options = ImageSourceOptions {
            stamped,
            ..ImageSourceOptions::default()
        };
        let rate_hz = scene.sample_rate_hz;
        let medium = &conditions.medium;
        synthesize(&scene.walls, &drive, &waveform, medium, rate_hz, &options)
    };
    let absorbed = absorb(&image(false), &image(true));
    let (found, field): (Vec<f64>, Vec<f64>) = (from..to)
        .map(|k| (f64::from(absorbed[k]), recorded[k - from]))
        .unzip();
    let level_db = decibels(norm(&found) / norm(&field));
    println!("image sources over field: {level_db:+.4} dB");
    assert!(level_db.abs() < 0.05);
}
