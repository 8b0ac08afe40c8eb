//! Angular resolution of M periods: the Doppler bank's response to one exact echo (2023 abstract, section 3).
//!
//! The echo of a plane wall at 60 degrees from the heading is the transmitted signal with time scaled by `(c + v cos
//! theta) / (c - v cos theta)` about the block's centre. The bank's intensity at the echo's delay over cos(theta) is
//! for one frequency f_c the magnitude of `sinc(M T 2 f_c v / c (cos theta - cos 60 deg))`: a Doppler cell is `c / (2
//! f_c M T v)` wide, and the half-power width 0.886 of a cell.

use anyhow::{Context, Result};
use fdtd::waveform::PeriodicWaveform;
use localizer::Parameters;
use localizer::echo::DopplerBank;
use localizer::parameters::MeasurementParameters;
use localizer::signal::waveform::transmit_period;

use super::PaperSession;
use crate::data::table::{Table, cell};
use crate::metrics::rounded;
use crate::summary::{ResolutionCell, Summary};

/// Numbers of periods.
const PERIODS: [usize; 8] = [1, 2, 3, 4, 5, 6, 7, 8];
/// N_theta of the bank: far finer than the resolution of M = 8.
const DIRECTIONS: usize = 720;
/// Speed of the robot, m/s.
const SPEED_MPS: f64 = 0.3;
/// Direction of the wall over the heading: its cosine.
const WALL_COS: f64 = 0.5;
/// Range of the wall at the block's centre, metres.
const RANGE_M: f64 = 2.0;
/// Band of the signal, hertz, as in the scenes.
const BAND_HZ: [f64; 2] = [0.0, 19_000.0];
/// Width of |sinc|^2 at half its height.
const HALF_POWER: f64 = 0.885_893;

/// One block of an exact echo of amplitude 1.
fn echo(parameters: &Parameters, delay_s: f64) -> Vec<f32> {
    let waveform = PeriodicWaveform::with_band(
        &transmit_period(&parameters.signal),
        parameters.period_s(),
        BAND_HZ,
        4.0 * parameters.signal.sample_rate_hz,
    );
    let count = parameters.measurement.periods * parameters.samples_per_period();
    let centre_s = 0.5 * count as f64 / parameters.signal.sample_rate_hz;
    let approach = SPEED_MPS * WALL_COS;
    let scale = (parameters.signal.speed_of_sound_mps + approach)
        / (parameters.signal.speed_of_sound_mps - approach);
    (0..count)
        .map(|k| {
            let t_s = k as f64 / parameters.signal.sample_rate_hz;
            waveform.value(centre_s + scale * (t_s - centre_s) - delay_s) as f32
        })
        .collect()
}

/// The bank's response over cos(theta), relative to its greatest value, from the stern to the bow.
fn answer(parameters: &Parameters) -> Result<Vec<(f64, f64)>> {
    let bank = DopplerBank::new(parameters)?;
    let delay = parameters.signal.delay_of_range(RANGE_M);
    let block = echo(parameters, delay as f64 / parameters.signal.sample_rate_hz);
    let mut intensity = bank.intensity();
    bank.measure(&block, SPEED_MPS, &mut bank.scratch(), &mut intensity);
    let column = intensity.column(delay);
    let greatest = column.iter().fold(0.0_f32, |a, b| a.max(*b));
    Ok(column
        .iter()
        .enumerate()
        .rev()
        .map(|(direction, value)| {
            let theta = std::f64::consts::PI * direction as f64 / DIRECTIONS as f64;
            (theta.cos(), f64::from(value / greatest))
        })
        .collect())
}

/// Width of the main lobe at half power.
fn half_power_width(answer: &[(f64, f64)]) -> Option<f64> {
    let level = 0.5_f64.sqrt();
    let peak = (0..answer.len()).max_by(|&a, &b| answer[a].1.total_cmp(&answer[b].1))?;
    let crossing = |mut indices: Box<dyn Iterator<Item = usize>>, towards: i64| {
        let outside = indices.find(|&index| answer[index].1 < level)?;
        let inside = answer.get(usize::try_from(outside as i64 + towards).ok()?)?;
        let outside = answer[outside];
        let share = (level - outside.1) / (inside.1 - outside.1);
        Some(outside.0 + share * (inside.0 - outside.0))
    };
    let left = crossing(Box::new((0..peak).rev()), 1)?;
    let right = crossing(Box::new(peak..answer.len()), -1)?;
    Some(right - left)
}

/// Runs the study.
pub(super) fn run(session: &PaperSession, summary: &mut Summary) -> Result<()> {
    let mut table = Table::new(["m", "cos_theta", "level"]);
    let mut widths = Table::new(["m", "half_power_width", "theory"]);
    summary.angular_resolution.clear();
    for periods in PERIODS {
        let parameters = Parameters {
            measurement: MeasurementParameters {
                periods,
                directions: DIRECTIONS,
                max_range_m: 2.0 * RANGE_M,
                min_range_m: 0.0,
                range_pool_m: 0.0,
                ..session.parameters.measurement
            },
            ..session.parameters.clone()
        };
        let answer = answer(&parameters)?;
        let width = half_power_width(&answer)
            .context("the echo's lobe reaches beyond all directions; drive faster")?;
        let block_s = periods as f64 * parameters.period_s();
        let theory = HALF_POWER * parameters.signal.speed_of_sound_mps
            / (2.0 * parameters.signal.carrier_hz * block_s * SPEED_MPS);
        for (cosine, level) in answer {
            table.push([periods.to_string(), cell(cosine, 5), cell(level, 5)]);
        }
        widths.push([periods.to_string(), cell(width, 5), cell(theory, 5)]);
        summary.angular_resolution.push(ResolutionCell {
            m: periods,
            half_power_width: rounded(width),
            theory: rounded(theory),
        });
    }
    table.write(&session.data("angular_resolution.csv"))?;
    widths.write(&session.data("angular_resolution_widths.csv"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bank_resolves_as_theory_predicts() {
        // Tolerance 15 %: theory holds for the carrier alone, the code fills 0 to 19 kHz around it.
        for periods in [2, 6] {
            let parameters = Parameters {
                measurement: MeasurementParameters {
                    periods,
                    directions: DIRECTIONS,
                    max_range_m: 4.0,
                    ..MeasurementParameters::default()
                },
                ..Parameters::default()
            };
            let answer = answer(&parameters).unwrap();
            let peak = answer.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            assert!((peak.0 - WALL_COS).abs() < 0.01, "{}", peak.0);
            let width = half_power_width(&answer).unwrap();
            let theory =
                HALF_POWER * 340.0 / (2.0 * 10_000.0 * periods as f64 * 0.1023 * SPEED_MPS);
            assert!(
                (width / theory - 1.0).abs() < 0.15,
                "{periods}: {width} {theory}"
            );
        }
    }
}
