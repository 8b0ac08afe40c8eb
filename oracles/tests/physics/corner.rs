//! A robot drives in front of a right-angled corner: [`oracles::laws::corner`] says layout, formula, bias and
//! tolerance.

use crate::rig::assert_within;
use oracles::laws::Depth;
use oracles::laws::corner::measure;

#[test]
fn a_recording_in_a_corner_is_that_of_the_image_sources() {
    let found = measure(Depth::Full).expect("finite fields");
    assert_within("corner", &found);
    // Sensitivity of the test: without the corner's echo the error is larger.
    let mut without = found.iter().filter(|one| one.informative);
    assert!(without.all(|one| one.measured > 0.2));
}
