//! Source and microphone may change places: [`fdtd::validation::free_field`] says layout, formula and tolerance.
//!
//! Bias: none between the walls, the operator is symmetric; the layer is not exactly reciprocal, but its echoes are below -60 dB. Rounding of the
//! fields makes a slow wandering far below the band (some 1e-4 of the signal in these 17 ms), hence single frequencies are compared.

use fdtd::scheme::Scheme;
use fdtd::spread::Spread;
use fdtd::validation::free_field::exchange;

#[test]
fn source_and_microphone_change_places() {
    for scheme in Scheme::ALL {
        for spread in Spread::ALL {
            let error = exchange(scheme, spread).expect("a finite field");
            println!("reciprocity, {scheme}, {spread}: {error:.1e}");
            assert!(error < 1e-4, "{scheme}, {spread}: {error}");
        }
    }
}
