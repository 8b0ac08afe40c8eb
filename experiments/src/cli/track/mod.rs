//! `echolot track`.

mod input;
mod setup;
mod sound;
mod stream;
mod view;
mod wheels;

use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use localizer::Trajectory;

use self::input::Input;
use self::view::View;
use self::wheels::Wheels;
use super::localize::MethodArgument;
use super::start::{StartArgument, start, start_sigma};
use crate::live::pcm::Format;
use crate::localization::Told;

/// Periods whose time of work is averaged.
const WORK_PERIODS: u32 = 50;

/// Form of the poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Output {
    /// A JSON object a line: pose, covariance, status.
    Json,
    /// TUM lines, those of `localize`.
    Tum,
}

/// Clock of the poses' times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Clock {
    /// That of the wheels' log.
    Wheels,
    /// Time since the first period of the sound.
    Sound,
}

/// Arguments of `track`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  arecord -q -f S16_LE -c 2 -r 48000 -t raw | echolot track --map maps/room --format s16 \
    --rate 48000 --channels 2 --odometry udp:5005 --start 1.2,0.8,90\n  \
    echolot track --map maps/room --odometry drive/odometry.csv --start 1.2,0.8,90 --output tum < drive/signal.wav\n  \
    echolot track --map maps/room --audio --rate 48000 --odometry udp:5005 --start 1.2,0.8,90\n\n\
    Poses are those that localize computes for the same sound and log, byte for byte, one a period, at most one period \
    after their last sample. Unless --late, --drift and --odometry-clock are given, the first poses wait for the drive \
    that tells them: the sound for one second of the code, the wheels' clock for 20 s of driving. Gaps in the sound \
    and late odometry are told on standard error; poses then follow what there is."
)]
pub(crate) struct Arguments {
    /// Map folder.
    #[arg(long)]
    map: PathBuf,
    /// Method.
    #[arg(long, value_enum, default_value_t = MethodArgument::Doppler)]
    method: MethodArgument,
    /// Odometry, lines of t_s,v_mps,omega_radps: a file or pipe, fd:N, or udp:PORT on this machine.
    #[arg(long, value_name = "SOURCE")]
    odometry: String,
    /// Start of the drive: x and y in metres and the heading in degrees, or unknown (landmarks only).
    #[arg(long, value_name = "X,Y,DEG|unknown", allow_hyphen_values = true, value_parser = start)]
    start: StartArgument,
    /// Standard deviations of the start in metres and degrees; a known start unless given.
    #[arg(long, value_name = "M,DEG", value_parser = start_sigma)]
    start_sigma: Option<[f64; 2]>,
    /// Format of the sound on standard input.
    #[arg(long, value_enum, default_value_t = Format::Wav)]
    format: Format,
    /// Sample rate of raw samples or of the sound device, Hz.
    #[arg(long, value_name = "F", default_value_t = 48_000.0)]
    rate: f64,
    /// Channels of raw samples, one unless given, or of the microphone's device, its fewest unless given.
    #[arg(long, value_name = "N")]
    channels: Option<usize>,
    /// Channel to use, the first is 1; the first with the code in it unless given.
    #[arg(long, value_name = "N")]
    channel: Option<usize>,
    /// Form of the poses on standard output.
    #[arg(long, value_enum, default_value_t = Output::Json)]
    output: Output,
    /// Clock of the poses' times.
    #[arg(long, value_enum, default_value_t = Clock::Wheels)]
    clock: Clock,
    /// Periods M in a block; the map's unless given.
    #[arg(long, value_name = "M")]
    periods: Option<usize>,
    /// Half-width of the matched window, metres.
    #[arg(long, value_name = "METRES")]
    window: Option<f64>,
    /// Number of particles.
    #[arg(long, value_name = "N")]
    particles: Option<usize>,
    /// Seed of the filter's random numbers.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Time of the first sample of a period since the first sample, milliseconds; found unless given.
    #[arg(long, value_name = "MS")]
    late: Option<f64>,
    /// Excess of the recorder's rate over the loudspeaker's, parts per million; found unless given.
    #[arg(long, value_name = "PPM", allow_hyphen_values = true)]
    drift: Option<f64>,
    /// Reading of the wheels' clock at the first sample of the sound, seconds; found unless given.
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    odometry_clock: Option<f64>,
    /// What is played, where it is not the map's code: the description that `transmit` writes, or a WAV of one period.
    #[arg(long, value_name = "FILE")]
    transmitted: Option<PathBuf>,
    /// Speed of sound, m/s; the map's unless given.
    #[arg(long, value_name = "MPS")]
    speed_of_sound: Option<f64>,
    /// Time that late odometry is waited for, seconds.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.5)]
    patience: f64,
    /// Play the code on a sound device and take the sound that it records, in place of standard input.
    #[arg(long, conflicts_with = "format")]
    audio: bool,
    /// Sound device that records; the system's default unless given.
    #[arg(long, value_name = "DEVICE", requires = "audio")]
    microphone: Option<String>,
    /// Sound device that plays; the system's default unless given.
    #[arg(long, value_name = "DEVICE", requires = "audio")]
    loudspeaker: Option<String>,
    /// Largest sample that is played, decibels of full scale.
    #[arg(
        long,
        value_name = "DB",
        default_value_t = -6.0,
        allow_hyphen_values = true,
        requires = "audio"
    )]
    level: f64,
    /// Time after which the sound device stops; Ctrl-C does unless given.
    #[arg(long, value_name = "S", requires = "audio")]
    seconds: Option<f64>,
    /// Show pose, fit and the newest echoes on standard error, which is a terminal; poses then go to standard output
    /// only where that is none.
    #[arg(long)]
    view: bool,
}

impl Arguments {
    /// Runs the command.
    pub(crate) fn run(self) -> Result<()> {
        if !(0.0..=60.0).contains(&self.patience) {
            bail!("--patience: {} s; give 0 to 60", self.patience);
        }
        let Input {
            mut engine,
            parameters,
            mut sound,
            device,
        } = self.open()?;
        let fastest_mps = 0.1 * parameters.signal.speed_of_sound_mps;
        let patience = Duration::from_secs_f64(self.patience);
        let mut wheels = Wheels::start(&self.odometry, patience, fastest_mps)?;
        let (mut held, reading_s) = self.align(&parameters, &mut sound, &mut wheels)?;
        let shown_s = match self.clock {
            Clock::Wheels => reading_s,
            Clock::Sound => 0.0,
        };
        let period_s = parameters.period_s();
        let mut output = std::io::stdout().lock();
        let mut view = self.view.then(View::default);
        let (mut work, mut slow) = (Duration::ZERO, false);
        for number in 0_u64.. {
            let next = match held.pop_front() {
                Some(period) => Some(period),
                None => sound.next()?,
            };
            let Some((samples, heard)) = next else {
                break;
            };
            let start_s = number as f64 * period_s;
            let (odometry, came) = wheels.mean(start_s, (number + 1) as f64 * period_s)?;
            let began = Instant::now();
            let told = engine.step(&samples, heard, odometry)?;
            work += began.elapsed();
            if number as u32 % WORK_PERIODS == WORK_PERIODS - 1 {
                let mean_s = work.as_secs_f64() / f64::from(WORK_PERIODS);
                if mean_s > period_s && !slow {
                    eprintln!(
                        "warning: a period takes {:.0} ms of work and lasts {:.0} ms: poses fall behind; give fewer \
                         --particles or a smaller --window",
                        1e3 * mean_s,
                        1e3 * period_s
                    );
                }
                (work, slow) = (Duration::ZERO, mean_s > period_s);
            }
            if let Some(told) = told {
                let status = if heard { told.status } else { "gap" };
                if let Some(view) = &mut view {
                    view.show(
                        &told,
                        status,
                        &view::picture_of(&engine, &parameters.signal),
                    );
                    if output.is_terminal() {
                        continue;
                    }
                }
                let text = self.line(&told, shown_s, status, came)?;
                match output
                    .write_all(text.as_bytes())
                    .and_then(|()| output.flush())
                {
                    Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => return Ok(()),
                    done => done.context("standard output")?,
                }
            }
        }
        let report = sound.report();
        eprintln!(
            "{} periods, {} of them without the code; the recorder runs {:+.2} ppm",
            report.periods, report.unheard, report.drift_ppm
        );
        if let Some(lost) = device.map(|device| device.lost()).filter(|lost| *lost > 0) {
            eprintln!(
                "warning: {lost} samples of the device were lost: poses came too slowly to take them"
            );
        }
        Ok(())
    }

    /// A pose as a line.
    fn line(&self, told: &Told, shown_s: f64, status: &str, came: bool) -> Result<String> {
        if self.output == Output::Tum {
            let one = Trajectory {
                t_s: vec![told.t_s + shown_s],
                poses: vec![told.pose],
            };
            return Ok(one.to_tum());
        }
        let line = serde_json::json!({
            "t_s": told.t_s + shown_s,
            "x_m": told.pose.x_m,
            "y_m": told.pose.y_m,
            "heading_rad": told.pose.heading_rad,
            "covariance": told.covariance,
            "status": status,
            "odometry": if came { "ok" } else { "late" },
            "fit": told.fit,
            "latest": {
                "t_s": told.latest_s + shown_s,
                "x_m": told.latest.x_m,
                "y_m": told.latest.y_m,
                "heading_rad": told.latest.heading_rad,
            },
        });
        Ok(serde_json::to_string(&line)? + "\n")
    }
}
