//! The rig that tests and `echolot validate` share, and its measurements as assertions.

use fdtd::field::{Field, StepForcing};
use fdtd::scheme::Scheme;
use fdtd::simulation::{Flow, Simulation, SimulationOptions};
use fdtd::walls::{Impedance, Wall, WallModel};
use fdtd::waveform::PeriodicWaveform;
use oracles::laws::Measurement;

pub(crate) use oracles::laws::conditions::Conditions;
pub(crate) use oracles::laws::rig::*;
pub(crate) use oracles::laws::setting::{Setting, Turn};

/// Prints the measurements of a law and asserts that all of them are within their tolerances.
pub(crate) fn assert_within(law: &str, found: &[Measurement]) {
    for measurement in found {
        println!(
            "{law}, {}: {} {:.4}",
            measurement.case, measurement.quantity, measurement.measured
        );
        assert!(measurement.passed(), "{law}: {measurement:?}");
    }
}

/// Chips on a carrier of 10 kHz on the papers' grid, one for each cycle, within a band there.
pub(crate) fn code_on_carrier(
    conditions: &Conditions,
    chips: usize,
    band_hz: [f64; 2],
) -> PeriodicWaveform {
    // Four samples per cycle of the carrier.
    let samples: Vec<f64> = (0..4 * chips)
        .map(|n| {
            let chip = n / 4;
            let sign = f64::from((chip * chip + chip / 3) % 7 < 3) * 2.0 - 1.0;
            sign * [1.0, 1.0, -1.0, -1.0][n % 4]
        })
        .collect();
    let period_s = conditions.s(samples.len() as f64 / 40e3);
    let band_hz = band_hz.map(|hz| conditions.hz(hz));
    PeriodicWaveform::with_band(&samples, period_s, band_hz, 1.0 / conditions.dt_s)
}

/// Default options with so many threads and an engine of choice.
pub(crate) fn engine(threads: usize, reference_engine: bool) -> SimulationOptions {
    SimulationOptions {
        threads,
        reference_engine,
        ..SimulationOptions::default()
    }
}

/// Runs a simulation until it has come to a step.
pub(crate) fn run_to(simulation: &mut Simulation, step: u64) {
    simulation
        .run(&mut |progress, _| match progress.step >= step {
            true => Flow::Stop,
            false => Flow::Continue,
        })
        .expect("a finite field");
}

/// Signal of a simulation run to its end.
pub(crate) fn recorded(mut simulation: Simulation) -> Vec<f32> {
    run_to(&mut simulation, u64::MAX);
    simulation.signal()
}

/// A checkpoint of a run as another one finds it.
pub(crate) fn handed_over(from: &Simulation, to: &mut Simulation) -> Result<(), fdtd::Error> {
    static COUNT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
    let count = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let name = format!("physics-{}-{count}.checkpoint", std::process::id());
    let file = std::env::temp_dir().join(name);
    from.save_checkpoint(&file)?;
    let loaded = to.load_checkpoint(&file);
    std::fs::remove_file(&file).expect("the checkpoint");
    loaded
}

/// Asserts that a run refuses the checkpoint of another.
pub(crate) fn assert_foreign(from: &Simulation, to: &mut Simulation) {
    let foreign = handed_over(from, to);
    assert!(
        foreign
            .as_ref()
            .is_err_and(|error| error.to_string().contains("other inputs")),
        "{foreign:?}"
    );
}

/// A closed box of 56 x 56 cells with walls that are rigid or of an impedance, each from `[x0, y0]` by `[x1, y1]` to
/// `[y1, x0]`, in m on the papers' grid.
pub(crate) fn crossed_room(
    setting: &Setting,
    scheme: Scheme,
    model: WallModel,
    lines: &[[f64; 4]],
    impedance: Option<&Impedance>,
) -> Rig {
    let mut rig = Rig::open(setting, scheme, 56, 56);
    rig.layer_cells = 0;
    let conditions = &setting.conditions;
    let wall = |&[x0, y0, x1, y1]: &[f64; 4]| Wall {
        points_m: [[x0, y0], [x1, y1], [y1, x0]]
            .map(|point| conditions.point(point))
            .to_vec(),
        thickness_m: conditions.m(0.012),
        impedance: impedance.cloned(),
    };
    let walls: Vec<Wall> = lines.iter().map(wall).collect();
    rig.with_model(model, &walls)
}

/// The largest sum of squares of the pressure, looked at every 11 steps: at one moment a mode that is alone may have
/// none.
pub(crate) fn largest_sum(field: &mut impl Field, steps: &[StepForcing]) -> f64 {
    let after = |some: &[StepForcing]| -> f64 {
        field.advance(some, &mut Vec::new());
        let pressure = field.state().pressure;
        pressure.iter().map(|&p| f64::from(p).powi(2)).sum()
    };
    steps.chunks(11).map(after).fold(0.0, f64::max)
}
