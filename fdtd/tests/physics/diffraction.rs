//! Diffraction at the edge of a rigid half plane: [`fdtd::validation::diffraction`] says layout, formula and tolerance.

use fdtd::validation::Depth;
use fdtd::validation::diffraction::measure;

#[test]
#[ignore = "the tolerance is a guess until it has been measured"]
fn sound_bends_round_an_edge_as_sommerfeld_says() {
    for measurement in measure(Depth::Full).expect("finite fields") {
        println!("diffraction: {measurement:?}");
        assert!(measurement.passed(), "{measurement:?}");
    }
}
