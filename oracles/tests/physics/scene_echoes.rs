//! Echoes of the paper-size scene beside its image sources: [`oracles::laws::scene_echoes`] says layout, formula, bias
//! and tolerance.

use crate::rig::assert_within;
use oracles::laws::Depth;
use oracles::laws::scene_echoes::measure;

#[test]
fn echoes_of_the_scene_are_those_of_its_images() {
    let found = measure(Depth::Quick).expect("finite fields");
    assert!(found.iter().filter(|one| !one.informative).count() >= 10);
    assert_within("echoes of the scene", &found);
}
