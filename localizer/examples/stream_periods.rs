//! Localizes a robot from a stream of samples, period by period, as a program on a robot does.
//!
//! `cargo run --release -p localizer --example stream_periods` needs no file: the robot drives along the axis of a
//! corridor whose two end walls echo, and its wheels report too high a speed.

use std::error::Error;
use std::f64::consts::TAU;

use localizer::image::map_builder;
use localizer::odometry::OdometrySample;
use localizer::recording::RecordingMeta;
use localizer::signal::waveform::m_sequence;
use localizer::{Localizer, Odometry, Parameters, Pose, Recording, Trajectory, echo};

/// End walls of the corridor at x = 0 and here, in metres.
const LENGTH_M: f64 = 4.0;
/// Start of both drives, in metres.
const START_M: f64 = 0.9;
/// Speed of both drives in m/s.
const SPEED_MPS: f64 = 0.3;
/// Reported speed over true speed.
const SLIP: f64 = 1.05;
/// Periods of a drive.
const PERIODS: usize = 60;

/// The transmitted signal at any time: rectangular chips on the carrier.
fn transmitted(parameters: &Parameters, code: &[i8], t_s: f64) -> f64 {
    let chip = (t_s * parameters.signal.chip_rate_hz).floor() as i64;
    let chip = code[chip.rem_euclid(code.len() as i64) as usize];
    f64::from(chip) * (TAU * parameters.signal.carrier_hz * t_s).sin()
}

/// The microphone signal of a drive: the direct wave and the echoes of the walls ahead and behind.
fn drive(parameters: &Parameters) -> Vec<f32> {
    let code = m_sequence(parameters.signal.code_order().unwrap_or_default());
    let c_mps = parameters.signal.speed_of_sound_mps;
    (0..PERIODS * parameters.samples_per_period())
        .map(|k| {
            let t_s = k as f64 / parameters.signal.sample_rate_hz;
            let x_m = START_M + SPEED_MPS * t_s;
            // An echo that arrives now left when the robot was `SPEED_MPS` times the delay further back.
            let ahead_s = 2.0 * (LENGTH_M - x_m) / (c_mps - SPEED_MPS);
            let behind_s = 2.0 * x_m / (c_mps + SPEED_MPS);
            let at = |delay_s| transmitted(parameters, &code, t_s - delay_s);
            (3.0 * at(0.1 / c_mps) + at(ahead_s) + 0.8 * at(behind_s)) as f32
        })
        .collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut parameters = Parameters::default();
    parameters.filter.sigma_v_mps = 0.05;
    parameters.filter.likelihood_exponent = 8.0;
    let period_s = parameters.period_s();
    let pose_at = |t_s: f64| Pose {
        x_m: START_M + SPEED_MPS * t_s,
        ..Pose::default()
    };

    // A map needs a drive with true poses.
    let ends_s = [0.0, PERIODS as f64 * period_s];
    let odometry_at = |t_s| OdometrySample {
        t_s,
        v_mps: SPEED_MPS,
        omega_radps: 0.0,
    };
    let t_s: Vec<f64> = (0..=PERIODS).map(|n| n as f64 * period_s).collect();
    let mapping = Recording {
        unheard: Vec::new(),
        signal: drive(&parameters),
        direct: None,
        odometry: t_s.iter().map(|&t_s| odometry_at(t_s)).collect(),
        truth: None,
        meta: RecordingMeta::from_parameters(&parameters),
    };
    let truth = Trajectory {
        poses: ends_s.map(pose_at).to_vec(),
        t_s: ends_s.to_vec(),
    };
    let echoes = echo::measure(&mapping, &parameters)?;
    let map = map_builder::build(&[(&echoes, &echoes.poses(&truth))])?;

    // The stream: one period of samples and the mean odometry during it at a time.
    let mut localizer = Localizer::new(&parameters, map, pose_at(0.0), 1)?;
    let reported = Odometry {
        v_mps: SLIP * SPEED_MPS,
        omega_radps: 0.0,
    };
    println!("time s   true x m   estimated   by wheels   strongest echo ahead");
    let signal = drive(&parameters);
    let periods = signal.chunks_exact(parameters.samples_per_period());
    for (n, samples) in periods.enumerate() {
        let Some(estimate) = localizer.step(samples, reported)? else {
            continue;
        };
        if n % 6 != 5 {
            continue;
        }
        let ahead = localizer.echoes().intensity.row(0);
        let strongest = (0..ahead.len()).max_by(|&a, &b| ahead[a].total_cmp(&ahead[b]));
        println!(
            "{:6.2} {:10.3} {:11.3} {:11.3} {:11.2} m",
            estimate.t_s,
            pose_at(estimate.t_s).x_m,
            estimate.pose.x_m,
            START_M + reported.v_mps * estimate.t_s,
            parameters
                .signal
                .range_of_delay_m(strongest.unwrap_or_default() as f64),
        );
    }
    Ok(())
}
