//! Air that walls enclose but for a gap: its lowest resonance lies far below the band and must not grow over a long run.
//!
//! Layout: 200 x 200 cells, a layer of 20 cells, four walls of 4 cells around 100 x 100 cells with a gap of 20 cells in the middle of
//! two of them; all air inside starts at 1 Pa.
//! Formula: nothing brings energy in, so that the pressure cannot grow.
//! Bias: the layer stretches space by sigma/omega, so far below the band it hardly absorbs; decay is not asked for.
//! Tolerance: in each later sixth of 600 000 steps (5 s) the largest pressure is below 1 Pa. A layer that leaves the fourth-order
//! part of m13 unstretched grows without bound here.

use crate::rig::Rig;
use fdtd::field::Field;
use fdtd::scheme::Scheme;

#[test]
fn the_resonance_behind_a_gap_does_not_grow() {
    for scheme in Scheme::ALL {
        let rig = Rig::open(scheme, 200, 200).with_walls(|ix, iy| {
            let inside = |k: usize| (50..150).contains(&k);
            let wall = |k: usize| (46..50).contains(&k) || (150..154).contains(&k);
            let gap = |k: usize| (90..110).contains(&k);
            let across = wall(ix) && (inside(iy) || wall(iy)) && !(ix < 50 && gap(iy));
            let along = wall(iy) && (inside(ix) || wall(ix)) && !(iy >= 150 && gap(ix));
            across || along
        });
        let mut field = rig.field();
        let mut state = field.state();
        for iy in 50..150 {
            for ix in 50..150 {
                state.pressure[iy * 200 + ix] = 1.0;
                state.previous[iy * 200 + ix] = 1.0;
            }
        }
        field.set_state(&state);
        let silence = rig.silence(4000);
        let sixths: Vec<f32> = (0..6)
            .map(|_| {
                let largest = (0..25).map(|_| {
                    let mut received = Vec::new();
                    field.advance(&silence, &mut received);
                    received.iter().fold(0.0_f32, |most, p| most.max(p.abs()))
                });
                largest.fold(0.0, f32::max)
            })
            .collect();
        println!("late time, {scheme}: largest pressure in each sixth {sixths:?} Pa");
        assert!(
            sixths[1..].iter().all(|&largest| largest < 1.0),
            "{scheme}: {sixths:?} Pa"
        );
    }
}
