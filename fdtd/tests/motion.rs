//! Drives: against closed forms and a plain integration, smoothness, files, refusals.

use fdtd::motion::{DriveLimits, DrivePath, MotionState, PoseSample, VelocityCommand};
use std::f64::consts::{PI, TAU};

const REST: MotionState = MotionState {
    x_m: 1.0,
    y_m: 2.0,
    heading_rad: 0.3,
    v_mps: 0.0,
    omega_radps: 0.0,
};

fn leg(duration_s: f64, v_mps: f64, omega_radps: f64) -> VelocityCommand {
    VelocityCommand {
        duration_s,
        v_mps,
        omega_radps,
    }
}

fn tour() -> Vec<VelocityCommand> {
    vec![
        leg(3.0, 0.3, 0.0),
        leg(2.0, 0.25, 0.5),
        leg(0.2, 0.4, -0.6),
        leg(2.5, 0.4, -0.6),
        leg(1.0, 0.0, 0.0),
        leg(2.0, -0.2, 0.3),
    ]
}

#[test]
fn a_circle_closes() {
    let start = MotionState {
        v_mps: 0.4,
        omega_radps: 0.5,
        ..REST
    };
    let path = DrivePath::uniform(start, TAU / 0.5).unwrap();
    let (end, quarter) = (path.state_at(TAU / 0.5), path.state_at(PI / 2.0 / 0.5));
    assert!((end.x_m - 1.0).hypot(end.y_m - 2.0) < 1e-11);
    let radius = 0.8;
    let expected = [
        1.0 + radius * ((0.3 + PI / 2.0).sin() - 0.3_f64.sin()),
        2.0 - radius * ((0.3 + PI / 2.0).cos() - 0.3_f64.cos()),
    ];
    assert!((quarter.x_m - expected[0]).hypot(quarter.y_m - expected[1]) < 1e-11);
}

#[test]
fn legs_follow_a_plain_integration_of_the_limited_speeds() {
    let limits = DriveLimits::default();
    let path = DrivePath::from_commands(REST, &tour(), limits).unwrap();
    // Midpoint rule at 20 us, speeds slewed step by step towards their commands.
    let dt_s = 2e-5;
    let slew =
        |now: f64, command: f64, rate: f64| now + (command - now).clamp(-rate * dt_s, rate * dt_s);
    let mut now = REST;
    let mut steps = 0;
    for leg in tour() {
        for _ in 0..(leg.duration_s / dt_s).round() as usize {
            let v = slew(now.v_mps, leg.v_mps, limits.acceleration_mps2);
            let omega = slew(
                now.omega_radps,
                leg.omega_radps,
                limits.angular_acceleration_radps2,
            );
            let middle = now.heading_rad + 0.25 * (now.omega_radps + omega) * dt_s;
            now.x_m += 0.5 * (now.v_mps + v) * dt_s * middle.cos();
            now.y_m += 0.5 * (now.v_mps + v) * dt_s * middle.sin();
            now.heading_rad += 0.5 * (now.omega_radps + omega) * dt_s;
            (now.v_mps, now.omega_radps) = (v, omega);
            steps += 1;
            if steps % 1777 == 0 {
                let exact = path.state_at(f64::from(steps) * dt_s);
                assert!((exact.x_m - now.x_m).hypot(exact.y_m - now.y_m) < 1e-6);
                assert!((exact.heading_rad - now.heading_rad).abs() < 1e-6);
                assert!((exact.v_mps - now.v_mps).abs() < 2e-5);
            }
        }
    }
    assert!((path.duration_s() - 10.7).abs() < 1e-12);
}

#[test]
fn positions_are_the_integral_of_the_speeds_everywhere() {
    let path = DrivePath::from_commands(REST, &tour(), DriveLimits::default()).unwrap();
    let h = 1e-4;
    for k in 1..106_000 {
        let t_s = f64::from(k) * h;
        let (before, now, after) = (
            path.state_at(t_s - h),
            path.state_at(t_s),
            path.state_at(t_s + h),
        );
        // Difference over 0.2 ms; where the acceleration jumps the error is h/4 of the jump at most.
        let vx = (after.x_m - before.x_m) / (2.0 * h);
        let vy = (after.y_m - before.y_m) / (2.0 * h);
        let error =
            (vx - now.v_mps * now.heading_rad.cos()).hypot(vy - now.v_mps * now.heading_rad.sin());
        assert!(error < 3e-5, "{error} at {t_s}");
        let step = (now.x_m - before.x_m).hypot(now.y_m - before.y_m);
        assert!(step < 0.41 * h);
    }
}

#[test]
fn times_beyond_the_drive_are_clamped_and_rest_is_exact() {
    let path = DrivePath::from_commands(REST, &tour(), DriveLimits::default()).unwrap();
    assert_eq!(path.state_at(-5.0), path.state_at(0.0));
    assert_eq!(path.state_at(99.0), path.state_at(path.duration_s()));
    let still = DrivePath::uniform(REST, 5.0).unwrap();
    for k in 0..1000 {
        assert_eq!(still.state_at(f64::from(k) * 0.00513), REST);
        assert_eq!(
            still.point_at(f64::from(k) * 0.00513, [0.1, 0.0]),
            still.point_at(0.0, [0.1, 0.0])
        );
    }
}

#[test]
fn offsets_turn_with_the_robot() {
    let start = MotionState {
        heading_rad: PI / 2.0,
        ..REST
    };
    let path = DrivePath::uniform(start, 1.0).unwrap();
    let point = path.point_at(0.5, [0.2, 0.1]);
    assert!((point[0] - 0.9).abs() < 1e-12 && (point[1] - 2.2).abs() < 1e-12);
}

#[test]
fn samples_of_a_drive_give_the_drive_back() {
    let path = DrivePath::uniform(
        MotionState {
            v_mps: 0.4,
            omega_radps: 0.5,
            ..REST
        },
        20.0,
    )
    .unwrap();
    let samples: Vec<PoseSample> = (0..=400)
        .map(|k| {
            let t_s = f64::from(k) * 0.05;
            let state = path.state_at(t_s);
            // Headings wrapped as files have them.
            let heading_rad = state.heading_rad.sin().atan2(state.heading_rad.cos());
            PoseSample {
                t_s: 7.0 + t_s,
                x_m: state.x_m,
                y_m: state.y_m,
                heading_rad,
            }
        })
        .collect();
    let again = DrivePath::from_samples(&samples).unwrap();
    assert!((again.duration_s() - 20.0).abs() < 1e-9);
    for k in 0..2000 {
        let t_s = f64::from(k) * 0.01003;
        let (a, b) = (path.state_at(t_s), again.state_at(t_s));
        assert!((a.x_m - b.x_m).hypot(a.y_m - b.y_m) < 2e-6);
        assert!((a.v_mps - b.v_mps).abs() < 2e-4 && (a.heading_rad - b.heading_rad).abs() < 1e-6);
    }
    assert!(again.max_speed_mps(0.0) > 0.399 && again.max_speed_mps(0.0) < 0.6);
}

#[test]
fn tum_and_csv_files_say_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let (mut tum, mut csv) = (
        String::from("# t x y z qx qy qz qw\n"),
        String::from("t_s,x_m,y_m,heading_rad\n"),
    );
    for k in 0..50 {
        let t_s = f64::from(k) * 0.1;
        let (x, y, heading) = (0.3 * t_s, 1.0 + 0.02 * t_s * t_s, 0.1 * t_s);
        tum += &format!(
            "{t_s} {x} {y} 0 0 0 {} {}\n",
            (heading / 2.0).sin(),
            (heading / 2.0).cos()
        );
        csv += &format!("{t_s},{x},{y},{heading}\n");
    }
    std::fs::write(folder.path().join("a.tum"), tum).unwrap();
    std::fs::write(folder.path().join("a.csv"), csv).unwrap();
    let a = DrivePath::read(&folder.path().join("a.tum")).unwrap();
    let b = DrivePath::read(&folder.path().join("a.csv")).unwrap();
    for k in 0..49 {
        let (a, b) = (
            a.state_at(f64::from(k) * 0.1003),
            b.state_at(f64::from(k) * 0.1003),
        );
        assert!(
            (a.x_m - b.x_m).abs() < 1e-12
                && (a.y_m - b.y_m).abs() < 1e-12
                && (a.heading_rad - b.heading_rad).abs() < 1e-9
        );
    }
}

#[test]
fn bad_files_and_numbers_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.tum");
    for (text, expected) in [
        ("", "at least two poses"),
        ("0 0 0 0 0 0 0 1\n0 1 0 0 0 0 0 1\n", "does not come after"),
        (
            "0 0 0 0 0 0 0 1\n1 1 nan 0 0 0 0 1\n",
            "line 2: `nan` is not a finite number",
        ),
        ("0 0 0 0 0 0 0 1\n1 1 0 0 0 0 1\n", "line 2: 7 columns"),
        ("0 0 0 0 0 0 0 0\n", "unit length"),
        ("0 0 0 0 0 0 0 1\n1e-9 9 0 0 0 0 0 1\n", "jump"),
        ("0 0 0 0 0 0 0 1\n1e9 0 0 0 0 0 0 1\n", "keep to 3600 s"),
    ] {
        std::fs::write(&file, text).unwrap();
        let message = DrivePath::read(&file).unwrap_err().to_string();
        assert!(
            message.contains(expected) && message.contains("bad.tum") && !message.contains('\n'),
            "{message}"
        );
    }
    let missing = DrivePath::read(&folder.path().join("none.csv"))
        .unwrap_err()
        .to_string();
    assert!(missing.contains("none.csv"));
    for bad in [
        leg(0.0, 0.1, 0.0),
        leg(f64::NAN, 0.1, 0.0),
        leg(1.0, f64::INFINITY, 0.0),
        leg(1.0, 0.1, 99.0),
    ] {
        assert!(DrivePath::from_commands(REST, &[bad], DriveLimits::default()).is_err());
    }
    assert!(DrivePath::from_commands(REST, &[], DriveLimits::default()).is_err());
}
