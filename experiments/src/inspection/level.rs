//! Level, clipping, offset and hum of a file of sound, one channel, read piece by piece.

use std::f64::consts::TAU;
use std::path::Path;

use localizer::Error;
use localizer::io::wav::WavStream;

/// Samples of a piece.
const PIECE: usize = 1 << 14;

/// Share of full scale from which on a sample counts as clipped, if its neighbour does too.
const FULL: f32 = 0.999;

/// Lines of the mains that are looked for, in Hz, with two overtones each.
const MAINS_HZ: [f64; 2] = [50.0, 60.0];

/// Duration of one value of the level over time, in seconds.
pub(super) const LEVEL_S: f64 = 0.1;

/// What a file sounds like, without a code.
#[derive(Debug, Clone, Default)]
pub struct Level {
    /// Samples.
    pub samples: u64,
    /// Largest magnitude; 1 is full scale.
    pub peak: f64,
    /// Root mean square without the mean.
    pub rms: f64,
    /// Mean.
    pub mean: f64,
    /// Pairs of neighbours at full scale.
    pub clipped: u64,
    /// Strongest mains and overtones: frequency in Hz, root mean square.
    pub hum: (f64, f64),
    /// Root mean square of every tenth of a second.
    pub over_time: Vec<f64>,
}

/// Correlation with a sine and a cosine.
struct Tone {
    step: f64,
    sums: [f64; 2],
}

impl Level {
    /// Reads a channel.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn read(path: &Path, channel: usize) -> Result<Self, Error> {
        let mut stream = WavStream::open(path)?;
        let rate_hz = stream.rate_hz();
        let (mut level, mut piece) = (Self::default(), Vec::with_capacity(PIECE));
        let mut tones: Vec<Tone> = MAINS_HZ
            .iter()
            .flat_map(|mains| [1.0, 2.0, 3.0].map(|overtone| mains * overtone))
            .map(|hz| Tone {
                step: TAU * hz / rate_hz,
                sums: [0.0; 2],
            })
            .collect();
        let (mut sum, mut squares, mut was_full) = (0.0, 0.0, false);
        let window = (LEVEL_S * rate_hz).max(1.0) as u64;
        let mut part = 0.0;
        loop {
            piece.clear();
            if stream.read(PIECE, channel, &mut piece)? == 0 {
                break;
            }
            for &sample in &piece {
                let is_full = sample.abs() >= FULL;
                level.clipped += u64::from(is_full && was_full);
                was_full = is_full;
                let value = f64::from(sample);
                level.peak = level.peak.max(value.abs());
                sum += value;
                squares += value * value;
                part += value * value;
                level.samples += 1;
                if level.samples.is_multiple_of(window) {
                    level.over_time.push((part / window as f64).sqrt());
                    part = 0.0;
                }
            }
            let first = level.samples - piece.len() as u64;
            for tone in &mut tones {
                for (k, &sample) in piece.iter().enumerate() {
                    let phase = tone.step * (first + k as u64) as f64;
                    tone.sums[0] += f64::from(sample) * phase.cos();
                    tone.sums[1] += f64::from(sample) * phase.sin();
                }
            }
        }
        let count = level.samples.max(1) as f64;
        level.mean = sum / count;
        level.rms = (squares / count - level.mean * level.mean).max(0.0).sqrt();
        level.hum = MAINS_HZ
            .iter()
            .zip(tones.chunks(3))
            .map(|(&mains_hz, tones)| {
                let power = |tone: &Tone| 2.0 * tone.sums[0].hypot(tone.sums[1]).powi(2);
                (
                    mains_hz,
                    tones.iter().map(power).sum::<f64>().sqrt() / count,
                )
            })
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or_default();
        Ok(level)
    }
}

/// Decibels of a ratio of amplitudes.
pub fn decibels(ratio: f64) -> f64 {
    20.0 * ratio.max(1e-12).log10()
}

#[cfg(test)]
mod tests {
    use super::*;
    use localizer::io::wav;

    #[test]
    fn level_clipping_offset_and_hum_are_those_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        let samples: Vec<f32> = (0..96_000)
            .map(|k| {
                let t_s = f64::from(k) / 48_000.0;
                let hum = 0.1 * (TAU * 50.0 * t_s).sin();
                (0.02 + hum + 0.5 * (TAU * 10_000.0 * t_s).sin()) as f32
            })
            .collect();
        wav::write_scaled(&path, &[vec![0.0; 96_000], samples], 48_000, 24, 1.0).unwrap();
        let level = Level::read(&path, 2).unwrap();
        assert_eq!(
            (level.samples, level.clipped, level.over_time.len()),
            (96_000, 0, 20)
        );
        assert!((level.mean - 0.02).abs() < 1e-4, "{level:?}");
        assert!(
            (level.rms - (0.125_f64 + 0.005).sqrt()).abs() < 1e-3,
            "{level:?}"
        );
        assert_eq!(level.hum.0, 50.0);
        assert!(
            (level.hum.1 - 0.1 / 2.0_f64.sqrt()).abs() < 1e-3,
            "{level:?}"
        );
        let loud: Vec<f32> = (0..1000).map(|k| 2.0 * (0.1 * k as f32).sin()).collect();
        wav::write_scaled(&path, &[loud], 48_000, 16, 1.0).unwrap();
        let level = Level::read(&path, 1).unwrap();
        assert!(level.clipped > 300 && level.peak > 0.99, "{level:?}");
    }
}
