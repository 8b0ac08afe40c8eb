//! Arrival and level of the echo of a rigid wall, and the time scale of two reflections between parallel walls:
//! [`oracles::laws::echo`] says layout, formula and tolerance.

use crate::rig::assert_within;
use oracles::laws::Depth;
use oracles::laws::echo::{measure_image, measure_parallel};

#[test]
fn a_wall_echoes_as_its_image_source() {
    assert_within("echo", &measure_image(Depth::Full).expect("finite fields"));
}

#[test]
fn two_parallel_walls_do_not_change_the_time_scale() {
    let found = measure_parallel(Depth::Full).expect("finite fields");
    assert_within("parallel walls", &found);
}
