//! How well echoes are heard over the drive.

use anyhow::Result;
use localizer::Parameters;
use localizer::align::SoundReport;
use localizer::echo::block_stream;
use localizer::io::recording_source::RecordingSource;
use localizer::landmarks::peaks::PeakFinder;

use super::level::decibels;

/// Peaks of a block that are kept for the picture.
const KEPT: usize = 4;

/// What was heard.
#[derive(Debug, Clone, Default)]
pub(super) struct Heard {
    /// The sound after the whole drive.
    pub(super) report: SoundReport,
    /// Median over the moving blocks of the strongest echo over the block's median, in decibels.
    pub(super) over_db: f64,
    /// Mean number of echoes of a moving block.
    pub(super) a_block: f64,
    /// Median range of the strongest echoes in metres.
    pub(super) middle_m: f64,
    /// Strongest echoes over time: s, m.
    pub(super) peaks: Vec<(f64, f64)>,
}

/// Listens to a whole recording.
pub(super) fn hear(source: &RecordingSource) -> Result<Heard> {
    let mut parameters = Parameters::default().for_recording(&source.meta);
    let signal = &parameters.signal;
    let longest_m = signal.range_of_delay_m(signal.samples_per_period() as f64 - 1.0);
    parameters.measurement.max_range_m = parameters.measurement.max_range_m.min(longest_m);
    parameters.measurement.periods = 2;
    let mut finder = PeakFinder::new(&parameters);
    let (mut peaks, mut heard) = (Vec::new(), Heard::default());
    let (mut over, mut ranges, mut sorted) = (Vec::new(), Vec::new(), Vec::new());
    let (mut count, mut blocks) = (0, 0);
    let mut sound = source.sound()?;
    let period_s = parameters.period_s();
    let speed = |period: usize| {
        let start_s = period as f64 * period_s;
        localizer::odometry::mean_over_time(&source.odometry, start_s, start_s + period_s)
    };
    block_stream::measure_each(
        &parameters,
        &mut || sound.next_period(),
        &speed,
        &mut |block, _| {
            if block.stationary {
                return Ok(true);
            }
            finder.find(block.intensity.view(), block.odometry.v_mps, &mut peaks);
            blocks += 1;
            count += peaks.len();
            heard.peaks.extend(
                peaks
                    .iter()
                    .take(KEPT)
                    .map(|peak| (block.t_s, peak.range_m)),
            );
            if let Some(strongest) = peaks.first() {
                sorted.clear();
                sorted.extend(block.intensity.iter().step_by(7).copied());
                let middle = sorted.len() / 2;
                let (_, &mut median, _) = sorted.select_nth_unstable_by(middle, f32::total_cmp);
                over.push(decibels(strongest.amplitude / f64::from(median).max(1e-12)));
                ranges.push(strongest.range_m);
            }
            Ok(true)
        },
    )?;
    heard.report = sound.report().clone();
    heard.a_block = f64::from(count as u32) / f64::from(blocks.max(1));
    heard.over_db = median(over);
    heard.middle_m = median(ranges);
    Ok(heard)
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    match values.is_empty() {
        true => 0.0,
        false => *values.select_nth_unstable_by(middle, f64::total_cmp).1,
    }
}
