//! Sound on the grid is as fast as the discrete dispersion relation says: [`fdtd::validation::dispersion`] says layout, formula and tolerance.

use fdtd::scheme::Scheme;
use fdtd::validation::Depth;
use fdtd::validation::dispersion::all;

#[test]
fn phase_velocity_over_frequency_and_angle() {
    let velocities = all(Depth::Full).expect("finite fields");
    assert_eq!(velocities.len(), 3 * 2 * 4 + 3 * 6);
    for velocity in velocities {
        println!("dispersion: {velocity:?}");
        assert!(velocity.error.abs() < 1e-4, "{velocity:?}");
        let off = velocity.expected * (1.0 + velocity.error) - 1.0;
        assert!(
            velocity.scheme != Scheme::D25 || off.abs() < 1e-3,
            "{velocity:?}"
        );
    }
}
