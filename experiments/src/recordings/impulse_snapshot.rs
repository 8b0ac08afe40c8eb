//! Impulse snapshot: the sound field of a scene shortly after a short burst of the robot at rest.

use anyhow::Result;
use fdtd::motion::{DrivePath, MotionState};
use fdtd::scene::Scene;
use fdtd::simulation::{Flow, Simulation, SimulationOptions};
use oracles::exact::burst::Burst;

use crate::data::field_frame::FieldFrame;

/// Carrier and bandwidth of the burst, Hz: wave fronts of 7 cm, which are visible in a picture.
const BURST_HZ: [f64; 2] = [5e3, 1.8e3];

/// The field `t_s` seconds after a short burst of the loudspeaker at rest at the start of `path`.
///
/// # Errors
/// When the scene has no such path or the field refuses it.
pub fn frame(scene: &Scene, path: &str, t_s: f64) -> Result<FieldFrame> {
    let rest = MotionState {
        v_mps: 0.0,
        omega_radps: 0.0,
        ..scene.path(path)?.state_at(0.0)
    };
    let burst = Burst::from_zero(BURST_HZ[0], BURST_HZ[1]);
    // Time counts from the burst's peak.
    let end_s = t_s + burst.centre_s;
    let mut still = scene.clone();
    let path = DrivePath::uniform(rest, end_s)?;
    still.paths.insert("still".to_string(), path);
    let band_hz = [0.0, scene.waveform.band_hz[1]];
    let waveform = burst.every(2.0 * end_s, band_hz, 1.0 / scene.grid.dt_s);
    // A picture shows the waves beyond walls and drives too.
    let options = SimulationOptions {
        whole_domain: true,
        ..SimulationOptions::default()
    };
    let mut simulation = Simulation::new(&still, "still", &waveform, &options)?;
    simulation.run(&mut |_, _| Flow::Continue)?;
    Ok(FieldFrame::of(&simulation))
}
