//! Time of one step of the localizer on one thread, with the paper's parameters: Doppler bank and particle filter.

use std::hint::black_box;
use std::time::Instant;

use anyhow::Result;
use localizer::echo::DopplerBank;
use localizer::filter::particle_filter::ParticleFilter;
use localizer::image::map_builder;
use localizer::parameters::FilterParameters;
use localizer::{EchoBlock, EchoSequence, MapImage, Method, Odometry, Parameters, Pose};
use serde::Serialize;

use super::stopwatch::Stopwatch;
use crate::metrics::quantile;
use crate::run::interrupt;

/// Steps timed.
const STEPS: usize = 200;
/// Steps before the first timed one.
const WARM_UP: usize = 10;
/// Half width of the matched window, metres.
const HALF_WIDTH_M: f64 = 4.0;
/// A circle of one metre around the origin: the robot stays in its map for any number of steps.
const CIRCLE: Odometry = Odometry {
    v_mps: 0.3,
    omega_radps: 0.3,
};

/// One line of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// `doppler_bank`, eqs. (1)-(3) for one block, or `filter_step`, eqs. (8)-(18).
    pub stage: &'static str,
    /// Threads; always one.
    pub threads: usize,
    /// Steps timed.
    pub steps: usize,
    /// Mean processor time, milliseconds: the cost of a step, also on a busy machine.
    pub running_ms: f64,
    /// Median by the wall clock, milliseconds.
    pub median_ms: f64,
    /// 95 of 100 take less, milliseconds.
    pub p95_ms: f64,
    /// Limit for real time with a reserve, milliseconds.
    pub limit_ms: f64,
    /// Time of the 2024 paper's MATLAB code (filter: with a window of 3 m), milliseconds.
    pub paper_ms: f64,
    /// Periods M of a block.
    pub periods: usize,
    /// Directions of the bank.
    pub directions: usize,
    /// Particles.
    pub particles: usize,
    /// Half width of the window, metres.
    pub half_width_m: f64,
    /// Bins K of the mutual information.
    pub bins: usize,
}

/// A signal without structure; the time does not depend on it.
fn noise(length: usize) -> Vec<f32> {
    let mut state = 1_u32;
    (0..length)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 8_388_608.0 - 1.0
        })
        .collect()
}

/// Milliseconds of the calls of `work` after the warm-up.
struct Times {
    /// Mean processor time.
    running: f64,
    /// Each by the wall clock.
    wall: Vec<f64>,
}

/// Calls `work` again and again.
fn times_ms(mut work: impl FnMut()) -> Result<Times> {
    let mut times = Vec::with_capacity(STEPS);
    let mut stopwatch = Stopwatch::start();
    for step in 0..WARM_UP + STEPS {
        interrupt::check()?;
        if step == WARM_UP {
            stopwatch = Stopwatch::start();
        }
        let start = Instant::now();
        work();
        if step >= WARM_UP {
            times.push(1e3 * start.elapsed().as_secs_f64());
        }
    }
    Ok(Times {
        running: 1e3 * stopwatch.seconds() / STEPS as f64,
        wall: times,
    })
}

/// The map that one block of echoes at the origin draws.
fn map_of(parameters: &Parameters, block: &EchoBlock) -> Result<MapImage> {
    let sequence = EchoSequence {
        parameters: parameters.clone(),
        blocks: vec![block.clone()],
        odometry: vec![block.odometry],
    };
    Ok(map_builder::build(&[(&sequence, &[Pose::default()])])?)
}

/// Measures both stages.
///
/// # Errors
/// [`interrupt::Interrupted`] on request.
pub fn measure() -> Result<[Row; 2]> {
    let parameters = Parameters {
        filter: FilterParameters {
            window_half_width_m: HALF_WIDTH_M,
            ..FilterParameters::default()
        },
        ..Parameters::default()
    };
    let bank = DopplerBank::new(&parameters)?;
    let samples = noise(bank.block_length());
    let (mut scratch, mut intensity) = (bank.scratch(), bank.intensity());
    let bank_ms = times_ms(|| {
        bank.measure(
            black_box(&samples),
            CIRCLE.v_mps,
            &mut scratch,
            &mut intensity,
        );
    })?;
    // A few bright echoes instead of a grey image: the histograms then look as those of a room do.
    intensity.mapv_inplace(|value| value.powi(4));
    let block = EchoBlock {
        index: 0,
        t_s: 0.0,
        odometry: CIRCLE,
        stationary: false,
        toa_intensity: vec![0.0; intensity.ncols()],
        intensity,
    };
    let map = map_of(&parameters, &block)?;
    let start = Pose {
        y_m: -1.0,
        ..Pose::default()
    };
    let mut filter = ParticleFilter::new(&parameters, start, 1);
    let filter_ms = times_ms(|| {
        filter.predict(black_box(CIRCLE), parameters.period_s());
        filter.weigh(block.polar(Method::Doppler), &map);
        black_box(filter.expectation());
        filter.resample();
    })?;
    let row = |stage, times: &Times, limit_ms, paper_ms| Row {
        stage,
        threads: 1,
        steps: times.wall.len(),
        running_ms: times.running,
        median_ms: quantile(&times.wall, 0.5),
        p95_ms: quantile(&times.wall, 0.95),
        limit_ms,
        paper_ms,
        periods: parameters.measurement.periods,
        directions: block.intensity.nrows(),
        particles: parameters.filter.particles,
        half_width_m: parameters.filter.window_half_width_m,
        bins: parameters.filter.bins,
    };
    Ok([
        row("doppler_bank", &bank_ms, 3.0, 32.0),
        row("filter_step", &filter_ms, 2.0, 57.0),
    ])
}
