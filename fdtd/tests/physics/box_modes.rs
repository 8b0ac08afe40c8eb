//! Standing waves between four rigid walls, and the order at which their frequencies converge: [`fdtd::validation::room`] says layout,
//! formula and tolerance.

use fdtd::scheme::Scheme;
use fdtd::validation::Depth;
use fdtd::validation::room::{MODES, detuning_allowed, measure_order, mode};

#[test]
fn modes_of_a_rigid_box_ring_at_the_grids_frequencies() {
    for scheme in Scheme::ALL {
        for numbers in MODES {
            let ringing = mode(scheme, numbers);
            println!("mode {numbers:?}, {scheme}: {ringing:?}");
            assert!(
                ringing.amplitude_error.abs() < 2e-4,
                "{scheme} {numbers:?}: {ringing:?}"
            );
            assert!(
                ringing.spill < 2e-4,
                "{scheme} {numbers:?}: other modes {ringing:?}"
            );
            assert!(
                ringing.continuum_hz > 5e3 || ringing.detuned.abs() < detuning_allowed(scheme),
                "{scheme} {numbers:?}: {ringing:?}"
            );
        }
    }
}

#[test]
fn frequencies_converge_with_the_schemes_order() {
    for measurement in measure_order(Depth::Full).expect("no field fails here") {
        println!("order: {measurement:?}");
        assert!(measurement.passed(), "{measurement:?}");
    }
}
