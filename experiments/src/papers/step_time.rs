//! Compute time of one step on one thread: Doppler bank and particle filter (Fig. 17).

use std::time::Instant;

use anyhow::{Context, Result};
use localizer::echo::DopplerBank;
use localizer::filter::tracker::Tracker;
use localizer::parameters::FilterParameters;
use localizer::{EchoSequence, MapImage, Method, Parameters, Recording, echo};

use super::PaperSession;
use crate::data::table::{Table, cell};
use crate::metrics::{quantile, rounded};
use crate::session::measurement_of;
use crate::summary::{FilterTime, StepTime, Summary};

/// Blocks left out until the memory is warm.
const WARM_UP: usize = 3;

/// Time of each block in the Doppler bank, eqs. (1)-(3), milliseconds.
fn bank_times_ms(
    session: &PaperSession,
    recording: &Recording,
    sequence: &EchoSequence,
    blocks: usize,
) -> Result<Vec<f64>> {
    let bank = DopplerBank::new(&session.parameters)?;
    let mut scratch = bank.scratch();
    let mut intensity = bank.intensity();
    let period = session.parameters.samples_per_period();
    let mut times = Vec::new();
    for block in sequence.blocks.iter().take(blocks + WARM_UP) {
        let start = block.index * period;
        let samples = recording
            .signal
            .get(start..start + bank.block_length())
            .context("the recording is shorter than its blocks")?;
        let started = Instant::now();
        bank.measure(samples, block.odometry.v_mps, &mut scratch, &mut intensity);
        times.push(1e3 * started.elapsed().as_secs_f64());
    }
    Ok(times.split_off(WARM_UP.min(times.len())))
}

/// Time of each block in the particle filter, eqs. (8)-(18), milliseconds.
fn filter_times_ms(
    recording: &Recording,
    sequence: &EchoSequence,
    map: &MapImage,
    parameters: &Parameters,
    blocks: usize,
) -> Result<Vec<f64>> {
    let mut tracker = Tracker::new(parameters, recording.start_pose(), 0)?;
    let mut times = Vec::new();
    for (index, block) in sequence.blocks.iter().enumerate().take(blocks + WARM_UP) {
        let started = Instant::now();
        std::hint::black_box(tracker.update(block, sequence.recent_odometry(index), map));
        times.push(1e3 * started.elapsed().as_secs_f64());
    }
    Ok(times.split_off(WARM_UP.min(times.len())))
}

/// Runs the study.
pub(super) fn run(
    session: &PaperSession,
    half_widths_m: &[f64],
    blocks: usize,
    summary: &mut Summary,
) -> Result<()> {
    let recording = session
        .recordings
        .read(&session.recordings.spec("localization", None), false)?;
    let doppler = Parameters {
        filter: FilterParameters {
            method: Method::Doppler,
            ..session.parameters.filter
        },
        ..session.parameters.clone()
    };
    let sequence = echo::measure(&recording, &measurement_of(&doppler, &session.parameters))?;
    let map = session.measurements.map(None, &doppler)?;
    let mut table = Table::new(["stage", "half_width_m", "time_ms"]);
    let mut add = |stage: &str, half_width: String, times: &[f64]| {
        for time in times {
            table.push([stage.to_string(), half_width.clone(), cell(*time, 4)]);
        }
    };
    let bank = bank_times_ms(session, &recording, &sequence, blocks)?;
    add("doppler_bank", String::new(), &bank);
    let mut filter_by_window = Vec::new();
    for &half_width_m in half_widths_m {
        let parameters = Parameters {
            filter: FilterParameters {
                window_half_width_m: half_width_m,
                ..doppler.filter
            },
            ..doppler.clone()
        };
        let times = filter_times_ms(&recording, &sequence, &map, &parameters, blocks)?;
        add("filter", cell(half_width_m, 2), &times);
        filter_by_window.push(FilterTime {
            half_width_m,
            median_ms: rounded(quantile(&times, 0.5)),
        });
    }
    table.write(&session.data("step_time.csv"))?;
    let filter = filter_times_ms(&recording, &sequence, &map, &doppler, blocks)?;
    summary.step_time_ms = Some(StepTime {
        doppler_bank: rounded(quantile(&bank, 0.5)),
        filter: rounded(quantile(&filter, 0.5)),
        filter_by_window,
    });
    Ok(())
}
