//! What `track` needs before the first pose: parameters, localizer, and the wheels' clock.

use std::collections::VecDeque;

use anyhow::{Result, bail};
use localizer::echo::block_stream;
use localizer::io::description::{PeriodicSpectrum, TransmitDescription};
use localizer::io::recording_clocks::{WHEELS_S, WheelClock};
use localizer::io::recording_source::working_rate;
use localizer::landmarks::{LandmarkMap, Start};
use localizer::{MapImage, Method, Parameters};

use super::super::start::StartArgument;
use super::Arguments;
use super::sound::{Period, Sound};
use super::wheels::Wheels;
use crate::localization::{START_SIGMA, Stream};

/// Time of the wheels' log that is waited for before its clock is looked for, in seconds.
const FIRST_LOG_S: f64 = 15.0;

/// Time by which a log may have begun before the sound where its clock is looked for, in seconds.
const EARLY_LOG_S: f64 = 10.0;

/// Longest time of sound that waits for a drive that tells the wheels' clock, in seconds.
const LONGEST_WAIT_S: f64 = 120.0;

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
    pub(super) fn engine(&self, rate_hz: f64) -> Result<(Stream, Parameters)> {
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
            let stream = Stream::among_landmarks(&parameters, map, &start)?;
            return Ok((stream, parameters));
        }
        let StartArgument::Pose(pose) = self.start else {
            bail!("--start unknown: needs --method landmarks; give X,Y,DEG");
        };
        let map = MapImage::read(&self.map)?;
        let parameters = self.parameters(map.parameters.clone(), rate_hz)?;
        let stream = Stream::by_images(parameters.clone(), map, pose, self.seed)?;
        Ok((stream, parameters))
    }

    /// Finds what the wheels' clock shows at the first period; the periods of sound that this took come back.
    pub(super) fn align(
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
}
