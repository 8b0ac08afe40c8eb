//! Walls of an impedance: reflection over angle ([`fdtd::validation::impedance`] says layout, formula and tolerance), and passivity.
//!
//! Layout, passivity: a box turned by 12 degrees with a slanted screen, 120 x 120 cells, all walls of one impedance from 1e-6 to 1e6 times
//! that of the air; a broad burst, then 4000 steps.
//! Formula: the energy of the field and of the air before the surfaces never grows.
//! Bias: the sum of squares is not the energy, which goes back and forth between pressure, flow and surfaces.
//! Tolerance: the sum of squares after the last quarter is at most 1.5 times that after the second. What makes energy overflows.

use crate::rig::DX_M;
use fdtd::exact::burst::Burst;
use fdtd::field::Field;
use fdtd::scheme::Scheme;
use fdtd::validation::impedance::{CASES, largest};
use fdtd::validation::room::slanted_room;
use fdtd::walls::WallModel;

#[test]
fn the_reflection_factor_is_that_of_the_impedance() {
    for scheme in Scheme::ALL {
        for case in CASES {
            let [error, degrees, ratio] = largest(scheme, case);
            println!(
                "impedance, {scheme}, {} kHz: off by {error:.4} at {degrees:.0} degrees, Z = {ratio} rho c",
                case.0 / 1e3
            );
        }
    }
}

#[test]
fn no_impedance_makes_energy() {
    for scheme in Scheme::ALL {
        for model in WallModel::ALL {
            for ratio in [1e-6, 0.05, 1.0, 20.0, 1e6] {
                let rig = slanted_room(scheme, 120, model, Some(440.0 * ratio));
                let burst = Burst::from_zero(6e3, 2000.0);
                let mut field = rig.field();
                let middle = [60.0 * DX_M, 64.0 * DX_M];
                field.advance(
                    &rig.sounding(middle, &|t_s| burst.value(t_s), 400),
                    &mut Vec::new(),
                );
                let silence = rig.silence(1000);
                let quarters: [f64; 4] = std::array::from_fn(|_| {
                    field.advance(&silence, &mut Vec::new());
                    let pressure = field.state().pressure;
                    pressure.iter().map(|&p| f64::from(p).powi(2)).sum()
                });
                println!("passivity, {scheme}, {model}, Z = {ratio:e} rho c: {quarters:?}");
                assert!(
                    quarters[3] <= 1.5 * quarters[1],
                    "{scheme}, {model}, {ratio}: {quarters:?}"
                );
            }
        }
    }
}
