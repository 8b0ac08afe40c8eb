//! Share of subnormal numbers in the field of a drive: `cargo run --release -p experiments --example subnormal_share
//! [SCENE] [PATH] [STEPS]`.
//!
//! Prints, as the drive goes on, the share of the pressure's cells that hold a subnormal number, and at the end the
//! share of all cell updates of the whole drive that these are, if no more come after the steps looked at.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use experiments::recordings::simulate::prepare;
use experiments::recordings::{Engine, RecordingSpec};
use fdtd::scene::Scene;
use fdtd::simulation::Flow;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let scene = arguments
        .next()
        .unwrap_or_else(|| "scenes/four_walls.json".to_owned());
    let path = arguments.next().unwrap_or_else(|| "mapping".to_owned());
    let steps: u64 = match arguments.next() {
        Some(text) => text.parse().with_context(|| format!("STEPS {text}"))?,
        None => 16_384,
    };
    ensure!(steps > 0, "STEPS 0: should be at least 1");
    let scene = Scene::load(&PathBuf::from(scene))?;
    let mut simulation = prepare(&scene, &RecordingSpec::of(&path, Engine::Fdtd), 0)?;
    // Cells times steps with a subnormal number, each look standing for the steps since the one before.
    let (mut subnormal, mut last, mut seen) = (0.0, 0, 0);
    simulation.run(&mut |progress, simulation| {
        let (.., pressure) = simulation.pressure_frame();
        let count = pressure.iter().filter(|p| p.is_subnormal()).count();
        let share = count as f64 / pressure.len() as f64;
        subnormal += share * (progress.step - seen) as f64;
        seen = progress.step;
        if count > 0 {
            last = progress.step;
        }
        if progress.step.is_power_of_two() || count > 0 {
            println!("step {:6}: {:.3} % subnormal", progress.step, 100.0 * share);
        }
        if progress.step < steps {
            Flow::Continue
        } else {
            Flow::Stop
        }
    })?;
    println!(
        "last seen at step {last} of {seen} looked at; {:.1e} of the cell updates of all {} steps",
        subnormal / simulation.steps_total() as f64,
        simulation.steps_total()
    );
    Ok(())
}
