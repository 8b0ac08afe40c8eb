use super::*;
use crate::laws::conditions::CONDITIONS;
use crate::rays::WallSegment;
use std::f64::consts::{FRAC_PI_4, TAU};

const AIR: Medium = CONDITIONS[1].medium;
const RATE_HZ: f64 = 40e3;

fn wall(ends_m: [[f64; 2]; 2]) -> WallSegment {
    WallSegment {
        wall: 0,
        piece: 0,
        ends_m,
        thickness_m: 0.0,
    }
}

fn tone(frequency_hz: f64) -> CylindricalWaveform {
    let samples: Vec<f64> = (0..6000)
        .map(|k| (TAU * frequency_hz * 0.01 * f64::from(k) / 6000.0).cos())
        .collect();
    CylindricalWaveform::new(&samples, 0.01)
}

/// Complex amplitude of the signal's line at `frequency_hz`, from `from_s` on, as (magnitude, phase).
fn line(signal: &[f32], frequency_hz: f64, from_s: f64) -> (f64, f64) {
    let first = (from_s * RATE_HZ) as usize;
    let (mut re, mut im) = (0.0, 0.0);
    for (k, &sample) in signal.iter().enumerate().skip(first) {
        let phase = TAU * frequency_hz * k as f64 / RATE_HZ;
        re += f64::from(sample) * phase.cos();
        im -= f64::from(sample) * phase.sin();
    }
    let half = 0.5 * (signal.len() - first) as f64;
    ((re / half).hypot(im / half), im.atan2(re))
}

#[test]
fn an_echo_at_rest_has_the_level_and_phase_of_the_hankel_function() {
    let walls = Reflectors::new([wall([[2.0, -3.0], [2.0, 3.0]])]);
    let rest = |_: f64| [0.5, 0.0];
    let pair = PlanePair {
        source_at: &rest,
        receiver_at: &rest,
        duration_s: 0.05,
    };
    let omega = TAU * 5e3;
    let signal = synthesize_pair(
        &walls,
        &pair,
        &tone(5e3),
        &AIR,
        RATE_HZ,
        &ImageSourceOptions::default(),
    );
    assert_eq!(signal.len(), 2000);
    let (level, phase) = line(&signal, 5e3, 0.02);
    let kr = omega * 3.0 / AIR.c_mps;
    let expected = omega * AIR.rho_kgpm3 / 4.0 * (2.0 / (std::f64::consts::PI * kr)).sqrt();
    assert!((level / expected - 1.0).abs() < 1e-5, "{level} {expected}");
    let late = (phase - (FRAC_PI_4 - kr + 1.0 / (8.0 * kr))).rem_euclid(TAU);
    assert!(late.min(TAU - late) < 1e-5, "{late}");
    assert!(
        signal[..((3.0 / AIR.c_mps * RATE_HZ) as usize)]
            .iter()
            .all(|&s| s == 0.0)
    );
}

#[test]
fn a_pair_driving_at_a_wall_hears_the_doppler_factor() {
    let walls = Reflectors::new([wall([[3.0, -3.0], [3.0, 3.0]])]);
    let v_mps = 0.4;
    let drive = |t_s: f64| [v_mps * t_s, 0.0];
    let pair = PlanePair {
        source_at: &drive,
        receiver_at: &drive,
        duration_s: 2.0,
    };
    let signal = synthesize_pair(
        &walls,
        &pair,
        &tone(10e3),
        &AIR,
        RATE_HZ,
        &ImageSourceOptions::default(),
    );
    let heard_hz = 10e3 * (AIR.c_mps + v_mps) / (AIR.c_mps - v_mps);
    let phase_at = |from: usize| {
        line(&signal[from..from + 400], heard_hz, 0.0).1
            - (TAU * heard_hz * from as f64 / RATE_HZ).rem_euclid(TAU)
    };
    // The phase against the expected tone stays put over the drive.
    let drift = (phase_at(60_000) - phase_at(4_000)).rem_euclid(TAU);
    assert!(drift.min(TAU - drift) < 5e-3, "{drift}");
}

#[test]
fn borders_fade_without_clicks_and_opposite_orders_add_to_one_corner() {
    let walls = Reflectors::new([
        wall([[0.0, 0.0], [3.0, 0.0]]),
        wall([[0.0, 3.0], [0.0, 0.0]]),
    ]);
    let rest = |_: f64| [1.0, 1.0];
    let pair = PlanePair {
        source_at: &rest,
        receiver_at: &rest,
        duration_s: 0.05,
    };
    let tone = tone(5e3);
    let level = |max_order| {
        let options = ImageSourceOptions {
            max_order,
            ..ImageSourceOptions::default()
        };
        synthesize_pair(&walls, &pair, &tone, &AIR, RATE_HZ, &options)
    };
    let corner: Vec<f32> = level(2)
        .iter()
        .zip(level(1))
        .map(|(both, single)| both - single)
        .collect();
    let omega = TAU * 5e3;
    let kr = omega * 8f64.sqrt() / AIR.c_mps;
    let expected = omega * AIR.rho_kgpm3 / 4.0 * (2.0 / (std::f64::consts::PI * kr)).sqrt();
    let recorded = line(&corner, 5e3, 0.02).0;
    assert!(
        (recorded / expected - 1.0).abs() < 1e-4,
        "{recorded} {expected}"
    );
}

#[test]
fn a_drive_past_the_end_of_a_wall_is_smooth() {
    let walls = Reflectors::new([wall([[0.0, 0.0], [0.4, 0.0]])]);
    let drive = |t_s: f64| [0.4 * t_s, 0.6];
    let pair = PlanePair {
        source_at: &drive,
        receiver_at: &drive,
        duration_s: 2.0,
    };
    let signal = synthesize_pair(
        &walls,
        &pair,
        &tone(2e3),
        &AIR,
        RATE_HZ,
        &ImageSourceOptions::default(),
    );
    let peak = signal.iter().fold(0.0_f32, |most, s| most.max(s.abs()));
    // A tone of 2 kHz at 40 kHz obeys s[k+1] - 2 cos(w) s[k] + s[k-1] = 0; a click would not.
    let twice = 2.0 * (TAU as f32 * 2e3 / 40e3).cos();
    let residue = signal[400..].windows(3).fold(0.0_f32, |most, s| {
        most.max((s[2] - twice * s[1] + s[0]).abs())
    });
    assert!(residue < 2e-3 * peak, "{residue} of {peak}");
    assert!(signal[60_000..].iter().all(|&s| s == 0.0));
    assert!(signal[35_000..36_000].iter().any(|&s| s.abs() > 0.3 * peak));
}

#[test]
fn the_direct_sound_is_an_option_and_never_infinite() {
    let (walls, tone) = (Reflectors::new([]), tone(5e3));
    let rest = |_: f64| [0.0, 0.0];
    let beside = |_: f64| [0.5, 0.0];
    let recorded = |receiver_at: PositionAt<'_>, include_direct| {
        let pair = PlanePair {
            source_at: &rest,
            receiver_at,
            duration_s: 0.02,
        };
        let options = ImageSourceOptions {
            include_direct,
            ..ImageSourceOptions::default()
        };
        let signal = synthesize_pair(&walls, &pair, &tone, &AIR, RATE_HZ, &options);
        signal.iter().fold(0.0_f32, |most, s| most.max(s.abs()))
    };
    assert_eq!(recorded(&rest, true), 0.0);
    assert_eq!(recorded(&beside, false), 0.0);
    assert!(recorded(&beside, true) > 0.0);
}

#[test]
fn a_scene_sounds_the_same_at_any_number_of_threads() {
    let walls = [
        Wall {
            points_m: vec![[0.8, 4.2], [0.7, 0.9], [3.9, 0.8]],
            thickness_m: 0.02,
            impedance: None,
        },
        Wall {
            points_m: vec![[4.3, 1.5], [4.1, 4.1]],
            thickness_m: 0.02,
            impedance: None,
        },
        Wall {
            points_m: vec![[1.3, 4.4], [3.6, 4.3]],
            thickness_m: 0.02,
            impedance: None,
        },
    ];
    let start = fdtd::motion::MotionState {
        x_m: 2.5,
        y_m: 1.8,
        heading_rad: 0.3,
        v_mps: 0.3,
        omega_radps: 0.5,
    };
    let path = DrivePath::uniform(start, 2.0).expect("a valid drive");
    let samples: Vec<f64> = (0..409)
        .map(|k| if k * k % 7 < 3 { 1.0 } else { -1.0 })
        .collect();
    let waveform = PeriodicWaveform::new(&samples, 0.01023, 19e3, 120e3);
    let drive = DrivingPair {
        path: &path,
        loudspeaker_offset_m: [0.05, 0.0],
        microphone_offset_m: [-0.05, 0.0],
    };
    let options = ImageSourceOptions {
        max_order: 3,
        include_direct: true,
        ..ImageSourceOptions::default()
    };
    let on_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool");
        pool.install(|| synthesize(&walls, &drive, &waveform, &AIR, RATE_HZ, &options))
    };
    let alone = on_threads(1);
    assert_eq!(alone.len(), 80_000);
    assert!(alone.iter().all(|s| s.is_finite()));
    assert!(alone == on_threads(3));
}
