//! Exact signals of a moving loudspeaker-microphone pair among plane walls, for the tests.

use localizer::odometry::OdometrySample;
use localizer::recording::RecordingMeta;
use localizer::signal::waveform::transmit_period;
use localizer::{Parameters, Pose, Recording, Trajectory};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// Points of the table per sample of the transmitted signal.
const FINER: usize = 32;

/// The transmitted signal at any time: its Fourier series on a fine grid, cubic interpolation between.
pub(crate) struct Transmitter {
    table: Vec<f64>,
    per_second: f64,
}

impl Transmitter {
    pub(crate) fn new(parameters: &Parameters) -> Self {
        let period = transmit_period(&parameters.signal);
        let length = period.len();
        let mut spectrum: Vec<Complex<f64>> = period
            .iter()
            .map(|&sample| Complex::new(sample, 0.0))
            .collect();
        FftPlanner::new()
            .plan_fft_forward(length)
            .process(&mut spectrum);
        let mut fine = vec![Complex::new(0.0, 0.0); FINER * length];
        for line in 1..length.div_ceil(2) {
            fine[line] = 2.0 * spectrum[line] / length as f64;
        }
        FftPlanner::new()
            .plan_fft_inverse(FINER * length)
            .process(&mut fine);
        Self {
            table: fine.iter().map(|value| value.re).collect(),
            per_second: FINER as f64 * parameters.signal.sample_rate_hz,
        }
    }

    pub(crate) fn value(&self, t_s: f64) -> f64 {
        let position = t_s * self.per_second;
        let u = position - position.floor();
        let first = position.floor() as i64 - 1;
        let point = |k: i64| self.table[(first + k).rem_euclid(self.table.len() as i64) as usize];
        point(0) * (-u * (u - 1.0) * (u - 2.0) / 6.0)
            + point(1) * ((u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0)
            + point(2) * (-(u + 1.0) * u * (u - 2.0) / 2.0)
            + point(3) * ((u + 1.0) * u * (u - 1.0) / 6.0)
    }
}

/// A drive of legs `[duration_s, v_mps, omega_radps]`, each an exact arc.
pub(crate) struct Drive {
    legs: Vec<(f64, Pose, [f64; 3])>,
    duration_s: f64,
}

impl Drive {
    pub(crate) fn new(start: Pose, legs: &[[f64; 3]]) -> Self {
        let (mut t_s, mut pose, mut placed) = (0.0, start, Vec::new());
        for &leg in legs {
            placed.push((t_s, pose, leg));
            pose = arc(pose, leg, leg[0]);
            t_s += leg[0];
        }
        Self {
            legs: placed,
            duration_s: t_s,
        }
    }

    fn leg_at(&self, t_s: f64) -> &(f64, Pose, [f64; 3]) {
        let next = self.legs.partition_point(|leg| leg.0 <= t_s);
        &self.legs[next.saturating_sub(1)]
    }

    pub(crate) fn pose_at(&self, t_s: f64) -> Pose {
        let &(start_s, pose, leg) = self.leg_at(t_s);
        arc(pose, leg, t_s - start_s)
    }
}

fn arc(start: Pose, [_, v_mps, omega_radps]: [f64; 3], t_s: f64) -> Pose {
    let half = 0.5 * omega_radps * t_s;
    let chord_m = v_mps
        * t_s
        * if half.abs() < 1e-9 {
            1.0
        } else {
            half.sin() / half
        };
    Pose {
        x_m: start.x_m + chord_m * (start.heading_rad + half).cos(),
        y_m: start.y_m + chord_m * (start.heading_rad + half).sin(),
        heading_rad: start.heading_rad + 2.0 * half,
    }
}

/// A plane wall: a point on it and the direction of its normal.
pub(crate) struct Wall {
    pub(crate) point_m: [f64; 2],
    pub(crate) normal_rad: f64,
}

/// Four walls around the origin, none parallel to another or to the axes.
pub(crate) fn room() -> Vec<Wall> {
    [(0.1, 2.3), (1.75, 1.9), (3.0, 2.6), (4.6, 2.1)]
        .map(|(normal_rad, distance_m): (f64, f64)| Wall {
            point_m: [distance_m * normal_rad.cos(), distance_m * normal_rad.sin()],
            normal_rad,
        })
        .into()
}

/// The recording of a drive among plane walls: one exact retarded echo of each, and a direct wave of the given
/// amplitude.
///
/// The odometry is the true one plus `drift_radps`.
pub(crate) fn record(
    parameters: &Parameters,
    drive: &Drive,
    walls: &[Wall],
    direct: f64,
    drift_radps: f64,
) -> Recording {
    let transmitter = Transmitter::new(parameters);
    let count = (drive.duration_s * parameters.signal.sample_rate_hz) as usize;
    let c = parameters.signal.speed_of_sound_mps;
    let direct_wave: Vec<f32> = (0..count)
        .map(|k| (direct * transmitter.value(k as f64 / parameters.signal.sample_rate_hz)) as f32)
        .collect();
    let signal = (0..count)
        .map(|k| {
            let t_s = k as f64 / parameters.signal.sample_rate_hz;
            let here = drive.pose_at(t_s);
            let mut sum = f64::from(direct_wave[k]);
            for wall in walls {
                let (ny, nx) = wall.normal_rad.sin_cos();
                let mut path_m = 0.0;
                for _ in 0..4 {
                    let there = drive.pose_at(t_s - path_m / c);
                    let depth =
                        (there.x_m - wall.point_m[0]) * nx + (there.y_m - wall.point_m[1]) * ny;
                    let image = (there.x_m - 2.0 * depth * nx, there.y_m - 2.0 * depth * ny);
                    path_m = (image.0 - here.x_m).hypot(image.1 - here.y_m);
                }
                sum += transmitter.value(t_s - path_m / c) / path_m.max(0.01).sqrt();
            }
            sum as f32
        })
        .collect();
    let period_s = parameters.period_s();
    let times = || {
        (0..)
            .map(|n| 0.25 * period_s * f64::from(n))
            .take_while(|&t_s| t_s <= drive.duration_s)
    };
    Recording {
        unheard: Vec::new(),
        signal,
        direct: Some(direct_wave),
        odometry: times()
            .map(|t_s| {
                let [_, v_mps, omega_radps] = drive.leg_at(t_s).2;
                OdometrySample {
                    t_s,
                    v_mps,
                    omega_radps: omega_radps + drift_radps,
                }
            })
            .collect(),
        truth: Some(Trajectory {
            t_s: times().collect(),
            poses: times().map(|t_s| drive.pose_at(t_s)).collect(),
        }),
        meta: RecordingMeta::from_parameters(parameters),
    }
}

/// A mapping drive: circles with headings in all directions.
pub(crate) fn mapping_drive(duration_s: f64) -> Drive {
    let start = Pose {
        x_m: 0.0,
        y_m: -0.8,
        heading_rad: 0.0,
    };
    Drive::new(
        start,
        &[
            [0.55 * duration_s, 0.3, 0.4],
            [0.45 * duration_s, 0.28, -0.55],
        ],
    )
}

/// A drive of straights and turns to both sides.
pub(crate) fn localization_drive(duration_s: f64) -> Drive {
    let start = Pose {
        x_m: -0.7,
        y_m: -0.7,
        heading_rad: 0.2,
    };
    let turns = [
        [4.0, 0.3, 0.0],
        [3.5, 0.25, 0.6],
        [3.0, 0.32, 0.02],
        [4.0, 0.25, 0.55],
        [4.0, 0.3, -0.25],
        [4.5, 0.25, 0.65],
    ];
    let mut legs = Vec::new();
    let mut rest_s: f64 = duration_s;
    for leg in turns.iter().cycle() {
        let leg_s = rest_s.min(leg[0]);
        legs.push([leg_s, leg[1], leg[2]]);
        rest_s -= leg_s;
        if rest_s <= 0.0 {
            break;
        }
    }
    Drive::new(start, &legs)
}

/// Mean distance in metres between estimated and true positions.
pub(crate) fn mean_error_m(estimates: &[localizer::Estimate], drive: &Drive) -> f64 {
    let sum: f64 = estimates
        .iter()
        .map(|estimate| estimate.pose.distance_m(&drive.pose_at(estimate.t_s)))
        .sum();
    sum / estimates.len() as f64
}
