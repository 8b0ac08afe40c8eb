//! A real robot's instruments on a simulated drive: slip of the wheels, noise of the microphone, clocks.
//!
//! The wheels slip by a constant and a coloured share of the way, so that a robot at rest reports rest:
//!
//! ```text
//! v_wheels     = v (1 + speed_share + n_v)             n_v: no unit
//! omega_wheels = omega + |v| (drift_radpm + n_omega)   n_omega: radians per metre driven
//! ```
//!
//! n_v and n_omega are first-order Gauss-Markov (Ornstein-Uhlenbeck) processes: normal, zero mean, standard deviation
//! `sigma`, autocorrelation `exp(-|t| / correlation_s)`. At 0.3 m/s a drift of 0.035 rad/m is the steady 0.01 rad/s of
//! the paper's simulation. The microphone's own noise, epsilon of eq. (22), is white.

use std::path::Path;

use anyhow::{Context, Result, bail};
use fdtd::motion::DrivePath;
use localizer::Recording;
use localizer::io::wav;
use localizer::odometry::OdometrySample;
use localizer::random;
use localizer::{Pose, Trajectory};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use super::sound_card::SoundCard;
use crate::data::json;

/// Fastest log in hertz.
const MOST_HZ: f64 = 2000.0;
/// Largest reading of a clock in seconds.
const LATEST_S: f64 = 1e10;

/// A Gauss-Markov process.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColouredNoise {
    /// Standard deviation.
    pub sigma: f64,
    /// Correlation time, seconds.
    pub correlation_s: f64,
}

/// The instruments of a robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    /// Rate of the wheel log, Hz.
    pub odometry_rate_hz: f64,
    /// Reading of the wheel log's clock at the first sample of the signal, seconds.
    pub odometry_clock_s: f64,
    /// Rate of the tracking system, Hz.
    pub tracking_rate_hz: f64,
    /// Reading of the tracking system's clock at the first sample of the signal, seconds.
    pub tracking_clock_s: f64,
    /// Excess of the reported speed over the true speed, as a share of it.
    pub speed_share: f64,
    /// Noise of that share.
    pub speed_noise: ColouredNoise,
    /// Steady error of the heading, radians per metre.
    pub drift_radpm: f64,
    /// Its noise, radians per metre.
    pub turn_noise: ColouredNoise,
    /// Level of the microphone's noise over the whole received signal, decibels.
    pub microphone_noise_db: f64,
    /// Seed of all noise.
    pub seed: u64,
    /// The sound card; none is a converter that starts with the first period on the loudspeaker's clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sound_card: Option<SoundCard>,
}

impl ColouredNoise {
    /// Samples at `rate_hz`, the first from the stationary distribution.
    fn samples(self, count: usize, rate_hz: f64, random: &mut impl Rng) -> Vec<f64> {
        let kept = (-1.0 / (rate_hz * self.correlation_s)).exp();
        let fresh = (1.0 - kept * kept).sqrt();
        let mut value: f64 = StandardNormal.sample(random);
        (0..count)
            .map(|_| {
                let now = self.sigma * value;
                let step: f64 = StandardNormal.sample(random);
                value = kept * value + fresh * step;
                now
            })
            .collect()
    }
}

impl Robot {
    /// Reads a robot file.
    ///
    /// # Errors
    /// When the file cannot be read, has other fields, or a value cannot be used.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        Self::parse(&text, path)
    }

    /// Reads the text of a robot file; errors name `origin`.
    ///
    /// # Errors
    /// As [`Robot::read`].
    pub fn parse(text: &str, origin: &Path) -> Result<Self> {
        let robot: Self = json::parse(text, origin)?;
        robot
            .check()
            .with_context(|| origin.display().to_string())?;
        Ok(robot)
    }

    /// Refuses values that cannot be used: those of no instrument, and logs that would not fit into memory.
    fn check(&self) -> Result<()> {
        for (field, value, low, high) in [
            // Longer pauses than a second are refused in a recording.
            ("odometry_rate_hz", self.odometry_rate_hz, 1.0, MOST_HZ),
            ("tracking_rate_hz", self.tracking_rate_hz, 0.01, MOST_HZ),
            (
                "odometry_clock_s",
                self.odometry_clock_s,
                -LATEST_S,
                LATEST_S,
            ),
            (
                "tracking_clock_s",
                self.tracking_clock_s,
                -LATEST_S,
                LATEST_S,
            ),
            ("speed_share", self.speed_share, -1.0, 1.0),
            ("speed_noise.sigma", self.speed_noise.sigma, 0.0, 1.0),
            (
                "speed_noise.correlation_s",
                self.speed_noise.correlation_s,
                1e-6,
                1e6,
            ),
            ("drift_radpm", self.drift_radpm, -10.0, 10.0),
            ("turn_noise.sigma", self.turn_noise.sigma, 0.0, 10.0),
            (
                "turn_noise.correlation_s",
                self.turn_noise.correlation_s,
                1e-6,
                1e6,
            ),
            (
                "microphone_noise_db",
                self.microphone_noise_db,
                -400.0,
                100.0,
            ),
        ] {
            if !(low..=high).contains(&value) {
                bail!("{field}: {value} cannot be used; give {low} to {high}");
            }
        }
        self.sound_card.as_ref().map_or(Ok(()), SoundCard::check)
    }

    /// Odometry of a drive as the wheels report it. `name` selects the noise, which differs between drives.
    pub fn odometry(&self, path: &DrivePath, name: &str) -> Vec<OdometrySample> {
        let rate = self.odometry_rate_hz;
        let count = (path.duration_s() * rate).ceil() as usize + 1;
        let seed = random::trial_seed("robot", name, self.seed);
        let noise = |noise: ColouredNoise, purpose: &str| {
            noise.samples(count, rate, &mut random::stream(seed, purpose))
        };
        let speed = noise(self.speed_noise, "speed");
        let turn = noise(self.turn_noise, "turn");
        speed
            .iter()
            .zip(&turn)
            .enumerate()
            .map(|(index, (speed, turn))| {
                let t_s = index as f64 / rate;
                let state = path.state_at(t_s);
                OdometrySample {
                    t_s,
                    v_mps: state.v_mps * (1.0 + self.speed_share + speed),
                    omega_radps: state.omega_radps + state.v_mps.abs() * (self.drift_radpm + turn),
                }
            })
            .collect()
    }

    /// Adds the microphone's noise to a signal.
    pub fn add_noise(&self, signal: &mut [f32], name: &str) {
        let sigma = self.noise_sigma(signal);
        self.add_noise_of(signal, sigma, name, "microphone");
    }

    /// Standard deviation of the microphone's noise.
    fn noise_sigma(&self, signal: &[f32]) -> f64 {
        let power: f64 = signal.iter().map(|sample| f64::from(*sample).powi(2)).sum();
        (power / signal.len().max(1) as f64).sqrt() * 10_f64.powf(0.05 * self.microphone_noise_db)
    }

    fn add_noise_of(&self, signal: &mut [f32], sigma: f64, name: &str, purpose: &str) {
        let seed = random::trial_seed("robot", name, self.seed);
        let mut random = random::stream(seed, purpose);
        for sample in signal {
            let noise: f64 = StandardNormal.sample(&mut random);
            *sample += (sigma * noise) as f32;
        }
    }

    /// Writes a recording of [`Self::apply`] into a folder, through the sound card or a 16-bit converter.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, recording: &Recording, name: &str, folder: &Path) -> Result<()> {
        let rate_hz = recording.meta.sample_rate_hz;
        let Some(card) = &self.sound_card else {
            recording.write(folder)?;
            wav::write_pcm16(&folder.join("signal.wav"), &recording.signal, rate_hz)?;
            return Ok(());
        };
        let sigma = self.noise_sigma(&recording.signal);
        let sound = card.recorded(&recording.signal, rate_hz);
        let channels: Vec<Vec<f32>> = (1..=card.channels)
            .map(|channel| {
                let mut samples = match channel == card.channel {
                    true => sound.clone(),
                    false => vec![0.0; sound.len()],
                };
                self.add_noise_of(&mut samples, sigma, name, &format!("channel {channel}"));
                samples
            })
            .collect();
        card.write(recording, &channels, folder)
    }

    /// Truth of a drive as the tracking system reports it: true poses at its own rate.
    fn tracking(&self, path: &DrivePath) -> Trajectory {
        let count = (path.duration_s() * self.tracking_rate_hz).ceil() as usize;
        let t_s: Vec<f64> = (0..=count)
            .map(|index| index as f64 / self.tracking_rate_hz)
            .collect();
        let poses = t_s.iter().map(|&t_s| {
            let state = path.state_at(t_s);
            Pose {
                x_m: state.x_m,
                y_m: state.y_m,
                heading_rad: state.heading_rad,
            }
        });
        Trajectory {
            poses: poses.collect(),
            t_s,
        }
    }

    /// Replaces odometry and truth of an ideal recording by those of this robot, and adds its noise.
    pub fn apply(&self, recording: &mut Recording, path: &DrivePath, name: &str) {
        recording.odometry = self.odometry(path, name);
        recording.truth = Some(self.tracking(path));
        recording.meta.odometry_clock_s = Some(self.odometry_clock_s);
        recording.meta.truth_clock_s = Some(self.tracking_clock_s);
        if let Some(provenance) = recording.meta.provenance.as_object_mut() {
            provenance.remove("odometry_bias_radps");
            provenance.insert("robot".to_string(), serde_json::json!(self));
        }
        // A sound card has its noise at its own rate.
        if self.sound_card.is_none() {
            self.add_noise(&mut recording.signal, name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fdtd::motion::MotionState;

    fn robot() -> Robot {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/site.json");
        Robot::read(&file).unwrap()
    }

    #[test]
    fn coloured_noise_has_its_deviation_and_memory() {
        let noise = ColouredNoise {
            sigma: 0.2,
            correlation_s: 0.5,
        };
        let samples = noise.samples(400_000, 50.0, &mut random::stream(1, "test"));
        let product = |shift: usize| -> f64 {
            let pairs = samples.iter().zip(&samples[shift..]);
            pairs.map(|(a, b)| a * b).sum::<f64>() / (samples.len() - shift) as f64
        };
        // Two standard errors of the variance over 16 000 correlation times are 2 %.
        assert!((product(0) / 0.04 - 1.0).abs() < 0.04, "{}", product(0));
        assert!((product(25) / product(0) - (-1.0_f64).exp()).abs() < 0.03);
    }

    #[test]
    fn slip_grows_with_the_way_and_repeats() {
        let drive = |v_mps| {
            let start = MotionState {
                x_m: 0.0,
                y_m: 0.0,
                heading_rad: 0.0,
                v_mps,
                omega_radps: 0.0,
            };
            DrivePath::uniform(start, 60.0).unwrap()
        };
        let resting = robot().odometry(&drive(0.0), "a");
        assert!(
            resting
                .iter()
                .all(|sample| sample.v_mps == 0.0 && sample.omega_radps == 0.0)
        );
        let moving = robot().odometry(&drive(0.3), "a");
        assert_eq!(moving, robot().odometry(&drive(0.3), "a"));
        assert_ne!(moving, robot().odometry(&drive(0.3), "b"));
        let turn =
            moving.iter().map(|sample| sample.omega_radps).sum::<f64>() / moving.len() as f64;
        // 0.3 m/s times 0.1 rad/m over 30 independent intervals of two correlation times: 0.0055 rad/s standard error.
        assert!((turn - 0.3 * 0.035).abs() < 0.017, "{turn}");
    }

    #[test]
    fn the_microphone_noise_has_its_level() {
        let clean: Vec<f32> = (0..50_000).map(|k| (k as f32 * 0.3).sin()).collect();
        let mut noisy = clean.clone();
        robot().add_noise(&mut noisy, "a");
        let power =
            |signal: &mut dyn Iterator<Item = f32>| signal.map(|x| f64::from(x * x)).sum::<f64>();
        let noise = power(&mut noisy.iter().zip(&clean).map(|(a, b)| a - b));
        let level_db = 10.0 * (noise / power(&mut clean.iter().copied())).log10();
        assert!((level_db + 40.0).abs() < 0.1, "{level_db}");
    }

    #[test]
    fn unusable_robots_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.json");
        let bad = Robot {
            odometry_rate_hz: 0.0,
            ..robot()
        };
        std::fs::write(&path, serde_json::to_string(&bad).unwrap()).unwrap();
        let error = format!("{:#}", Robot::read(&path).unwrap_err());
        assert!(
            error.contains("robot.json") && error.contains("odometry_rate_hz"),
            "{error}"
        );
        std::fs::write(&path, r#"{"slip": 1}"#).unwrap();
        assert!(Robot::read(&path).is_err());
    }
}
