//! Sound on the grid is as fast as the discrete dispersion relation says: [`oracles::laws::dispersion`] says layout,
//! formula and tolerance.

use crate::rig::assert_within;
use oracles::laws::Depth;
use oracles::laws::dispersion::measure;

#[test]
fn velocity_over_frequency_and_angle() {
    let found = measure(Depth::Full).expect("finite fields");
    assert_eq!(found.len(), 4 * (4 * 2 * 4 + 3 * 6));
    assert_within("dispersion", &found);
}
