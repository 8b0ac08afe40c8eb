//! Air that walls enclose but for some gaps: its lowest resonance lies far below the band and must not grow over a long
//! run.
//!
//! Layout: the walls of `scenes/enclosed_walls.json` on a coarser grid of 300 x 300 cells, a layer of 20 cells; the air
//! in the middle starts at 1 Pa.
//! Formula: nothing brings energy in, so that the pressure cannot grow.
//! Bias: the layer stretches space by sigma/omega, so far below the band it absorbs slowly.
//! Tolerance: in the last quarter of 100 000 steps the largest pressure is below four fifths of that in the second
//! quarter. A layer that leaves the fourth-order part of m13 unstretched makes it grow four times instead.

use crate::rig::{Rig, Setting, Turn};
use fdtd::field::Field;
use fdtd::grid::Grid;
use fdtd::scene::Scene;
use fdtd::scheme::Scheme;
use std::path::Path;

#[test]
fn the_resonance_behind_gaps_does_not_grow() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/enclosed_walls.json");
    let scene = Scene::load(&file).expect("the scene of the repository");
    let coarse = Grid {
        nx: 300,
        ny: 300,
        dx_m: 5.0 / 300.0,
        dt_s: scene.grid.dt_s,
    };
    // slf has no fourth-order part, o13 is m13 with other weights.
    for scheme in [Scheme::M13, Scheme::D25] {
        let setting = Setting {
            turn: Turn::NONE,
            more_cells: [0; 2],
            ..Setting::drawn("late time", scheme.name())
        };
        let mut rig = Rig::open(&setting, scheme, coarse.nx, coarse.ny);
        rig.walls = scene.wall_model.cells(&coarse, &scene.walls);
        let mut field = rig.field();
        let mut state = field.state();
        let middle = 75..225;
        for iy in middle.clone() {
            for ix in middle.clone() {
                state.pressure[iy * coarse.nx + ix] = 1.0;
                state.previous[iy * coarse.nx + ix] = 1.0;
            }
        }
        field.set_state(&state);
        let silence = rig.silence(5000);
        let quarters: [f32; 4] = std::array::from_fn(|_| {
            (0..5).fold(0.0, |most, _| {
                let mut received = Vec::new();
                field.advance(&silence, &mut received);
                received.iter().fold(most, |most, p| p.abs().max(most))
            })
        });
        println!(
            "late time, {scheme}, {setting}: largest pressure in each quarter {quarters:?} Pa"
        );
        assert!(quarters[3] < 0.8 * quarters[1], "{scheme}: {quarters:?} Pa");
    }
}
