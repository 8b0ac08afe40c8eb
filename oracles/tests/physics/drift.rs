//! A million steps in f32 between rigid walls: [`oracles::laws::drift`] says layout, formula, bias and tolerance.

use oracles::laws::Depth;
use oracles::laws::drift::{SCHEMES, measure};

#[test]
fn a_million_steps_do_not_drift() {
    let measurements = measure(Depth::Full).expect("no field fails here");
    assert_eq!(measurements.len(), 2 * SCHEMES.len());
    for measurement in measurements {
        println!("drift: {measurement:?}");
        assert!(measurement.passed(), "{measurement:?}");
    }
}
