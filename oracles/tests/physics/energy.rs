//! Between rigid walls energy stays: [`oracles::laws::room`] says layout, formula and tolerance.

use crate::rig::assert_within;
use oracles::laws::Depth;
use oracles::laws::room::measure_energy;

#[test]
fn energy_stays_in_a_closed_room() {
    assert_within(
        "energy",
        &measure_energy(Depth::Full).expect("finite fields"),
    );
}
