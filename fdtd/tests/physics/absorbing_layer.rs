//! What the absorbing layer sends back: [`fdtd::validation::layer`] says layout, formula and tolerance.

use crate::rig::assert_within;
use fdtd::validation::Depth;
use fdtd::validation::layer::measure;

#[test]
fn the_layer_reflects_less_than_a_thousandth_up_to_sixty_degrees() {
    assert_within("layer", &measure(Depth::Full).expect("finite fields"));
}
