//! `echolot track`.

mod engine;
mod pcm;
mod wheels;

use std::collections::VecDeque;
use std::io::{BufReader, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use localizer::align::{SoundAligner, SoundClock, SoundReport};
use localizer::echo::block_stream;
use localizer::io::description::{PeriodicSpectrum, TransmitDescription};
use localizer::io::recording_clocks::{WHEELS_S, WheelClock};
use localizer::io::recording_source::working_rate;
use localizer::landmarks::{LandmarkLocalizer, LandmarkMap, Noise, Start};
use localizer::{Localizer, MapImage, Method, Parameters, Trajectory};

use self::engine::{Engine, Told};
use self::pcm::{Format, Layout, Stream};
use self::wheels::Wheels;
use super::landmarks::START_SIGMA;
use super::localize::{MethodArgument, StartArgument, start, start_sigma};

/// Time of the wheels' log that is waited for before its clock is looked for, in seconds.
const FIRST_LOG_S: f64 = 15.0;

/// Time by which a log may have begun before the sound where its clock is looked for, in seconds.
const EARLY_LOG_S: f64 = 10.0;

/// Longest time of sound that waits for a drive that tells the wheels' clock, in seconds.
const LONGEST_WAIT_S: f64 = 120.0;

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
    echolot track --map maps/room --odometry drive/odometry.csv --start 1.2,0.8,90 --output tum < drive/signal.wav\n\n\
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
    /// Sample rate of raw samples, Hz.
    #[arg(long, value_name = "F", default_value_t = 48_000.0)]
    rate: f64,
    /// Channels of raw samples.
    #[arg(long, value_name = "N", default_value_t = 1)]
    channels: usize,
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
}

/// Samples of a period and whether the code was heard in it.
type Period = (Vec<f32>, bool);

/// Sound as it comes, in periods.
struct Sound {
    stream: Stream,
    channels: usize,
    /// The channels that may hold the code, in their order; one from when it is found.
    candidates: Vec<Candidate>,
    samples: Vec<f32>,
    ended: bool,
    gaps: usize,
}

impl Sound {
    /// The next period and whether the code was heard in it; none at the end.
    fn next(&mut self) -> Result<Option<Period>> {
        while self.candidates[0].ready.is_empty() && !self.ended {
            let had = self.candidates[0].aligner.has_code();
            let piece = self.stream.next()?;
            self.ended = piece.is_none();
            let mut trouble = None;
            for candidate in &mut self.candidates {
                self.samples.clear();
                let own = piece.iter().flatten().skip(candidate.channel - 1);
                self.samples.extend(own.step_by(self.channels));
                if let Err(error) = candidate.take(&self.samples, self.ended) {
                    trouble.get_or_insert(error);
                }
            }
            // Another channel counts only while this one has nothing to say.
            if let Some(found) = self
                .candidates
                .iter()
                .position(|own| own.aligner.has_code())
            {
                self.candidates.swap(0, found);
                self.candidates.truncate(1);
            } else if let Some(error) = trouble {
                return Err(error.into());
            }
            let Candidate {
                aligner, channel, ..
            } = &self.candidates[0];
            let report = aligner.report();
            if !had && report.code_db.is_some() {
                eprintln!(
                    "sound: channel {channel}: the first period begins {:.3} ms after the first sample, the \
                     recorder runs {:+.2} ppm",
                    1e3 * report.late_s,
                    report.drift_ppm
                );
            }
            for gap in &report.gaps[self.gaps..] {
                eprintln!(
                    "sound: {:.0} samples are missing at period {}",
                    gap.samples, gap.period
                );
            }
            self.gaps = report.gaps.len();
        }
        Ok(self.candidates[0].ready.pop_front())
    }

    fn report(&self) -> &SoundReport {
        self.candidates[0].aligner.report()
    }
}

/// A channel that may hold the code.
struct Candidate {
    channel: usize,
    aligner: SoundAligner,
    ready: VecDeque<Period>,
}

impl Candidate {
    fn take(&mut self, samples: &[f32], ended: bool) -> Result<(), localizer::Error> {
        let ready = &mut self.ready;
        let mut emit = |period: &[f32], heard: bool| {
            ready.push_back((period.to_vec(), heard));
            Ok(())
        };
        self.aligner.push(samples, &mut emit)?;
        match ended {
            true => self.aligner.finish(&mut emit),
            false => Ok(()),
        }
    }
}

impl Arguments {
    /// Parameters of the map with the code, rate and filter of this run.
    fn parameters(&self, mut parameters: Parameters, rate_hz: f64) -> Result<Parameters> {
        let signal = &mut parameters.signal;
        signal.speed_of_sound_mps = self.speed_of_sound.unwrap_or(signal.speed_of_sound_mps);
        let mut spectrum = None;
        if let Some(path) = &self.transmitted {
            if path.extension().is_some_and(|end| end == "json") {
                let code = TransmitDescription::read(path)?;
                signal.code_length = code.code_length;
                signal.chip_rate_hz = code.chip_rate_hz;
                signal.carrier_hz = code.carrier_hz;
            } else {
                let read = PeriodicSpectrum::read(path, None)?;
                signal.code_length = 1;
                signal.chip_rate_hz = 1.0 / read.period_s;
                signal.carrier_hz = read.centroid_hz();
                spectrum = Some(read);
            }
        } else if signal.code_order().is_none() {
            bail!(
                "{}: was made with a waveform of its own; give it with --transmitted",
                self.map.display()
            );
        }
        let period_s = signal.code_length as f64 / signal.chip_rate_hz;
        let band_hz = match &spectrum {
            Some(spectrum) => spectrum.highest_hz(),
            None => signal.carrier_hz + signal.chip_rate_hz,
        };
        let aligned = (self.late, self.drift) == (Some(0.0), Some(0.0));
        signal.sample_rate_hz = working_rate(period_s, rate_hz, band_hz, aligned);
        parameters.transmitted =
            spectrum.map(|spectrum| spectrum.samples(parameters.samples_per_period()).into());
        parameters.measurement.periods = self.periods.unwrap_or(parameters.measurement.periods);
        let filter = &mut parameters.filter;
        filter.method = self.method.of_images().unwrap_or(Method::Doppler);
        filter.window_half_width_m = self.window.unwrap_or(filter.window_half_width_m);
        filter.particles = self.particles.unwrap_or(filter.particles);
        if let Some([sigma_m, sigma_rad]) = self.start_sigma {
            (filter.start_sigma_m, filter.start_sigma_rad) = (sigma_m, sigma_rad);
        }
        parameters.check()?;
        Ok(parameters)
    }

    /// The localizer and its parameters.
    fn engine(&self, rate_hz: f64) -> Result<(Engine, Parameters)> {
        if self.method.of_images().is_none() {
            let map = LandmarkMap::read(&self.map)?;
            let parameters = self.parameters(map.parameters.clone(), rate_hz)?;
            let [sigma_m, sigma_rad] = self.start_sigma.unwrap_or(START_SIGMA);
            let start = match self.start {
                StartArgument::Unknown => Start::Unknown,
                StartArgument::Pose(pose) => Start::Known {
                    pose,
                    sigma_m,
                    sigma_rad,
                },
            };
            let localizer = LandmarkLocalizer::new(&parameters, map, &start, Noise::default())?;
            return Ok((Engine::Landmarks(Box::new(localizer)), parameters));
        }
        let StartArgument::Pose(pose) = self.start else {
            bail!("--start unknown: needs --method landmarks; give X,Y,DEG");
        };
        let map = MapImage::read(&self.map)?;
        let parameters = self.parameters(map.parameters.clone(), rate_hz)?;
        let measurement = &parameters.measurement;
        let rest = measurement.periods as f64 - measurement.reference_periods();
        let engine = Engine::Images {
            localizer: Box::new(Localizer::new(&parameters, map, pose, self.seed)?),
            particles: parameters.filter.particles as f64,
            rest_s: rest * parameters.period_s(),
            by_wheels: parameters.filter.method == Method::Odometry,
        };
        Ok((engine, parameters))
    }

    /// Runs the command.
    pub(crate) fn run(self) -> Result<()> {
        if !(0.0..=60.0).contains(&self.patience) {
            bail!("--patience: {} s; give 0 to 60", self.patience);
        }
        let mut input = BufReader::with_capacity(1 << 16, std::io::stdin());
        let layout = match self.format {
            Format::Wav => pcm::header(&mut input, self.channel)?,
            format => Layout {
                format,
                rate_hz: self.rate,
                channels: self.channels,
                channel: self.channel,
            }
            .checked()?,
        };
        let (mut engine, parameters) = self.engine(layout.rate_hz)?;
        let clock = SoundClock {
            late_s: self.late.map(|late_ms| 1e-3 * late_ms),
            drift_ppm: self.drift,
        };
        let channels = layout
            .channel
            .map_or(1..=layout.channels, |channel| channel..=channel);
        let candidates = channels.map(|channel| {
            Ok(Candidate {
                channel,
                aligner: SoundAligner::new(&parameters, layout.rate_hz, clock)?,
                ready: VecDeque::new(),
            })
        });
        let mut sound = Sound {
            candidates: candidates.collect::<Result<_>>()?,
            channels: layout.channels,
            samples: Vec::new(),
            stream: Stream::start(input, layout),
            ended: false,
            gaps: 0,
        };
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
        Ok(())
    }

    /// Finds what the wheels' clock shows at the first period; the periods of sound that this took come back.
    fn align(
        &self,
        parameters: &Parameters,
        sound: &mut Sound,
        wheels: &mut Wheels,
    ) -> Result<(VecDeque<Period>, f64)> {
        let mut held = VecDeque::new();
        let period_s = parameters.period_s();
        // The first period says how late the sound is.
        held.extend(sound.next()?);
        let late_s = sound.report().late_s;
        if let Some(reading_s) = self.odometry_clock {
            wheels.set_clock(reading_s + late_s);
            return Ok((held, reading_s + late_s));
        }
        while (held.len() as f64) * period_s < FIRST_LOG_S {
            let Some(period) = sound.next()? else {
                break;
            };
            held.push_back(period);
        }
        wheels.wait_since_first(FIRST_LOG_S)?;
        let mut clock = WheelClock::new(parameters, wheels.samples());
        let (speed, mut number) = (clock.odometry(), 0);
        let own = clock.parameters().clone();
        let mut trouble = None;
        block_stream::measure_each(
            &own,
            &mut || {
                number += 1;
                if let Some(period) = held.get(number - 1) {
                    return Ok(Some(period.clone()));
                }
                if held.len() as f64 * period_s > LONGEST_WAIT_S {
                    return Ok(None);
                }
                match sound.next() {
                    Ok(period) => {
                        held.extend(period.clone());
                        Ok(period)
                    }
                    Err(error) => {
                        trouble = Some(error);
                        Ok(None)
                    }
                }
            },
            &|_| speed,
            &mut |block, _| Ok(clock.push(block)),
        )?;
        if let Some(error) = trouble {
            return Err(error);
        }
        let length_s = held.len() as f64 * period_s;
        wheels.wait_since_first(length_s + EARLY_LOG_S)?;
        let Some(found) = clock.find(wheels.samples(), length_s) else {
            bail!(
                "--odometry-clock: {length_s:.0} s of sound do not tell what the wheels' clock shows; drive with turns \
                 and changes of speed for {WHEELS_S:.0} s, or give its reading at the first sample of the sound"
            );
        };
        eprintln!(
            "odometry: its clock shows {:.4} s at the first period, by the echoes (+-{:.1} ms)",
            found.reading_s,
            1e3 * found.sigma_s
        );
        wheels.set_clock(found.reading_s);
        Ok((held, found.reading_s))
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
