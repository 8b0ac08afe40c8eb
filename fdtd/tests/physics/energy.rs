//! Between rigid walls energy stays: [`fdtd::validation::room`] says layout, formula and tolerance.

use fdtd::scheme::Scheme;
use fdtd::validation::room::energy_changes;

#[test]
fn energy_stays_in_a_closed_room() {
    for scheme in Scheme::ALL {
        for change in energy_changes(scheme, 10) {
            println!("energy, {scheme}: {change:+.1e}");
            assert!(change.abs() < 1e-4, "{scheme}: energy changed by {change}");
        }
    }
}
