//! Between rigid walls energy stays: [`fdtd::validation::room`] says layout, formula and tolerance.

use fdtd::scheme::Scheme;
use fdtd::validation::room::{closed_rig, energy_changes, slanted_rig};

#[test]
fn energy_stays_in_a_closed_room() {
    for scheme in Scheme::ALL {
        for rig in [closed_rig(scheme, 160), slanted_rig(scheme, 160)] {
            for change in energy_changes(&rig, 10) {
                println!("energy, {scheme}: {change:+.1e}");
                assert!(change.abs() < 1e-4, "{scheme}: energy changed by {change}");
            }
        }
    }
}
