//! Reflection of the absorbing layer: [`oracles::laws::layer`] states layout, formula and tolerance.

use crate::rig::assert_within;
use oracles::laws::Depth;
use oracles::laws::layer::measure;

#[test]
fn the_layer_reflects_less_than_a_thousandth_up_to_sixty_degrees() {
    assert_within("layer", &measure(Depth::Full).expect("finite fields"));
}
