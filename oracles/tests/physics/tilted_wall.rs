//! Echo and scatter of walls that lie across the grid: [`oracles::laws::tilted`] says layout, formula and tolerance.

use fdtd::scheme::Scheme;
use fdtd::walls::WallModel;
use oracles::laws::tilted::{SCHEMES, TILTS, largest, scatter, scatter_setting, setting};
use oracles::laws::tilted_impedance::{self, PLACES, SLOPES, STRAY, stray};

#[test]
fn the_echo_of_a_tilted_wall_is_that_of_the_image_source() {
    for scheme in SCHEMES {
        for (tilt_deg, allowed) in TILTS {
            let setting = setting(scheme, tilt_deg);
            let error = largest(&setting, scheme, WallModel::CutCells, tilt_deg);
            let error = error.expect("a finite field");
            println!(
                "tilted wall, {scheme}, {tilt_deg} degrees, {setting}: level in dB, delay in s {error:?}"
            );
            for (error, allowed) in error.into_iter().zip(allowed) {
                assert!(
                    error.abs() < allowed,
                    "{scheme}, {tilt_deg} degrees, {setting}: {error}"
                );
            }
        }
    }
}

#[test]
fn a_slanted_wall_scatters_far_less_than_stairs() {
    for scheme in Scheme::ALL {
        let setting = scatter_setting(scheme);
        let [cut, stairs] =
            WallModel::ALL.map(|model| scatter(&setting, scheme, model).expect("a finite field"));
        println!(
            "scatter at 12 degrees, {scheme}, {setting}: cut cells {cut:.1} dB, staircase {stairs:.1} dB"
        );
        assert!(
            cut < stairs - 20.0,
            "{scheme}, {setting}: {cut} dB, stairs {stairs} dB"
        );
    }
}

#[test]
fn a_wall_of_a_simple_slope_echoes_the_same_wherever_it_cuts_the_cells() {
    for scheme in [Scheme::O13, Scheme::D25] {
        for (tilt_deg, _) in SLOPES {
            let setting = tilted_impedance::setting(scheme, tilt_deg, 1.0);
            let stray = stray(&setting, scheme, tilt_deg, 1.0, &PLACES).expect("a finite field");
            println!("tilted wall, {scheme}, {tilt_deg} degrees, met at 45, {setting}: {stray:.4}");
            assert!(
                stray < STRAY,
                "{scheme}, {tilt_deg} degrees, {setting}: {stray}"
            );
        }
    }
}
