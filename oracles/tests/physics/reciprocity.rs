//! Source and microphone may change places: [`oracles::laws::free_field`] says layout, formula and tolerance.
//!
//! Bias: none between the walls, the operator is symmetric; the layer is not exactly reciprocal, but its echoes are
//! below -60 dB. Rounding of the fields makes a slow wandering far below the band (some 1e-4 of the signal in these 17
//! ms), hence single frequencies are compared.

use crate::rig::assert_within;
use oracles::laws::Depth;
use oracles::laws::free_field::measure_reciprocity;

#[test]
fn source_and_microphone_change_places() {
    let found = measure_reciprocity(Depth::Full).expect("finite fields");
    assert_within("reciprocity", &found);
}
