//! Standing waves between four rigid walls, and the order at which their frequencies converge: [`oracles::laws::room`]
//! says layout, formula and tolerance.

use crate::rig::assert_within;
use oracles::laws::Depth;
use oracles::laws::room::{measure_modes, measure_order};

#[test]
fn modes_of_a_rigid_box_ring_at_the_grids_frequencies() {
    assert_within("modes", &measure_modes(Depth::Full).expect("finite fields"));
}

#[test]
fn frequencies_converge_with_the_schemes_order() {
    assert_within("order", &measure_order(Depth::Full).expect("finite fields"));
}
