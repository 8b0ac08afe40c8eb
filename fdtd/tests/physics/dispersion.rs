//! Sound on the grid is as fast as the discrete dispersion relation says: [`fdtd::validation::dispersion`] says layout, formula and tolerance.

use fdtd::scheme::Scheme;
use fdtd::validation::Depth;
use fdtd::validation::dispersion::{TOLERANCES, all};

#[test]
fn velocity_over_frequency_and_angle() {
    let velocities = all(Depth::Full).expect("finite fields");
    assert_eq!(velocities.len(), 3 * 2 * 4 + 3 * 6);
    for velocity in velocities {
        println!("dispersion: {velocity:?}");
        let errors = [velocity.phase.error, velocity.group.error];
        for (error, allowed) in errors.into_iter().zip(TOLERANCES) {
            assert!(error.abs() < allowed, "{velocity:?}");
        }
        assert!(
            velocity.scheme != Scheme::D25 || velocity.phase.off().abs() < 1e-3,
            "{velocity:?}"
        );
    }
}
