//! What the absorbing layer sends back: [`fdtd::validation::layer`] says layout, formula and tolerance.

use fdtd::scheme::Scheme;
use fdtd::validation::layer::reflection_db;

#[test]
fn the_layer_reflects_less_than_a_thousandth_up_to_sixty_degrees() {
    for scheme in Scheme::ALL {
        for (degrees, most_db) in [
            (0.0, -60.0),
            (30.0, -60.0),
            (45.0, -60.0),
            (60.0, -60.0),
            (80.0, -40.0),
        ] {
            let reflection_db = reflection_db(scheme, degrees).expect("a finite field");
            println!("layer, {scheme}, {degrees} degrees: {reflection_db:.1} dB");
            assert!(
                reflection_db < most_db,
                "{scheme} at {degrees} degrees: {reflection_db} dB"
            );
        }
    }
}
