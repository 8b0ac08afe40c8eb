//! The experiment of the 2021 multipath paper in simulation: a room, a drive, the microphone's signal and the odometry
//! of the wheels.
//!
//! Signals come from three-dimensional image sources of third order, one more than any of the models has. The paper
//! shows its room as a picture only: size, drive, heights, reflection factor, noise and slip below are assumptions.

use anyhow::{Context, Result};
use fdtd::motion::{DriveLimits, DrivePath, MotionState, VelocityCommand};
use fdtd::waveform::PeriodicWaveform;
use localizer::multipath::planes::Plane;
use localizer::odometry::OdometrySample;
use localizer::parameters::MeasurementParameters;
use localizer::random::{stream, trial_seed};
use localizer::recording::RecordingMeta;
use localizer::{DirectWave, Parameters, Pose, Recording, Trajectory};
use oracles::image_source::ImageSourceOptions;
use oracles::image_source::room::{Room, RoomPair, synthesize};
use rand_distr::{Distribution, StandardNormal};

use super::noise::Noise;
use crate::data::cache::{Cache, Key, hash_of_samples};

/// Corners of the room, counter-clockwise, metres; the wall on the right is slanted by 6.6 degrees.
pub const CORNERS_M: [[f64; 2]; 4] = [[0.0, 0.0], [5.2, 0.0], [4.7, 4.3], [0.0, 4.3]];
/// Height of the ceiling, metres.
pub const CEILING_M: f64 = 2.7;
/// Heights of loudspeaker and microphone on top of the vehicle, one above the other, metres.
pub const HEIGHTS_M: [f64; 2] = [0.3, 0.4];
/// Pressure after a reflection over that before.
const REFLECTION: f64 = 0.85;
/// Reflections of the simulated sound.
const ORDER: usize = 3;
/// Length of the signal whose hash enters the cache's key, seconds.
const PRINT_S: f64 = 0.25;
/// Power of the echoes over that of the microphone's noise, decibels.
const SNR_DB: f64 = 20.0;
/// Rate of wheel readings and truth, hertz.
const WHEEL_RATE_HZ: f64 = 50.0;

/// Slip of the wheels: standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Slip {
    /// Constant error of a drive's speed over the speed.
    v_share: f64,
    /// Constant error of a drive's turn rate, rad/s.
    omega_radps: f64,
    /// Varying error of the speed, m/s.
    v_noise_mps: f64,
    /// Varying error of the turn rate, rad/s.
    omega_noise_radps: f64,
    /// Correlation time of the varying errors, seconds.
    time_s: f64,
}

const SLIP: Slip = Slip {
    v_share: 0.05,
    omega_radps: 0.02,
    v_noise_mps: 0.01,
    omega_noise_radps: 0.03,
    time_s: 1.0,
};

/// The experiment before noise and slip.
pub struct Site {
    /// Parameters of the measurement.
    pub parameters: Parameters,
    /// The map: walls, floor and ceiling.
    pub planes: Vec<Plane>,
    drive: DrivePath,
    signal: Vec<f32>,
    direct: Vec<f32>,
}

/// A round of 43 s through the room, 0.65 m and more from the walls.
fn drive() -> Result<DrivePath> {
    let start = MotionState {
        x_m: 1.2,
        y_m: 1.0,
        heading_rad: 0.0,
        v_mps: 0.0,
        omega_radps: 0.0,
    };
    let straight = |duration_s: f64| VelocityCommand {
        duration_s,
        v_mps: 0.25,
        omega_radps: 0.0,
    };
    let turn = VelocityCommand {
        duration_s: 3.77,
        v_mps: 0.25,
        omega_radps: 0.41667,
    };
    let legs = [
        straight(8.4),
        turn,
        straight(4.8),
        turn,
        straight(7.2),
        turn,
        straight(3.2),
        turn,
        straight(4.6),
    ];
    Ok(DrivePath::from_commands(
        start,
        &legs,
        DriveLimits::default(),
    )?)
}

/// The microphone's signal of the drive with echoes and without: from the cache, or simulated and put there.
fn sounds(
    cache: &Cache,
    room: &Room,
    drive: &DrivePath,
    parameters: &Parameters,
) -> Result<[Vec<f32>; 2]> {
    let waveform = PeriodicWaveform::new(
        &localizer::signal::waveform::transmit_period(&parameters.signal),
        parameters.period_s(),
        19e3,
        parameters.signal.sample_rate_hz,
    );
    let at = |t_s: f64, height_m: f64| {
        let [x, y] = drive.point_at(t_s, [0.0, 0.0]);
        [x, y, height_m]
    };
    let sounds = |duration_s: f64| {
        [ORDER, 0].map(|max_order| {
            let pair = RoomPair {
                source_at: &|t_s| at(t_s, HEIGHTS_M[0]),
                receiver_at: &|t_s| at(t_s, HEIGHTS_M[1]),
                duration_s,
            };
            let options = ImageSourceOptions {
                max_order,
                include_direct: true,
                fade_m: 0.05,
                stamped: false,
            };
            let (c_mps, rate_hz) = (
                parameters.signal.speed_of_sound_mps,
                parameters.signal.sample_rate_hz,
            );
            synthesize(room, &pair, &waveform, c_mps, rate_hz, &options)
        })
    };
    let mut key = Key::new("room");
    key.value(
        "room",
        &(CORNERS_M, CEILING_M, REFLECTION, HEIGHTS_M, ORDER),
    )?;
    key.value("parameters", parameters)?;
    let tenths = (10.0 * drive.duration_s()) as u32;
    let course = (0..=tenths).flat_map(|tenth| at(0.1 * f64::from(tenth), 0.0));
    key.numbers("course", &course.collect::<Vec<f64>>());
    // Stands for the code, as the engines' fingerprint does.
    let print = sounds(PRINT_S).map(|sound| hash_of_samples(&sound));
    key.value("print", &print)?;
    let key = key.finish();
    // As bits, which decimal digits represent exactly.
    if let Some(bits) = cache.get::<[Vec<u32>; 2]>("rooms", &key) {
        return Ok(bits.map(|bits| bits.into_iter().map(f32::from_bits).collect()));
    }
    let sounds = sounds(drive.duration_s());
    let bits =
        (sounds.each_ref()).map(|sound| sound.iter().map(|p| p.to_bits()).collect::<Vec<u32>>());
    cache.put("rooms", &key, &bits)?;
    Ok(sounds)
}

impl Site {
    /// The signals of the drive: from the cache, or simulated and put there.
    ///
    /// # Errors
    /// When the room or the drive is refused, or the cache cannot be written.
    pub fn simulate(cache: &Cache) -> Result<Self> {
        let room = Room::new(&CORNERS_M, CEILING_M, REFLECTION)?;
        let planes = room
            .faces()
            .iter()
            .map(|face| Plane::new(face.normal, face.offset_m))
            .collect::<Option<Vec<Plane>>>()
            .context("room: a face has no direction")?;
        let parameters = Parameters {
            measurement: MeasurementParameters {
                periods: 2,
                directions: 12,
                // Direct wave and floor echo, 0.1 m and 0.7 m long, do not change along the drive.
                direct_wave: DirectWave::GatedMean,
                min_range_m: 0.75,
                max_range_m: 17.0,
                ..MeasurementParameters::default()
            },
            ..Parameters::default()
        };
        let drive = drive()?;
        let [signal, direct] = sounds(cache, &room, &drive, &parameters)?;
        Ok(Self {
            planes,
            signal,
            direct,
            drive,
            parameters,
        })
    }

    /// The true pose at a time.
    fn pose(&self, t_s: f64) -> Pose {
        let state = self.drive.state_at(t_s);
        Pose {
            x_m: state.x_m,
            y_m: state.y_m,
            heading_rad: state.heading_rad,
        }
    }

    /// The recording of one trial: its own noise at the microphone and its own slip of the wheels.
    pub fn recording(&self, trial: u64) -> Recording {
        let mut signal = self.signal.clone();
        let noise = Noise {
            snr_db: SNR_DB,
            trial,
        };
        noise.add_to(&mut signal, &self.direct);
        let count = (self.drive.duration_s() * WHEEL_RATE_HZ).ceil() as usize;
        let times: Vec<f64> = (0..=count)
            .map(|index| index as f64 / WHEEL_RATE_HZ)
            .collect();
        let mut random = stream(trial_seed("multipath", "slip", trial), "wheels");
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let (share, turn_radps) = (SLIP.v_share * normal(), SLIP.omega_radps * normal());
        let keep = (-1.0 / (WHEEL_RATE_HZ * SLIP.time_s)).exp();
        let fresh = (1.0 - keep * keep).sqrt();
        let mut changing = [normal(), normal()];
        let odometry = times
            .iter()
            .map(|&t_s| {
                let state = self.drive.state_at(t_s);
                changing = changing.map(|value| keep * value + fresh * normal());
                OdometrySample {
                    t_s,
                    v_mps: state.v_mps * (1.0 + share) + SLIP.v_noise_mps * changing[0],
                    omega_radps: state.omega_radps
                        + turn_radps
                        + SLIP.omega_noise_radps * changing[1],
                }
            })
            .collect();
        Recording {
            unheard: Vec::new(),
            signal,
            direct: None,
            odometry,
            truth: Some(Trajectory {
                poses: times.iter().map(|&t_s| self.pose(t_s)).collect(),
                t_s: times,
            }),
            meta: RecordingMeta {
                start: Some(self.pose(0.0)),
                ..RecordingMeta::from_parameters(&self.parameters)
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_drive_keeps_clear_of_the_walls() {
        let drive = drive().unwrap();
        let room = Room::new(&CORNERS_M, CEILING_M, REFLECTION).unwrap();
        let steps = (drive.duration_s() * 10.0) as usize;
        for step in 0..=steps {
            let [x, y] = drive.point_at(0.1 * step as f64, [0.0, 0.0]);
            for face in &room.faces()[..4] {
                let away = face.normal[0] * x + face.normal[1] * y + face.offset_m;
                assert!(away > 0.65, "({x}, {y})");
            }
        }
    }
}
