//! The pressure field at one time, as pictures need it.

use fdtd::simulation::Simulation;

/// Pressure of all cells of a field at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldFrame {
    /// Time of the drive, seconds.
    pub t_s: f64,
    /// Position of the lower left corner in the scene, metres.
    pub origin_m: [f64; 2],
    /// Cells along x.
    pub nx: usize,
    /// Cells along y.
    pub ny: usize,
    /// `[iy, ix]`, x fastest, in Pa.
    pub pressures: Vec<f32>,
}

impl FieldFrame {
    /// The present field of a simulation.
    pub fn of(simulation: &Simulation) -> Self {
        let (nx, ny, pressures) = simulation.pressure_frame();
        Self {
            t_s: simulation.time_s(),
            origin_m: simulation.origin_m(),
            nx,
            ny,
            pressures,
        }
    }
}
